//! meter: the radiance of a small frame in a format that every backend can read back; half floats are none on WebGL 2.
//!
//! Reads: radiance. Writes: meter. [`crate::Renderer::meter`] alone records it.

use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What is read back.
pub const METER: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, radiance: &Handle) -> Result<Handle, ProgramError> {
    let target = r.texture("meter", METER);
    r.fullscreen("meter", "meter", &[]).read("radiance", radiance).draw_into(target, ColorLoad::Discard)
}
