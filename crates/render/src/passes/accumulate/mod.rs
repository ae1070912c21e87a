//! accumulate: adds this frame's share to the mean of the frames before it, in linear light, from one of two textures
//! to the other (ping-pong).
//!
//! Source: Haeberli & Akeley 1990, "The Accumulation Buffer"; samples of the picture go through the tone curve before
//! they are averaged, for the reason of Karis 2013, "Tone mapping" (a mean of radiance has hard edges where one side is
//! much brighter than the display). Reads: radiance, the previous mean. Writes: the next mean. Radiance of another size
//! than the mean's (`render.scale`) is filtered linearly. Where lights take turns, a sample's radiance is one of many
//! that only together are right, and goes through the curve when all are there; but what glows has its own light in
//! every sample, and has a mean of its own, of display colours.

use crate::pass_info::PassInfo;
use crate::record::{Fullscreen, PicturePart, Recorder};
use crate::shader::program::ProgramError;
use crate::tone_curve::Tonemap;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { variables: &["radiance"], ..PassInfo::new("accumulate") };

/// The format of the sum: thousands of frames add up without loss.
pub const SUM: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The uniform of `accumulate.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct AccumulationUniform {
    /// The weight of this frame.
    weight: f32,
    /// The weight of the mean before it.
    keep: f32,
    /// 1 / width and height of the picture.
    inverse_size_px: [f32; 2],
    /// From pre-exposed radiance to what the tone curve takes.
    exposure: f32,
    /// How much of a sample counts that does not glow.
    share: f32,
    /// How much more of one that does.
    share_of_glow: f32,
    /// Zero.
    padding: f32,
}

/// What is averaged over the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Average {
    /// Colours of the display, after this curve.
    Display(Tonemap),
    /// Radiance; pixels that a sample clamped have negative alpha.
    Radiance,
}

/// Of which part of every sample it is the mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplePart {
    /// Of all of it, whose alpha is coverage and nothing else.
    Whole,
    /// Of all of it, in which what glows is marked.
    Marked,
    /// Of what glows.
    Glow,
    /// Of all else.
    Rest,
}

/// A frame's share of a mean.
#[derive(Clone, Copy, Debug)]
pub struct Share {
    /// What is averaged.
    pub average: Average,
    /// Of what.
    pub part: SamplePart,
    /// How many frames the mean holds already.
    pub sample_index: u32,
    /// From pre-exposed radiance to what the tone curve takes.
    pub exposure: f32,
}

/// The mean of the frames so far, and where that with this frame goes.
#[derive(Debug)]
pub struct Mean {
    /// What the frames before left; none if this is the only one.
    pub previous: Option<Handle>,
    /// What this frame leaves.
    pub next: Handle,
}

/// Records the pass, under the name `name`.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    name: &'static str,
    share: Share,
    radiance: &Handle,
    mean: Mean,
) -> Result<Handle, ProgramError> {
    let (step, next) = prepare(r, name, share, radiance, mean);
    step.draw_into(next, ColorLoad::Discard)
}

/// As [`record`], but where the view leaves tiles out, which `depth` tells, their mean stays as it is: that of this
/// texture is of one sample less, or more, than that of the other.
///
/// # Errors
/// A program that does not compile.
pub fn record_unsettled(
    r: &mut Recorder<'_, '_>,
    share: Share,
    radiance: &Handle,
    depth: &Handle,
    mean: Mean,
) -> Result<Handle, ProgramError> {
    let leaves_out = r.view.settled.is_some();
    let (step, next) = prepare(r, "accumulate", share, radiance, mean);
    if leaves_out {
        return step.over(PicturePart::Unsettled, depth).draw_into(next, ColorLoad::Keep);
    }
    step.draw_into(next, ColorLoad::Discard)
}

/// The pass, and the texture that it draws into.
fn prepare<'r, 'f>(
    r: &'r mut Recorder<'_, 'f>,
    name: &'static str,
    Share { average, part, sample_index, exposure }: Share,
    radiance: &Handle,
    Mean { previous, next }: Mean,
) -> (Fullscreen<'r, 'f>, Handle) {
    let chosen = match average {
        Average::Display(curve) => curve.constant(),
        Average::Radiance => ("of_radiance", 1),
    };
    let (from, to) = (radiance.desc(), next.desc());
    let is_scaled = (from.width, from.height) != (to.width, to.height);
    let [share, share_of_glow] = match part {
        SamplePart::Whole | SamplePart::Marked => [1.0, 0.0],
        SamplePart::Glow => [0.0, 1.0],
        SamplePart::Rest => [1.0, -1.0],
    };
    // The mean of the frames so far, so that the picture can be shown at any time.
    let weight = 1.0 / (sample_index as f32 + 1.0);
    let uniform = AccumulationUniform {
        weight,
        keep: 1.0 - weight,
        inverse_size_px: [1.0 / to.width as f32, 1.0 / to.height as f32],
        exposure,
        share,
        share_of_glow,
        padding: 0.0,
    };
    let step = r
        .fullscreen(name, "accumulate", &[])
        .constants(&[chosen, ("scaled", u32::from(is_scaled)), ("marked", u32::from(part != SamplePart::Whole))])
        .uniform("accumulation", &uniform)
        .read("radiance", radiance)
        // The first frame looks at nothing before it, but something has to be bound.
        .read("previous", previous.as_ref().unwrap_or(radiance));
    (step, next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "accumulate",
            "Accumulation",
            AccumulationUniform,
            [weight, keep, inverse_size_px, exposure, share, share_of_glow, padding]
        );
    }
}
