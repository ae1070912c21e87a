//! forward: surfaces shaded where they are drawn: blended ones, and with `--path forward` all of them, with the same
//! reflectance model, lights and lists as the deferred path.
//!
//! Source: Olsson et al. 2012 (clustered forward); blending after Porter & Duff 1984, sorted from back to front.
//! Reads: lists of lights, the environment, depth. Writes: radiance (premultiplied), and depth if opaque.

use crate::fog::{FogSettings, FogUniform};
use crate::gbuffer::RADIANCE;
use crate::record::{Recorder, Which};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, DepthLoad, Handle};

/// Radiance and depth of all opaque and masked surfaces.
///
/// # Errors
/// A program that does not compile.
pub fn record_opaque(r: &mut Recorder<'_, '_>, fog: &FogSettings) -> Result<(Handle, Handle), ProgramError> {
    let radiance = r.texture("radiance", RADIANCE);
    let depth = r.texture("geometry.depth", r.frame.gpu.capabilities.depth_format);
    let axes = r.view.light_axes();
    let fog = FogUniform::new(fog, r.view.uniform.pre_exposure);
    let mut pass = r.surfaces("forward.opaque", "forward");
    pass.axes(axes);
    let radiance = pass.color(radiance, ColorLoad::Clear(wgpu::Color::TRANSPARENT));
    let depth = pass.depth(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 });
    pass.uniform("fog", &fog);
    pass.draw_opaque(Which::All)?;
    Ok((radiance, depth))
}

/// Blends the surfaces that alpha covers over `radiance`, behind what `depth` holds.
///
/// # Errors
/// A program that does not compile.
pub fn record_blended(
    r: &mut Recorder<'_, '_>,
    fog: &FogSettings,
    radiance: Handle,
    depth: &Handle,
) -> Result<Handle, ProgramError> {
    if !r.view.has_blended() {
        return Ok(radiance);
    }
    let axes = r.view.light_axes();
    let fog = FogUniform::new(fog, r.view.uniform.pre_exposure);
    let mut pass = r.surfaces("forward", "forward");
    pass.axes(axes);
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_read_only(depth);
    pass.blend(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING);
    pass.uniform("fog", &fog);
    pass.draw_blended()?;
    Ok(radiance)
}
