//! From the radiance of what a monitor's camera sees to the texture that screens show.

use super::Means;
use crate::passes::accumulate::{self, Average, SamplePart};
use crate::passes::{adaptive, mips, tone_map};
use crate::record::Recorder;
use crate::settings::Settings;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What a monitor's camera sees.
#[derive(Debug)]
pub struct MonitorInputs<'h> {
    /// The radiance of a sample.
    pub radiance: &'h Handle,
    /// Depth of the view: where it is nearest, tiles are settled, and keep their mean.
    pub depth: &'h Handle,
    /// The mean that the sample is added to: of display colours, or of radiance where that alone means something.
    pub means: Means,
    /// How many frames were added before.
    pub sample_index: u32,
    /// From pre-exposed radiance to what the tone curve takes.
    pub exposure: f32,
    /// The stops that come on top, in one texel, if exposure adapts.
    pub adapted: Option<&'h Handle>,
    /// What is done once this frame was added, if its mean is of display colours.
    pub adaptive_step: adaptive::Step,
    /// What that is done to.
    pub settling: Option<adaptive::ConvergedTiles>,
}

/// Draws what a monitor's camera sees into the texture that screens show: display colours in linear light, with mips.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn monitor_passes(
    r: &mut Recorder<'_, '_>,
    settings: &Settings,
    inputs: MonitorInputs<'_>,
    texture: Handle,
) -> Result<(), ProgramError> {
    let MonitorInputs { radiance, depth, means, sample_index, exposure, adapted, adaptive_step, settling } = inputs;
    let curve = settings.tone_map.curve;
    let share = |average| accumulate::Share { average, part: SamplePart::Whole, sample_index, exposure };
    let background = settings.background.source;
    let linear = tone_map::Display { curve, exposure, background, is_mean: true, encodes: false };
    let (mean, left) = match means {
        Means::Display(mean) => {
            let mean = accumulate::record_unsettled(r, share(Average::Display(curve)), radiance, depth, mean)?;
            if let Some(settling) = settling {
                adaptive::record(r, &settings.adaptive, (adaptive_step, sample_index), &mean, settling)?;
            }
            (Some(mean), tone_map::Display { curve: tone_map::Tonemap::None, exposure: 1.0, ..linear })
        }
        Means::Radiance(mean) => {
            (Some(accumulate::record(r, "accumulate", share(Average::Radiance), radiance, mean)?), linear)
        }
        Means::None | Means::Both(_) | Means::Parts { .. } => (None, tone_map::Display { is_mean: false, ..linear }),
    };
    let inputs =
        tone_map::DisplayInputs { radiance: mean.as_ref().unwrap_or(radiance), glow: None, adapted, tint: None };
    let first = r.graph.subview(&texture, 0, 0);
    tone_map::record(r, "monitor", &settings.tone_map, left, inputs, first)?;
    mips::record(r, "monitor", mips::Filter::Box, &texture)?;
    r.graph.export(texture);
    if let Some(mean) = mean {
        r.graph.export(mean);
    }
    Ok(())
}

/// Switches a monitor off: what it shows is black until it is drawn again.
pub fn darken_monitor(r: &mut Recorder<'_, '_>, texture: Handle) {
    for level in 0..texture.desc().mips {
        let target = r.graph.subview(&texture, level, 0);
        r.graph.pass(format!("monitor.dark.{level}")).color(target, ColorLoad::Clear(wgpu::Color::BLACK));
    }
    r.graph.export(texture);
}
