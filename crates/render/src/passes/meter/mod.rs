//! meter: the radiance of a small frame in a format that every backend can read back (half floats are none on WebGL 2);
//! and how bright a frame is on the average, in squares of 8 × 8 texels until one is left, from which exposure follows
//! without reading anything back.
//!
//! Sources: Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images" (the average); Krawczyk et al. 2005,
//! "Perceptual Effects in Real-time Tone Mapping" (adaptation by an exponential curve, and a pyramid). Reads: radiance,
//! and what the last frame left. Writes: meter, which [`crate::Renderer::meter`] alone records; or `meter.luminance`, and
//! `meter.adapted` (one texel, r32float: stops), which the next frame finds.

use crate::constants::METERED_SIDE;
use crate::pass_info::PassInfo;
use crate::record::{Fullscreen, Recorder, Texels};
use crate::shader::program::ProgramError;
use bytemuck::Zeroable;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("meter");

/// What is read back.
pub const METER: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Sums of logarithms and of weights.
const LUMINANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

/// Stops.
const STOPS: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// The uniform of `meter.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct MeterUniform {
    /// The size of radiance.
    size_px: [f32; 2],
    /// The standard deviation of weights around the middle, or the radius of the spot.
    radius_px: f32,
    /// What radiance was multiplied by, as a power of 2.
    pre_exposure_stops: f32,
    /// Between these is what comes out.
    stops_min: f32,
    stops_max: f32,
    /// What is left of the difference from what is wanted, where the picture becomes darker, and where brighter.
    keep_to_light: f32,
    keep_to_dark: f32,
    /// 1 if there is no frame before.
    begins: f32,
    /// Zero.
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

/// How exposure goes on from that of the frame before.
#[derive(Clone, Copy, Debug)]
pub struct AdaptationStep {
    /// The shader's number of the pattern of weights.
    pub pattern: u32,
    /// Its standard deviation or radius as a share of the shorter side.
    pub radius: f32,
    /// What radiance was multiplied by, as a power of 2.
    pub pre_exposure_stops: f32,
    /// The least and the most stops.
    pub stops: [f32; 2],
    /// What is left of the difference from what is wanted, where the picture becomes darker, and where brighter; none
    /// where it stays as it is.
    pub keep: Option<[f32; 2]>,
    /// Whether there is no frame before: exposure is then at once what is wanted.
    pub begins: bool,
}

/// Of a share of the shorter side of a picture as much as a pixel, so that one counts in any case.
pub fn radius_px(share: f32, (width, height): (u32, u32)) -> f32 {
    (width.min(height) as f32 * share).max(1.0)
}

impl MeterUniform {
    fn new(adapting: &AdaptationStep, size: (u32, u32)) -> Self {
        let [keep_to_light, keep_to_dark] = adapting.keep.unwrap_or([1.0; 2]).map(|keep| match adapting.begins {
            true => 0.0,
            false => keep,
        });
        Self {
            size_px: [size.0 as f32, size.1 as f32],
            radius_px: radius_px(adapting.radius, size),
            pre_exposure_stops: adapting.pre_exposure_stops,
            stops_min: adapting.stops[0],
            stops_max: adapting.stops[1],
            keep_to_light,
            keep_to_dark,
            begins: if adapting.begins { 1.0 } else { 0.0 },
            ..Self::zeroed()
        }
    }
}

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, radiance: &Handle) -> Result<Handle, ProgramError> {
    let target = r.texture("meter", METER);
    let step = r.fullscreen("meter", "meter", &[]).uniform("meter", &MeterUniform::zeroed());
    step.stand_in("previous").read("radiance", radiance).draw_into(target, ColorLoad::Discard)
}

/// Records the passes that meter `radiance` and let exposure go on. Returns its stops, in one texel.
///
/// # Errors
/// A program that does not compile.
pub fn record_adapted(
    r: &mut Recorder<'_, '_>,
    adapting: &AdaptationStep,
    radiance: &Handle,
) -> Result<Handle, ProgramError> {
    let history = r.graph.history("meter.adapted", TextureDesc::new_2d(1, 1, STOPS));
    r.declare_texels(&history.next, Texels::Number);
    let adapting = AdaptationStep { begins: adapting.begins || history.is_first, ..*adapting };
    let TextureDesc { mut width, mut height, .. } = radiance.desc();
    let uniform = MeterUniform::new(&adapting, (width, height));
    fn with<'r, 'f>(step: Fullscreen<'r, 'f>, adapting: &AdaptationStep, reduces: u32) -> Fullscreen<'r, 'f> {
        step.constants(&[("pattern", adapting.pattern), ("reduces", reduces)])
    }
    let mut mean: Option<Handle> = None;
    let side = METERED_SIDE as u32;
    let is_metered = adapting.keep.is_some() || adapting.begins;
    while is_metered && width.max(height) > side {
        (width, height) = (width.div_ceil(side), height.div_ceil(side));
        let name = format!("meter.luminance.{width}x{height}");
        let target = r.texture_of(name.clone(), TextureDesc::new_2d(width, height, LUMINANCE));
        // The mean of logarithms, and how much it counts.
        r.declare_texels(&target, Texels::Number);
        let step = r.fullscreen(name, "meter", &[]).uniform("meter", &uniform).stand_in("previous");
        let step = with(step, &adapting, if mean.is_some() { 2 } else { 1 });
        mean = Some(step.read("radiance", mean.as_ref().unwrap_or(radiance)).draw_into(target, ColorLoad::Discard)?);
    }
    let step = r.fullscreen("meter.adapted", "meter", &[]).uniform("meter", &uniform).constant("adapts", 1);
    let step = with(step, &adapting, if mean.is_some() { 2 } else { 1 }).read("previous", &history.previous);
    // What stays as it is needs no mean, but something has to be bound.
    let step =
        if is_metered { step.read("radiance", mean.as_ref().unwrap_or(radiance)) } else { step.stand_in("radiance") };
    step.draw_into(history.next, ColorLoad::Discard)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "meter",
            "Meter",
            MeterUniform,
            [
                size_px,
                radius_px,
                pre_exposure_stops,
                stops_min,
                stops_max,
                keep_to_light,
                keep_to_dark,
                begins,
                padding_0,
                padding_1,
                padding_2
            ]
        );
    }
}
