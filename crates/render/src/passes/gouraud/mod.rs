//! gouraud: surfaces whose light is computed at their vertices, and interpolated in between.
//!
//! Source: Gouraud 1971, "Continuous Shading of Curved Surfaces". Where it differs: base colour, alpha and emission
//! are the pixel's, so that textures stay sharp; lights are those of the object's own list. Reads: lists of lights
//! of objects, the environment, depth, and as `forward` the distances of the nearest surfaces that light comes
//! through. Writes: radiance (premultiplied), and depth if opaque; or, for the report, the numbers of pairs of light
//! and vertex.

use crate::fog::{FogSettings, FogUniform, IN_LIT_FOG};
use crate::gbuffer::LightTarget;
use crate::pass_info::PassInfo;
use crate::record::{DrawSelection, Recorder, SurfacePass};
use crate::render_settings::Path;
use crate::shader::program::ProgramError;
use crate::transparency::{BlendTargets, Peel, Side, Weighting};
use manypass_graph::{DepthLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo =
    PassInfo { paths: &[Path::Gouraud], effect_inputs: &["radiance"], ..PassInfo::new("gouraud") };

/// Radiance and depth of all opaque and masked surfaces, from depth that is begun and loaded so.
///
/// # Errors
/// A program that does not compile.
pub fn record_opaque(
    r: &mut Recorder<'_, '_>,
    fog: &FogSettings,
    (depth, depth_load): (Handle, DepthLoad),
) -> Result<(Handle, Handle), ProgramError> {
    let radiance = LightTarget::new(r);
    let (axes, fog) = (r.view.light_axes(), FogUniform::new(fog, r.view.uniform.pre_exposure));
    let counts = r.view.counts_pairs();
    let mut pass = r.surfaces("gouraud.opaque", "gouraud");
    begin(&mut pass, axes, counts);
    pass.uniform("fog", &fog);
    Weighting::default().bind(&mut pass, None);
    let radiance = radiance.begin(&mut pass);
    pass.leave_out_settled();
    let depth = pass.depth(depth, depth_load);
    pass.draw_opaque(DrawSelection::Plain)?;
    Ok((radiance, depth))
}

/// Draws the surfaces that alpha covers, or what `peel` says of them, into what `blended` says. Returns what holds the
/// result.
///
/// # Errors
/// A program that does not compile.
pub fn record_blended(
    r: &mut Recorder<'_, '_>,
    fog: &FogSettings,
    blended: BlendTargets,
    peel: Option<Peel<'_>>,
) -> Result<BlendTargets, ProgramError> {
    let (view, weighting) = (r.view, blended.weighting(r));
    let is_lit = fog.scatters();
    let (axes, fog) = (view.light_axes(), FogUniform::new(fog, view.uniform.pre_exposure));
    let is_behind = peel.is_some_and(|peel| peel.side == Side::Behind);
    let mut pass = r.surfaces(if is_behind { "gouraud.behind" } else { "gouraud" }, "gouraud");
    begin(&mut pass, axes, view.counts_pairs());
    pass.uniform("fog", &fog);
    weighting.bind(&mut pass, peel);
    let blended = blended.begin(&mut pass, view);
    if is_lit {
        pass.constant(IN_LIT_FOG, 1);
    }
    pass.draw_blended()?;
    Ok(blended)
}

/// What both passes begin with.
fn begin(pass: &mut SurfacePass<'_, '_>, axes: &[&'static str], counts_pairs: bool) {
    pass.axes(axes);
    pass.constant("splits_specular", 1);
    if counts_pairs {
        pass.vertices();
    }
}
