//! linear_depth: the distance along the view axis in metres, from the depth attachment, once for all later passes.
//!
//! Reads: depth. Writes: linear_depth (r32float; the background is `DISTANCE_BACKGROUND_M`, which stands for infinity).

use crate::frame::Shared;
use crate::gbuffer::LINEAR_DEPTH;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Graph, Handle, TextureDesc};

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(graph: &mut Graph<'f>, shared: &'f Shared<'f>, depth: &Handle) -> Result<Handle, ProgramError> {
    let (width, height) = shared.size;
    let step = shared.fullscreen("linear_depth", &[], LINEAR_DEPTH, None)?;
    let target = graph.texture("linear_depth", TextureDesc::new_2d(width, height, LINEAR_DEPTH));
    let mut pass = graph.pass("linear_depth");
    let read = pass.read_depth(depth);
    let output = pass.color(target, ColorLoad::Discard);
    pass.draw(move |context| {
        step.draw(
            context,
            &[("depth", read)],
            &[("nearest_clamp", wgpu::BindingResource::Sampler(shared.nearest_clamp))],
        );
    });
    Ok(output)
}
