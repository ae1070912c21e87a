//! linear_depth: the distance along the view axis in metres, from the depth attachment, once for all later passes.
//!
//! Reads: depth. Writes: linear_depth (r32float; the background is `DISTANCE_BACKGROUND_M`, which stands for infinity).

use crate::gbuffer::LINEAR_DEPTH;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, depth: &Handle) -> Result<Handle, ProgramError> {
    let target = r.texture("linear_depth", LINEAR_DEPTH);
    r.fullscreen("linear_depth", "linear_depth", &[]).read_depth("depth", depth).draw_into(target, ColorLoad::Discard)
}
