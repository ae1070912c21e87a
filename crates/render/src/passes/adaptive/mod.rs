//! adaptive: the later samples of a still leave out the parts of its picture that the earlier ones agree on.
//!
//! Source: Dammertz et al. 2010, "A Hierarchical Automatic Stopping Condition for Monte Carlo Global Illumination",
//! which compares the mean with that of half of the samples. Where it differs: there is no hierarchy but small tiles,
//! because what is left out is hidden by depth, which costs the same in any shape. Reads: the mean. Writes: which tiles
//! are settled, and the depth that a frame begins with.
//!
//! Every pass draws where depth lets it. A settled tile begins with the nearest depth there is, so that neither
//! surfaces nor what lies behind them is drawn there, and is marked in the stencil, which light heeds; what the frame's
//! textures hold there means nothing, and the mean stays as it is.

mod blocks;
mod settings;

pub use blocks::unsettled_rectangles;
pub use settings::AdaptiveSettings;

use crate::constants::SETTLED_TILE_PX;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, DepthLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo =
    PassInfo { off: Some("adaptive.threshold=0"), tiers: &["low", "medium", "high"], ..PassInfo::new("adaptive") };

/// The format of the mean of half of the samples.
pub const HALF: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The fewest samples that anything is told from.
const SAMPLES_MIN: u32 = 4;

/// How much more may change just beside a tile, after enough samples that an edge there is unlikely to have been
/// missed: edges change by many 255ths, the grain of textures by one or two, so that it is the edges that this tells.
const BESIDE: f32 = 4.0;

/// The shape of the texture that says which tiles of a picture are settled: the share of the samples that each is left
/// out of, or 0.
pub fn settled_desc((width, height): (u32, u32)) -> TextureDesc {
    let tiles = |side: u32| side.div_ceil(SETTLED_TILE_PX as u32);
    TextureDesc::new_2d(tiles(width), tiles(height), wgpu::TextureFormat::R8Unorm)
}

/// What is to be done once a sample was added to the mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Nothing.
    None,
    /// Its mean is kept, to be compared with.
    Keep,
    /// Tiles are looked for that are settled.
    Settle {
        /// Whether none were looked for before.
        is_first: bool,
        /// Whether the mean is kept, too, to be compared with.
        keeps: bool,
    },
}

/// How many samples of `sample_count` draw all tiles, before any are looked for that are settled; none if there are too
/// few to look for any.
pub fn whole_samples(sample_count: u32) -> Option<u32> {
    let least = SAMPLES_MIN.max(sample_count / 4).checked_next_power_of_two()?;
    (least <= sample_count / 2).then_some(least)
}

impl Step {
    /// After the sample `sample_index` of `sample_count`. Tiles are looked for after a quarter and a half of the
    /// samples, if these are powers of two, else after the powers in between.
    pub fn after(sample_index: u32, sample_count: u32) -> Self {
        let is_looked_for = |samples: u32| {
            samples.is_power_of_two() && samples >= SAMPLES_MIN.max(sample_count / 4) && samples <= sample_count / 2
        };
        let samples = sample_index + 1;
        let keeps = samples.checked_mul(2).is_some_and(is_looked_for);
        match (is_looked_for(samples), keeps) {
            (true, keeps) => Self::Settle { is_first: !is_looked_for(samples / 2), keeps },
            (false, true) => Self::Keep,
            (false, false) => Self::None,
        }
    }
}

/// Which tiles have converged, and what that is told from, kept from sample to sample.
#[derive(Debug)]
pub struct ConvergedTiles {
    /// Which tiles are settled; a texel for each.
    pub settled: Handle,
    /// The mean of half of the samples.
    pub half: Handle,
}

/// The uniform of `adaptive.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct SettlingUniform {
    /// What may change, of display values encoded by a square root.
    threshold: f32,
    /// The same, just beside the tile.
    threshold_beside: f32,
    /// Which share of the samples is left out of a tile that is settled now.
    share_left_out: f32,
    /// Zero.
    padding: f32,
}

/// The depth that a frame of the view begins with, if nothing else says where it draws: the far plane, and where tiles are
/// settled the near one. Also says how the first pass that draws surfaces loads it.
///
/// # Errors
/// A program that does not compile.
pub fn begin_depth(r: &mut Recorder<'_, '_>) -> Result<(Handle, DepthLoad), ProgramError> {
    let depth = r.multisampled("geometry.depth", r.frame.gpu.capabilities.depth_format);
    let Some(settled) = &r.view.settled else { return Ok((depth, DepthLoad::Clear { depth: 0.0, stencil: 0 })) };
    let step = r.fullscreen("adaptive.depth", "adaptive_depth", &[]).table("settled", settled).leave_out_settled();
    Ok((step.draw_unsettled_into(depth)?, DepthLoad::Keep))
}

/// Records what is to be done after a sample, of the `mean` with it.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &AdaptiveSettings,
    (step, sample_index): (Step, u32),
    mean: &Handle,
    ConvergedTiles { settled, half }: ConvergedTiles,
) -> Result<(), ProgramError> {
    if let Step::Settle { is_first, .. } = step {
        let threshold = settings.threshold / 255.0;
        let uniform = SettlingUniform {
            threshold,
            threshold_beside: if is_first { threshold } else { BESIDE * threshold },
            share_left_out: 1.0 - (sample_index + 1) as f32 / r.view.sample_count as f32,
            padding: 0.0,
        };
        let load = if is_first { ColorLoad::Clear(wgpu::Color::TRANSPARENT) } else { ColorLoad::Keep };
        // A tile that is settled stays so.
        let most = wgpu::BlendComponent { operation: wgpu::BlendOperation::Max, ..crate::record::ADD.color };
        let fullscreen = r.fullscreen("adaptive", "adaptive", &[]).uniform("settling", &uniform);
        let fullscreen = fullscreen.read("mean", mean).read("mean_of_half", &half);
        let fullscreen = fullscreen.blend(wgpu::BlendState { color: most, alpha: most });
        let settled = fullscreen.draw_into(settled, load)?;
        r.graph.export(settled);
    }
    if matches!(step, Step::Keep | Step::Settle { keeps: true, .. }) {
        let kept = r.fullscreen("adaptive.keep", "adaptive_keep", &[]).read("mean", mean);
        let kept = kept.draw_into(half, ColorLoad::Discard)?;
        r.graph.export(kept);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "adaptive",
            "Settling",
            SettlingUniform,
            [threshold, threshold_beside, share_left_out, padding]
        );
    }

    #[test]
    fn tiles_are_looked_for_after_a_quarter_and_a_half_of_the_samples() {
        let steps = |count| (0..count).map(move |index| (index + 1, Step::after(index, count)));
        let looked_for = |count| -> Vec<u32> {
            steps(count).filter_map(|(at, step)| matches!(step, Step::Settle { .. }).then_some(at)).collect()
        };
        assert_eq!(looked_for(16), [4, 8]);
        assert_eq!(looked_for(256), [64, 128]);
        assert_eq!(looked_for(24), [8]);
        assert_eq!(looked_for(8), [4]);
        assert!(looked_for(7).is_empty() && looked_for(1).is_empty());
        assert_eq!(Step::after(1, 16), Step::Keep);
        assert_eq!(Step::after(3, 16), Step::Settle { is_first: true, keeps: true });
        assert_eq!(Step::after(7, 16), Step::Settle { is_first: false, keeps: false });
        // Each is compared with a mean that was kept.
        for count in 1..300 {
            assert_eq!(whole_samples(count), looked_for(count).first().copied(), "{count}");
            for (at, step) in steps(count) {
                if matches!(step, Step::Settle { .. }) {
                    let before = Step::after(at / 2 - 1, count);
                    assert!(matches!(before, Step::Keep | Step::Settle { keeps: true, .. }), "{at} of {count}");
                }
            }
        }
    }
}
