//! transmittance: how much comes through surfaces of a background that is none of radiance, a colour or nothing, by
//! channel: alpha alone would make coloured glass grey before it.
//!
//! Surfaces that light comes through are drawn once more (`forward::record_transmittance`), before what is uncovered so
//! far. Reads: radiance, for its coverage. Writes: `transmittance`, and at the end `tint`: what is to be added to the share
//! of the background that alpha leaves, plus 1. `tone_map` lays the picture over the background with it.

use crate::gbuffer::RADIANCE;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("transmittance");

/// What is uncovered of a picture so far, whose pixels have one sample; into a texture for as many as are drawn.
///
/// # Errors
/// A program that does not compile.
pub fn record_uncovered(r: &mut Recorder<'_, '_>, radiance: &Handle) -> Result<Handle, ProgramError> {
    let target = r.multisampled("transmittance", RADIANCE);
    let step = r.fullscreen("transmittance.uncovered", "uncovered", &[]).read("radiance", radiance);
    step.draw_into(target, ColorLoad::Discard)
}

/// What alpha does not say, once all is drawn; of pixels with one sample.
///
/// # Errors
/// A program that does not compile.
pub fn record_tint(
    r: &mut Recorder<'_, '_>,
    transmittance: &Handle,
    radiance: &Handle,
) -> Result<Handle, ProgramError> {
    let target = r.texture("tint", RADIANCE);
    let step = r.fullscreen("transmittance.tint", "tint", &[]);
    step.read("transmittance", transmittance).read("radiance", radiance).draw_into(target, ColorLoad::Discard)
}
