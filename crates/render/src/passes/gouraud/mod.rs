//! gouraud: surfaces whose light is computed at their vertices, and interpolated in between.
//!
//! Source: Gouraud 1971, "Continuous Shading of Curved Surfaces". Where it differs: base colour, alpha and emission are the
//! pixel's, so that textures stay sharp; lights are those of the object's own list. Reads: lists of lights of objects, the
//! environment, depth. Writes: radiance (premultiplied), and depth if opaque; or, for the report, the numbers of pairs of light and
//! vertex.

use crate::fog::{FogSettings, FogUniform, IN_LIT_FOG};
use crate::gbuffer::LightTarget;
use crate::record::{Recorder, SurfacePass, Which};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, DepthLoad, Handle};

/// Radiance and depth of all opaque and masked surfaces.
///
/// # Errors
/// A program that does not compile.
pub fn record_opaque(r: &mut Recorder<'_, '_>, fog: &FogSettings) -> Result<(Handle, Handle), ProgramError> {
    let radiance = LightTarget::new(r);
    let depth = r.texture("geometry.depth", r.frame.gpu.capabilities.depth_format);
    let (axes, fog) = (r.view.light_axes(), FogUniform::new(fog, r.view.uniform.pre_exposure));
    let counts = r.view.counts_pairs();
    let mut pass = r.surfaces("gouraud.opaque", "gouraud");
    begin(&mut pass, axes, counts);
    pass.uniform("fog", &fog);
    let radiance = radiance.begin(&mut pass);
    let depth = pass.depth(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 });
    pass.draw_opaque(Which::Plain)?;
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
    let is_lit = fog.scatters();
    let view = r.view;
    let (axes, fog) = (view.light_axes(), FogUniform::new(fog, view.uniform.pre_exposure));
    let mut pass = r.surfaces("gouraud", "gouraud");
    begin(&mut pass, axes, view.counts_pairs());
    pass.uniform("fog", &fog);
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_read_only(depth);
    pass.blend(LightTarget::blend_over(view));
    if is_lit {
        pass.constant(IN_LIT_FOG, 1);
    }
    pass.draw_blended()?;
    Ok(radiance)
}

/// What both passes begin with.
fn begin(pass: &mut SurfacePass<'_, '_>, axes: &[&'static str], counts_pairs: bool) {
    pass.axes(axes);
    pass.constant("splits_specular", 1);
    if counts_pairs {
        pass.vertices();
    }
}
