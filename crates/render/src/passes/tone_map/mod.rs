//! tone_map: from the mean over the samples, or from the only one, to the picture: tone curve (unless the samples have
//! it already), background colour, sRGB, dithering.
//!
//! Sources: see `tone_curve.wgsl`; compositing in linear light after Porter & Duff 1984, "over". Reads: the mean of
//! radiance or of display colours, or of both the means of what glows and of all else; of a single sample its radiance,
//! which is filtered linearly where it has another size (`render.scale`). Writes: the output, in display colours. A
//! background colour comes after the curve, so that it is that colour under every curve and at every exposure.

mod settings;

use crate::colour::srgb_from_linear;
use crate::environment::Background;
use crate::pass_info::{PassInfo, Reach};
use crate::record::Recorder;
use crate::shader::program::ProgramError;
pub use crate::tone_curve::Tonemap;
use manypass_graph::{ColorLoad, Handle, TextureDesc};
pub use settings::ToneMapSettings;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { effect_inputs: &["display"], ..PassInfo::new("tone_map") };

/// How far it looks: pictures that are shaded at another size are read between pixels.
pub fn reach(scale: f32) -> Reach {
    if scale == 1.0 { Reach::OwnPixel } else { Reach::EverySample }
}

/// The uniform of `tone_map.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct ToneMapUniform {
    /// The background colour in linear light, if it is one.
    background_linear: [f32; 3],
    /// Amplitude of the dither in steps of 1/255.
    dither: f32,
    /// The background colour at the upper edge of the picture as it shall come out.
    background_srgb: [f32; 3],
    /// Multiplies radiance.
    exposure: f32,
    /// 1 / width and height of the picture.
    inverse_size_px: [f32; 2],
    /// How much of an alpha below 0 counts, turned positive.
    negative_alpha: f32,
    /// 1 if the background goes from one colour to another, else 0.
    is_gradient: f32,
    /// What is to be added to the background colour down to the lower edge.
    background_step_srgb: [f32; 3],
    /// Zero.
    padding: f32,
}

impl ToneMapUniform {
    fn new(Display { exposure, background, is_mean, .. }: Display, dither: f32, output: &TextureDesc) -> Self {
        let background_linear = if let Background::Color(color) = background { color } else { [0.0; 3] };
        // The shader's own encoding may be off by more than a byte's rounding allows on some adapters.
        let encoded = |color: [f32; 3]| color.map(|linear| srgb_from_linear(linear.clamp(0.0, 1.0)));
        let [below_srgb, background_srgb] = background.colors().unwrap_or_default().map(encoded);
        Self {
            background_linear,
            dither,
            background_srgb,
            exposure,
            inverse_size_px: [1.0 / output.width as f32, 1.0 / output.height as f32],
            negative_alpha: if is_mean { 1.0 } else { 0.0 },
            is_gradient: if matches!(background, Background::Gradient(_)) { 1.0 } else { 0.0 },
            background_step_srgb: [0, 1, 2].map(|at| below_srgb[at] - background_srgb[at]),
            padding: 0.0,
        }
    }
}

/// What is shown.
#[derive(Clone, Copy, Debug)]
pub struct DisplayInputs<'h> {
    /// Radiance, or a mean.
    pub radiance: &'h Handle,
    /// The mean of what glows, where that is apart.
    pub glow: Option<&'h Handle>,
    /// The stops by which radiance is exposed beside what is known, in one texel, if exposure adapts.
    pub adapted: Option<&'h Handle>,
    /// What comes through glass of the background beside what alpha says, plus 1, if there is glass before one.
    pub tint: Option<&'h Handle>,
}

/// What is left to do.
#[derive(Clone, Copy, Debug)]
pub struct Display {
    /// The curve that the samples did not go through yet.
    pub curve: Tonemap,
    /// What their radiance is multiplied by; 1 where they went through the curve.
    pub exposure: f32,
    /// What lies behind.
    pub background: Background,
    /// Whether it is for a mean, in which negative alpha marks clamped pixels, or for the radiance of one frame.
    pub is_mean: bool,
    /// Whether what is written is the picture; otherwise linear colours, multiplied by alpha, for effects to go on with.
    pub encodes: bool,
}

/// What is left of linear colours that effects went on with.
pub const ENCODING: Display =
    Display { curve: Tonemap::None, exposure: 1.0, background: Background::Transparent, is_mean: false, encodes: true };

/// Records the pass under the name `name`.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    name: &'static str,
    settings: &ToneMapSettings,
    left: Display,
    DisplayInputs { radiance, glow, adapted, tint }: DisplayInputs<'_>,
    output: Handle,
) -> Result<Handle, ProgramError> {
    let (from, to) = (radiance.desc(), output.desc());
    let is_scaled = (from.width, from.height) != (to.width, to.height);
    let curve = left.curve.constant();
    let over_color = left.background.colors().is_some();
    let encodes = u32::from(left.encodes);
    let uniform = ToneMapUniform::new(left, settings.dither, &to);
    let step = r
        .fullscreen(name, "tone_map", &[])
        .constants(&[curve, ("over_color", u32::from(over_color)), ("encodes", encodes)])
        .constants(&[("scaled", u32::from(is_scaled)), ("has_glow", u32::from(glow.is_some()))])
        .constant("adapts", u32::from(adapted.is_some()))
        .uniform("tone_map", &uniform)
        .read("radiance", radiance);
    let step = if is_scaled { step.read("filtered", radiance) } else { step.stand_in("filtered") };
    let step = match glow {
        Some(glow) => step.read("glow", glow),
        None => step.stand_in("glow"),
    };
    let step = match adapted {
        Some(adapted) => step.read("adapted", adapted),
        None => step.stand_in("adapted"),
    };
    let step = match tint {
        Some(tint) => step.constant("has_tint", 1).read("tint", tint),
        None => step.stand_in("tint"),
    };
    step.draw_into(output, ColorLoad::Discard)
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
            [
                background_linear,
                dither,
                background_srgb,
                exposure,
                inverse_size_px,
                negative_alpha,
                is_gradient,
                background_step_srgb,
                padding
            ]
        );
    }
}
