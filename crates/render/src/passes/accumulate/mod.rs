//! accumulate: adds this frame's share to the sum of the frames before it, in linear light, from one of two textures to
//! the other (ping-pong).
//!
//! Source: Haeberli & Akeley 1990, "The Accumulation Buffer". Reads: radiance, the previous sum. Writes: the next sum.
//! Radiance of another size than the sum's (`render.scale`) is filtered linearly.

use crate::frame::Shared;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Graph, Handle};

/// The format of the sum: thousands of frames add up without loss.
pub const SUM: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    radiance: &Handle,
    previous: &Handle,
    next: Handle,
) -> Result<Handle, ProgramError> {
    let shaded_size = (radiance.desc().width, radiance.desc().height);
    let is_scaled = shaded_size != (next.desc().width, next.desc().height);
    let axes: &[&'static str] = if is_scaled { &["scaled"] } else { &[] };
    let step = shared.fullscreen("accumulate", axes, SUM, None)?;
    let mut pass = graph.pass("accumulate");
    let reads = [("radiance", pass.read(radiance)), ("previous", pass.read(previous))];
    let next = pass.color(next, ColorLoad::Discard);
    pass.draw(move |context| {
        step.draw(context, &reads, &[("accumulation", shared.accumulation.as_entire_binding())]);
    });
    Ok(next)
}
