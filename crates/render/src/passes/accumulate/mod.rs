//! accumulate: adds this frame's share to the mean of the frames before it, in linear light, from one of two textures to
//! the other (ping-pong).
//!
//! Source: Haeberli & Akeley 1990, "The Accumulation Buffer"; samples of the picture go through the tone curve before
//! they are averaged, for the reason of Karis 2013, "Tone mapping" (a mean of radiance has hard edges where one side is
//! much brighter than the display). Reads: radiance, the previous mean. Writes: the next mean. Radiance of another size
//! than the mean's (`render.scale`) is filtered linearly.

use crate::frame::Shared;
use crate::shader::program::ProgramError;
use crate::tone_curve::Tonemap;
use manypass_graph::{ColorLoad, Graph, Handle};

/// The format of the sum: thousands of frames add up without loss.
pub const SUM: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The uniform of `accumulate.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct AccumulationUniform {
    /// The weight of this frame.
    pub weight: f32,
    /// The weight of the mean before it.
    pub keep: f32,
    /// 1 / width and height of the picture.
    pub inverse_size_px: [f32; 2],
    /// From pre-exposed radiance to what the tone curve takes.
    pub exposure: f32,
    /// Zero.
    pub padding_0: f32,
    /// Zero.
    pub padding_1: f32,
    /// Zero.
    pub padding_2: f32,
}

/// What is averaged over the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Average {
    /// Colours of the display, after this curve.
    Display(Tonemap),
    /// Radiance; pixels that a sample clamped have negative alpha.
    Radiance,
}

/// Records the pass, under the name `name`.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    (name, average): (&'static str, Average),
    radiance: &Handle,
    previous: &Handle,
    next: Handle,
) -> Result<Handle, ProgramError> {
    let mut axes = match average {
        Average::Display(curve) => curve.axes().to_vec(),
        Average::Radiance => vec!["curve_1", "curve_2"],
    };
    if (radiance.desc().width, radiance.desc().height) != (next.desc().width, next.desc().height) {
        axes.push("scaled");
    }
    let step = shared.fullscreen("accumulate", &axes, SUM, None)?;
    let mut pass = graph.pass(name);
    let reads = [("radiance", pass.read(radiance)), ("previous", pass.read(previous))];
    let next = pass.color(next, ColorLoad::Discard);
    pass.draw(move |context| {
        step.draw(context, &reads, &[("accumulation", shared.accumulation.as_entire_binding())]);
    });
    Ok(next)
}
