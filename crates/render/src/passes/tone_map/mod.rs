//! tone_map: from the mean over the samples to the picture: tone curve (unless the samples have it already), background
//! colour, sRGB, dithering.
//!
//! Sources: see `tone_curve.wgsl`; compositing in linear light after Porter & Duff 1984, "over". Reads: the mean of
//! radiance or of display colours. Writes: the output, in display colours. A background colour comes after the curve, so
//! that it is that colour under every curve and at every exposure.

mod settings;

use crate::colour::srgb_from_linear;
use crate::environment::Background;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
pub use crate::tone_curve::Tonemap;
use manypass_graph::{ColorLoad, Handle};
pub use settings::ToneMapSettings;

/// The uniform of `tone_map.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct ToneMapUniform {
    /// The background colour in linear light.
    background_linear: [f32; 3],
    /// Amplitude of the dither in steps of 1/255.
    dither: f32,
    /// The background colour as it shall come out.
    background_srgb: [f32; 3],
    /// Multiplies radiance.
    exposure: f32,
}

impl ToneMapUniform {
    fn new(background: Background, dither: f32, exposure: f32) -> Self {
        let background_linear = if let Background::Color(color) = background { color } else { [0.0; 3] };
        // The shader's own encoding may be off by more than a byte's rounding allows on some adapters.
        let background_srgb = background_linear.map(|linear: f32| srgb_from_linear(linear.clamp(0.0, 1.0)));
        Self { background_linear, dither, background_srgb, exposure }
    }
}

/// What is left to do for a mean.
#[derive(Clone, Copy, Debug)]
pub struct Display {
    /// The curve that the samples did not go through yet.
    pub curve: Tonemap,
    /// What their radiance is multiplied by; 1 where they went through the curve.
    pub exposure: f32,
    /// What lies behind.
    pub background: Background,
}

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &ToneMapSettings,
    Display { curve, exposure, background }: Display,
    mean: &Handle,
    output: Handle,
) -> Result<Handle, ProgramError> {
    let mut axes = curve.axes().to_vec();
    if matches!(background, Background::Color(_)) {
        axes.push("over_color");
    }
    r.fullscreen("tone_map", "tone_map", &axes)
        .read("radiance", mean)
        .uniform("tone_map", &ToneMapUniform::new(background, settings.dither, exposure))
        .draw_into(output, ColorLoad::Discard)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "tone_map",
            "ToneMap",
            ToneMapUniform,
            [background_linear, dither, background_srgb, exposure]
        );
    }
}
