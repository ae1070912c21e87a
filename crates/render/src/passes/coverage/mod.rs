//! coverage: begins `radiance` where no surface glows: black, and covered where there is an opaque surface.
//!
//! The geometry pass does that of itself, with what surfaces emit. But it shades many pixels several times, and where it
//! would write nothing but black each time, a target of 8 bytes a pixel is spared by covering every pixel once.
//! Reads: depth. Writes: radiance (alpha = coverage).

use crate::gbuffer::RADIANCE;
use crate::record::{PicturePart, Recorder};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, depth: &Handle) -> Result<Handle, ProgramError> {
    let target = r.texture("radiance", RADIANCE);
    let step = r.fullscreen("coverage", "coverage", &[]).over(PicturePart::Surfaces, depth);
    step.draw_into(target, ColorLoad::Clear(wgpu::Color::TRANSPARENT))
}
