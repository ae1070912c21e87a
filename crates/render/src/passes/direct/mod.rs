//! direct: every light that reaches a pixel, added to `radiance`.
//!
//! Source: clustered shading (Olsson et al. 2012), lists in data textures. Reads: G-buffer, depth, lists of lights. Writes:
//! radiance; or, for the report, the numbers of pairs of pixel and light.

use crate::frame::{ADD, PicturePart, Shared};
use crate::gbuffer::Gbuffer;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Graph, Handle, TextureDesc};

/// Visited, shaded and in range, one pixel's numbers in one texel.
pub const PAIRS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    gbuffer: &Gbuffer,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if shared.light_count == 0 {
        return Ok(radiance);
    }
    let step = shared.fullscreen_over(PicturePart::Surfaces, "direct", Some(ADD))?;
    let mut pass = graph.pass("direct");
    let reads = gbuffer.read(&mut pass);
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_stencil_read_only(depth);
    pass.draw(move |context| step.draw(context, &reads.named(), &[]));
    Ok(radiance)
}

/// Records a pass that counts pairs instead of shading them.
///
/// # Errors
/// A program that does not compile.
pub fn record_counting<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    gbuffer: &Gbuffer,
) -> Result<Handle, ProgramError> {
    let (width, height) = shared.size;
    let step = shared.fullscreen("direct", &["counting"], PAIRS, None)?;
    let target = graph.texture("direct.pairs", TextureDesc::new_2d(width, height, PAIRS));
    let mut pass = graph.pass("direct.pairs");
    let reads = gbuffer.read(&mut pass);
    let pairs = pass.color(target, ColorLoad::Discard);
    pass.draw(move |context| step.draw(context, &reads.named(), &[]));
    Ok(pairs)
}
