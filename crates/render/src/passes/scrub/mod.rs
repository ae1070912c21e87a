//! scrub: radiance without what is no number, or infinite, before effects look at the pixels beside it: a blur would spread
//! one such pixel over all of the picture. Recorded where such effects follow the surfaces, or an effect of the user's.
//!
//! Reads: radiance. Writes: radiance (pre-exposed).

use crate::gbuffer::RADIANCE;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// Records the pass, the one after `before` others of the view; of display colours, too.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, before: u32, radiance: &Handle) -> Result<Handle, ProgramError> {
    let name = if before == 0 { "scrub".to_owned() } else { format!("scrub.{}", before + 1) };
    let target = r.texture_of(name.clone(), TextureDesc { format: RADIANCE, ..radiance.desc() });
    r.fullscreen(name, "scrub", &[]).read("radiance", radiance).draw_into(target, ColorLoad::Discard)
}
