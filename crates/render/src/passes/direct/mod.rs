//! direct: every light that reaches a pixel, added to `radiance`.
//!
//! Source: clustered shading (Olsson et al. 2012), lists in data textures. Reads: G-buffer, depth, lists of lights. Writes:
//! radiance; or, for the report, the numbers of pairs of pixel and light.

use crate::gbuffer::Gbuffer;
use crate::record::{ADD, PicturePart, Recorder};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// Visited, shaded and in range, one pixel's numbers in one texel.
pub const PAIRS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    gbuffer: &Gbuffer,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if r.view.light_count == 0 {
        return Ok(radiance);
    }
    let step = gbuffer.read_by(r.fullscreen("direct", "direct", r.view.light_axes()));
    step.over(PicturePart::Surfaces, depth).blend(ADD).draw_into(radiance, ColorLoad::Keep)
}

/// Records a pass that counts pairs instead of shading them.
///
/// # Errors
/// A program that does not compile.
pub fn record_counting(r: &mut Recorder<'_, '_>, gbuffer: &Gbuffer) -> Result<Handle, ProgramError> {
    let target = r.texture("direct.pairs", PAIRS);
    gbuffer.read_by(r.fullscreen("direct.pairs", "direct", &["counting"])).draw_into(target, ColorLoad::Discard)
}
