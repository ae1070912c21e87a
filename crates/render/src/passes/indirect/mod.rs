//! indirect: light from the environment, added to `radiance`.
//!
//! Source: split sum (Karis 2013) of the environment. Reads: G-buffer, depth, occlusion, reflections that an
//! earlier sample of a still found. Writes: radiance.

use crate::gbuffer::Gbuffer;
use crate::pass_info::PassInfo;
use crate::record::{ADD, PicturePart, Recorder};
use crate::screen_space::ScreenSpaceEffects;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { effect_inputs: &["radiance"], ..PassInfo::deferred("indirect") };

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    gbuffer: &Gbuffer,
    found: ScreenSpaceEffects<'_>,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if r.view.is_environment_dark {
        return Ok(radiance);
    }
    let step = found.read_by(gbuffer.read_by_light(r.fullscreen("indirect", "indirect", &[]), depth));
    step.over(PicturePart::Lit, depth).blend(ADD).draw_into(radiance, ColorLoad::Keep)
}
