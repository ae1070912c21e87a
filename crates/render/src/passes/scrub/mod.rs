//! scrub: radiance without what is no number, or infinite, before effects look at the pixels beside it: a blur would spread
//! one such pixel over all of the picture. Recorded where such effects follow the surfaces, or an effect of the user's.
//!
//! Reads: radiance. Writes: radiance (pre-exposed); or, in a frame of its own that counts such pixels
//! ([`crate::Renderer::count_scrubbed`]), 1 where there is one.

use crate::gbuffer::RADIANCE;
use crate::pass_info::PassInfo;
use crate::record::{Recorder, Texels};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("scrub");

/// Of which pixels are scrubbed.
const COUNT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Records the pass, the one after `before` others of the view; of display colours, too.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, before: u32, radiance: &Handle) -> Result<Handle, ProgramError> {
    let name = if before == 0 { "scrub".to_owned() } else { format!("scrub.{}", before + 1) };
    count(r, format!("{name}.count"), radiance)?;
    let target = r.texture_of(name.clone(), TextureDesc { format: RADIANCE, ..radiance.desc() });
    r.fullscreen(name, "scrub", &[]).read("radiance", radiance).draw_into(target, ColorLoad::Discard)
}

/// Records the pass that finds what is scrubbed of `radiance`, in a frame that counts that; in others nothing.
///
/// # Errors
/// A program that does not compile.
pub fn count(r: &mut Recorder<'_, '_>, name: String, radiance: &Handle) -> Result<(), ProgramError> {
    if !r.frame.scrubbed.is_counted() {
        return Ok(());
    }
    let target = r.texture_of(name.clone(), TextureDesc { format: COUNT, ..radiance.desc() });
    r.declare_texels(&target, Texels::Share);
    let step = r.fullscreen(name, "scrub", &[]).constant("counts", 1).read("radiance", radiance);
    let found = step.draw_into(target, ColorLoad::Discard)?;
    let export = r.graph.export(found);
    r.frame.scrubbed.add(export);
    Ok(())
}
