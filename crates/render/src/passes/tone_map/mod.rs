//! tone_map: from the mean over the samples to the picture: tone curve (unless the samples have it already), background
//! colour, sRGB, dithering.
//!
//! Sources: see `tone_curve.wgsl`; compositing in linear light after Porter & Duff 1984, "over". Reads: the mean of
//! radiance or of display colours. Writes: the output, in display colours. A background colour comes after the curve, so
//! that it is that colour under every curve and at every exposure.

mod settings;

use crate::colour::srgb_from_linear;
use crate::environment::Background;
use crate::frame::Shared;
use crate::shader::program::ProgramError;
pub use crate::tone_curve::Tonemap;
use manypass_graph::{ColorLoad, Graph, Handle};
pub use settings::ToneMapSettings;

/// The uniform of `tone_map.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ToneMapUniform {
    /// The background colour in linear light.
    pub background_linear: [f32; 3],
    /// Amplitude of the dither in steps of 1/255.
    pub dither: f32,
    /// The background colour as it shall come out.
    pub background_srgb: [f32; 3],
    /// Multiplies radiance.
    pub exposure: f32,
}

impl ToneMapUniform {
    /// For a picture before `background`.
    pub fn new(background: Background, dither: f32, exposure: f32) -> Self {
        let background_linear = if let Background::Color(color) = background { color } else { [0.0; 3] };
        // The shader's own encoding may be off by more than a byte's rounding allows on some adapters.
        let background_srgb = background_linear.map(|linear: f32| srgb_from_linear(linear.clamp(0.0, 1.0)));
        Self { background_linear, dither, background_srgb, exposure }
    }
}

/// Records the pass; `curve` is that which the samples did not go through yet.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    curve: Tonemap,
    mean: &Handle,
    output: Handle,
) -> Result<Handle, ProgramError> {
    let mut axes = curve.axes().to_vec();
    if matches!(shared.background, Background::Color(_)) {
        axes.push("over_color");
    }
    let step = shared.fullscreen("tone_map", &axes, output.desc().format, None)?;
    let mut pass = graph.pass("tone_map");
    let reads = [("radiance", pass.read(mean))];
    let output = pass.color(output, ColorLoad::Discard);
    pass.draw(move |context| step.draw(context, &reads, &[("tone_map", shared.tone_map.as_entire_binding())]));
    Ok(output)
}
