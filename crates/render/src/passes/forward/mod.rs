//! forward: surfaces shaded where they are drawn: blended ones, and with `--path forward` all of them, with the same
//! reflectance model, lights and lists as the deferred path.
//!
//! Source: Olsson et al. 2012 (clustered forward); blending after Porter & Duff 1984, sorted from back to front.
//! Reads: lists of lights, the environment, depth. Writes: radiance (premultiplied), and depth if opaque.

use crate::frame::Shared;
use crate::gbuffer::RADIANCE;
use crate::shader::program::ProgramError;
use crate::surfaces::{self, Targets};
use manypass_graph::{ColorLoad, DepthLoad, Graph, Handle, TextureDesc};

/// Radiance and depth of all opaque and masked surfaces.
///
/// # Errors
/// A program that does not compile.
pub fn record_opaque<'f>(graph: &mut Graph<'f>, shared: &'f Shared<'f>) -> Result<(Handle, Handle), ProgramError> {
    let (width, height) = shared.size;
    let targets = Targets { colors: vec![RADIANCE], blend: None, depth: shared.depth_format, depth_write: true };
    let draws = surfaces::prepare(shared, "forward", &targets, &shared.draws.opaque)?;
    let radiance = graph.texture("radiance", TextureDesc::new_2d(width, height, RADIANCE));
    let depth = graph.texture("geometry.depth", TextureDesc::new_2d(width, height, shared.depth_format));
    let mut pass = graph.pass("forward.opaque");
    let radiance = pass.color(radiance, ColorLoad::Clear(wgpu::Color::TRANSPARENT));
    let depth = pass.depth_stencil(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 });
    pass.draw(move |context| surfaces::draw(context, shared.resources, shared.instances, &draws));
    Ok((radiance, depth))
}

/// Blends the surfaces that alpha covers over `radiance`, behind what `depth` holds.
///
/// # Errors
/// A program that does not compile.
pub fn record_blended<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    radiance: Handle,
    depth: &Handle,
) -> Result<Handle, ProgramError> {
    if shared.draws.blended.is_empty() {
        return Ok(radiance);
    }
    let targets = Targets {
        colors: vec![RADIANCE],
        blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        depth: shared.depth_format,
        depth_write: false,
    };
    let draws = surfaces::prepare(shared, "forward", &targets, &shared.draws.blended)?;
    let mut pass = graph.pass("forward");
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_stencil_read_only(depth);
    pass.draw(move |context| surfaces::draw(context, shared.resources, shared.instances, &draws));
    Ok(radiance)
}
