//! volumes: light by drawing a sphere or cone around all that each light reaches. Lights without a range are not among
//! them.
//!
//! Source: light volumes (Hargreaves & Harris 2004, "Deferred Shading"); the stencil of shadow volumes (Carmack's
//! z-fail) for light volumes (Arvo & Barkans 2003; the public WebGL 2 deferred renderers). Back faces are drawn, so
//! that the eye may be inside. Where it differs: meshes are convex, so that one bit of the stencil is inverted in place
//! of counting, and volumes which cover no part of the picture together are marked and shaded together; each class of
//! lights has a draw with a shader of its own. Reads: G-buffer, depth, the volumes of the view. Writes: radiance; or,
//! for the report, the numbers of pairs of pixel and light.

use crate::gbuffer::Gbuffer;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::Handle;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { effect_inputs: &["radiance"], ..PassInfo::deferred("volumes") };

/// Adds the light of all volumes to `radiance`. Returns it, and depth with a stencil of 0.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    gbuffer: &Gbuffer,
    depth: Handle,
    radiance: Handle,
) -> Result<(Handle, Handle), ProgramError> {
    let view = r.view;
    if view.volume_draws.is_empty() {
        return Ok((radiance, depth));
    }
    let step = gbuffer.read_by(r.fullscreen("volumes", "volumes", view.light_axes()));
    step.table("light_reaches", &view.light_reaches).draw_volumes(radiance, depth, "volumes_mark", &view.volume_draws)
}
