//! coverage: begins `radiance` where no surface glows: black, and covered where there is an opaque surface.
//!
//! The geometry pass does that of itself, with what surfaces emit. But it shades many pixels several times, and where
//! it would write nothing but black each time, a target of 8 bytes a pixel is spared by covering every pixel once.
//! Where masks say by alpha how many samples of a pixel they cover, it ends what that leaves.
//! Reads: depth. Writes: radiance (alpha = coverage).

use crate::gbuffer::RADIANCE;
use crate::pass_info::PassInfo;
use crate::record::{ADD, PicturePart, Recorder};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("coverage");

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, depth: &Handle) -> Result<Handle, ProgramError> {
    let target = r.texture("radiance", RADIANCE);
    let step = r.fullscreen("coverage", "coverage", &[]).over(PicturePart::Surfaces, depth);
    step.draw_into(target, ColorLoad::Clear(wgpu::Color::TRANSPARENT))
}

/// Radiance stays, and coverage becomes 1 where it is less.
const AT_LEAST: wgpu::BlendState = wgpu::BlendState {
    color: ADD.color,
    alpha: wgpu::BlendComponent { operation: wgpu::BlendOperation::Max, ..ADD.alpha },
};

/// Covers the samples of masks: each is covered wholly or not at all, but alpha is what said how many are, and lies in
/// all of them.
///
/// # Errors
/// A program that does not compile.
pub fn record_masks(r: &mut Recorder<'_, '_>, depth: &Handle, radiance: Handle) -> Result<Handle, ProgramError> {
    if r.view.pixel_samples == 1 || !r.view.has_masked(r.frame.world) {
        return Ok(radiance);
    }
    let step = r.fullscreen("coverage.masks", "coverage", &[]).over(PicturePart::Surfaces, depth);
    step.blend(AT_LEAST).draw_into(radiance, ColorLoad::Keep)
}
