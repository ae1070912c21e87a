//! emission: keeps what surfaces emit, before light is added to it. Recorded only when the variable is asked for.
//!
//! Reads: radiance right after the geometry pass. Writes: emission (pre-exposed).

use crate::frame::Shared;
use crate::gbuffer::RADIANCE;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Graph, Handle, TextureDesc};

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(graph: &mut Graph<'f>, shared: &'f Shared<'f>, radiance: &Handle) -> Result<Handle, ProgramError> {
    let (width, height) = shared.size;
    let step = shared.fullscreen("emission", &[], RADIANCE, None)?;
    let target = graph.texture("emission", TextureDesc::new_2d(width, height, RADIANCE));
    let mut pass = graph.pass("emission");
    let reads = [("radiance", pass.read(radiance))];
    let emission = pass.color(target, ColorLoad::Discard);
    pass.draw(move |context| step.draw(context, &reads, &[]));
    Ok(emission)
}
