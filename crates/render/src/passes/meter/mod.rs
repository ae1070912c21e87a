//! meter: the radiance of a small frame in a format that every backend can read back; half floats are none on WebGL 2.
//!
//! Reads: radiance. Writes: meter. [`crate::Renderer::meter`] alone records it.

use crate::frame::Shared;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Graph, Handle, TextureDesc};

/// What is read back.
pub const METER: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(graph: &mut Graph<'f>, shared: &'f Shared<'f>, radiance: &Handle) -> Result<Handle, ProgramError> {
    let (width, height) = shared.size;
    let step = shared.fullscreen("meter", &[], METER, None)?;
    let target = graph.texture("meter", TextureDesc::new_2d(width, height, METER));
    let mut pass = graph.pass("meter");
    let reads = [("radiance", pass.read(radiance))];
    let meter = pass.color(target, ColorLoad::Discard);
    pass.draw(move |context| step.draw(context, &reads, &[]));
    Ok(meter)
}
