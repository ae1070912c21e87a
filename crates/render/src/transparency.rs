//! Surfaces that alpha covers: in which way they become one picture with what lies behind them. What the passes that
//! draw them and the pass `transparency` have in common, with the uniform of `transparency.wgsl`.

mod peel;
mod settings;

pub use peel::{Peel, Side};
pub use settings::TransparencySettings;

use crate::draws::WorldDraws;
use crate::gbuffer::{LightTarget, RADIANCE};
use crate::record::{PreparedView, Recorder, SurfacePass, Texels};
use crate::setting::choices;
use crate::shader::program::Constant;
use bytemuck::{Pod, Zeroable};
use manypass_graph::{ColorLoad, DepthLoad, Handle};
use manypass_scene::Aabb;

choices! {
    /// The way of transparency: how alpha-blended surfaces are composited.
    pub enum TransparencyMode {
        /// One over the other, farther objects first (Porter & Duff 1984).
        #[default]
        Sorted = "sorted",
        /// Their weighted mean over what lies behind them all (McGuire & Bavoil 2013), whatever their order.
        Weighted = "weighted",
        /// Each opaque in so many of a still's samples as its alpha says (Enderton et al. 2010), whatever their order.
        Stochastic = "stochastic",
    }
}

choices! {
    /// Alpha masks: which fragments they drop.
    pub enum Masks {
        /// Hashed in stills of several samples, whose mean has no pattern; else those below the cutoff.
        #[default]
        Auto = "auto",
        /// Those whose alpha is less than the cutoff.
        Cutoff = "cutoff",
        /// Where texels are smaller than pixels those whose alpha is less than a hash of their place (Wyman & McGuire
        /// 2017).
        Hashed = "hashed",
    }
}

/// From so many samples on the mean of a still shows no pattern of a hash.
const HASHED_SAMPLES: u32 = 4;

impl Masks {
    /// With [`Self::Auto`] as it is in a picture of so many samples.
    pub(crate) fn resolved(self, sample_count: u32) -> Self {
        match self {
            Self::Auto if sample_count >= HASHED_SAMPLES => Self::Hashed,
            Self::Auto => Self::Cutoff,
            masks => masks,
        }
    }

    /// The `override` constants that shaders take for it.
    pub(crate) fn constants(self) -> Vec<Constant> {
        match self {
            Self::Auto | Self::Cutoff => Vec::new(),
            Self::Hashed => vec![("hashed_masks", 1)],
        }
    }
}

/// The constant of `transparency.wgsl` that says which way, and its values beside that of sorted surfaces.
const BLENDING: &str = "blending";
const WEIGHTED: u32 = 1;
const STOCHASTIC: u32 = 2;

/// The constant of `transparency.wgsl` that says which fragments are drawn.
const PEELS: &str = "peels";

/// The texture of `transparency.wgsl` that holds distances of surfaces that light comes through: of the nearest of them
/// for blended ones, and for themselves what the pass `glass` makes.
pub(crate) const GLASS_DISTANCES: &str = "glass_distances";

/// What has a weight is added up: radiance, and alpha; what comes through all of it is multiplied into
/// alpha: one blend state for all targets, because the floor has one.
pub(crate) const SUM: wgpu::BlendState = wgpu::BlendState {
    color: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    },
    alpha: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::OneMinusSrcAlpha,
        operation: wgpu::BlendOperation::Add,
    },
};

/// The format of the sum of weights: half floats add up on every backend.
const WEIGHTS: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// A weight falls by so many octaves where the distance doubles: with the fourth power, two panes that let half
/// through, of which one is 1.2 times as far away, have the shares that they have when they are sorted.
const OCTAVES_PER_OCTAVE: f32 = 4.0;

/// Weights span at most so many octaves, so that half floats hold the sums.
const OCTAVES: f32 = 12.0;

/// Distances below this share of the farthest have the weight of it.
const NEAREST_SHARE: f32 = 1.0 / 4096.0;

/// The uniform of `transparency.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Weighting {
    /// The logarithm to the base 2 of a weight is that of the distance times the first, plus the second, within plus
    /// and minus the third.
    exponent: [f32; 3],
    /// What is nearer lies before all surfaces that light comes through.
    glass_m: f32,
}

impl Weighting {
    /// Binds all that `transparency.wgsl` declares. The pass draws what `peel` says, or everything.
    pub fn bind(&self, pass: &mut SurfacePass<'_, '_>, peel: Option<Peel<'_>>) {
        pass.uniform("weighting", self);
        match peel {
            Some(Peel { side, nearest_m }) => {
                pass.constant(PEELS, side as u32);
                pass.read(GLASS_DISTANCES, nearest_m);
            }
            None => pass.stand_in(GLASS_DISTANCES),
        }
    }

    /// For the blended surfaces of `world`, in view or not, so that the weights of one do not change when others leave
    /// the view.
    fn weighted(view: &PreparedView, world: &WorldDraws) -> Self {
        let blended = world.items[world.opaque_count..].iter().filter(|item| !item.transmissive);
        let (nearest, farthest) = distances(view, blended.map(|item| &item.bounds_world));
        // Without any that has a place: no logarithm of what is not there.
        let farthest = farthest.max(0.0);
        let farthest = if farthest.is_finite() { farthest.max(f32::MIN_POSITIVE) } else { f32::MAX };
        let nearest = nearest.clamp(farthest * NEAREST_SHARE, farthest);
        let (first, last) = (nearest.log2(), farthest.log2());
        let slope = OCTAVES_PER_OCTAVE.min(OCTAVES / (last - first).max(1e-3));
        Self { exponent: [-slope, 0.5 * slope * (first + last), 0.5 * OCTAVES], glass_m: 0.0 }
    }

    /// For blended surfaces that are drawn by chance, before or behind the surfaces in view that light comes through.
    fn stochastic(view: &PreparedView, world: &WorldDraws) -> Self {
        let glass = view.draws.transmissive.iter().map(|draw| &world.items[draw.item as usize].bounds_world);
        let (nearest, _) = distances(view, glass);
        Self { exponent: [0.0; 3], glass_m: if nearest.is_finite() { nearest } else { 0.0 } }
    }
}

/// The nearest and the farthest distance of `boxes` along the view axis, in metres; the nearest is infinite if there
/// are none.
fn distances<'b>(view: &PreparedView, boxes: impl Iterator<Item = &'b Aabb>) -> (f32, f32) {
    let row = view.uniform.view_from_world.row(2);
    let of_box = |Aabb { min, max }: &Aabb| {
        let (center, half) = (0.5 * (*min + *max), 0.5 * (*max - *min));
        let distance = -(row.truncate().dot(center) + row.w);
        let reach = row.truncate().abs().dot(half);
        (distance - reach, distance + reach)
    };
    let none = (f32::INFINITY, f32::NEG_INFINITY);
    boxes.map(of_box).fold(none, |all, found| (all.0.min(found.0), all.1.max(found.1)))
}

/// Blended surfaces that are to be drawn, or have been, with what they are drawn into.
#[derive(Debug)]
pub struct BlendTargets {
    /// Which way.
    pub mode: TransparencyMode,
    /// The picture, which sums leave as it is.
    pub radiance: Handle,
    /// What hides them.
    pub depth: Handle,
    /// Radiance times weight, with what comes through; and the weights.
    pub sums: Option<[Handle; 2]>,
}

impl BlendTargets {
    /// Over `radiance`, behind what `depth` holds. Where pairs are counted, the way is none of it.
    pub fn new(r: &mut Recorder<'_, '_>, mode: TransparencyMode, radiance: Handle, depth: Handle) -> Self {
        let mode = if r.view.counts_pairs() { TransparencyMode::Sorted } else { mode };
        let sums = (mode == TransparencyMode::Weighted).then(|| {
            let sums = r.multisampled("transparency.sums", RADIANCE);
            let weights = r.multisampled("transparency.weights", WEIGHTS);
            r.declare_texels(&weights, Texels::Number);
            [sums, weights]
        });
        Self { mode, radiance, depth, sums }
    }

    /// What the pass that draws them finds in the uniform `weighting`.
    pub fn weighting(&self, r: &Recorder<'_, '_>) -> Weighting {
        match self.mode {
            TransparencyMode::Weighted => Weighting::weighted(r.view, r.frame.world),
            TransparencyMode::Stochastic => Weighting::stochastic(r.view, r.frame.world),
            TransparencyMode::Sorted => Weighting::default(),
        }
    }

    /// Makes that the targets of a pass. Returns the versions that hold the result.
    pub fn begin(self, pass: &mut SurfacePass<'_, '_>, view: &PreparedView) -> Self {
        let Self { mode, radiance, depth, sums } = self;
        match (mode, sums) {
            (TransparencyMode::Weighted, Some([sums, weights])) => {
                pass.constant(BLENDING, WEIGHTED);
                pass.blend(SUM);
                pass.depth_read_only(&depth);
                let everything = wgpu::Color { a: 1.0, ..wgpu::Color::TRANSPARENT };
                let sums = [sums, weights].map(|target| pass.color(target, ColorLoad::Clear(everything)));
                Self { mode, radiance, depth, sums: Some(sums) }
            }
            (TransparencyMode::Stochastic, _) => {
                pass.constant(BLENDING, STOCHASTIC);
                let radiance = pass.color(radiance, ColorLoad::Keep);
                let depth = pass.depth(depth, DepthLoad::Keep);
                Self { mode, radiance, depth, sums: None }
            }
            (_, sums) => {
                pass.blend(LightTarget::blend_over(view));
                pass.depth_read_only(&depth);
                let radiance = pass.color(radiance, ColorLoad::Keep);
                Self { mode, radiance, depth, sums }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("forward", "Weighting", Weighting, [exponent, glass_m]);
    }
}
