//! background: what lies behind all surfaces, blended under `radiance` by its coverage.
//!
//! Source: the operator "under" of Porter & Duff 1984. Reads: the environment, depth. Writes: radiance.

use crate::frame::{PicturePart, Shared};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Graph, Handle};

const UNDER: wgpu::BlendState = {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::OneMinusDstAlpha,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState { color: component, alpha: component }
};

/// Records the pass; a transparent background needs none.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if shared.transparent {
        return Ok(radiance);
    }
    let step = shared.fullscreen_over(PicturePart::Background, "background", UNDER)?;
    let mut pass = graph.pass("background");
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_stencil_read_only(depth);
    pass.draw(move |context| step.draw(context, &[], &[]));
    Ok(radiance)
}
