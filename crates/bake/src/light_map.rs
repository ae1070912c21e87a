//! Light maps: the light that reaches surfaces, by rays.
//!
//! One round finds the light that comes straight from where it is made, with as many rays towards what shines as are
//! dense as their cosine. Each further round sends rays from every texel and looks up, where they end, what the round
//! before has brought there: so a round costs the same whichever it is, and its noise is spread over all that sees it.
//!
//! Directional maps also hold where light comes from, as one direction: the mean, weighted by the share of each in the
//! irradiance. Frames tell from it how much of the light a bent normal gets. All light that a map holds is in it.

use crate::BakeError;
use crate::denoise::denoise;
use crate::emitters::{DistantLight, Emitters, luminance};
use crate::fill::{Light, fill};
use crate::gather::Gather;
use crate::layout::{Layout, LayoutSettings};
use crate::progress::{Progress, Stage};
use crate::seams::{seams, stitch};
use crate::surfaces::Surfaces;
use crate::texels::Texels;
use crate::tracing::Tracer;
use crate::work::{BLOCK, Keeper, each_block, keep_blocks, share_out};
use glam::Vec3;
use half::f16;
use manypass_scene::Scene;
use std::f32::consts::PI;
use std::hash::{DefaultHasher, Hasher as _};

/// The most rays from a texel in a round.
pub const SAMPLES_MAX: u32 = 65_536;

/// The most bounces.
pub const BOUNCES_MAX: u32 = 64;

/// Rises whenever the same scene and settings have other light.
const VERSION: u32 = 2;

/// The round of occlusion, as keepers number them; the first is that of direct light, and bounces follow.
const ROUND_OF_OCCLUSION: u32 = u32::MAX;

/// What maps hold, and how well it is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// Where surfaces lie.
    pub layout: LayoutSettings,
    /// Whether light is found.
    pub light: bool,
    /// Whether occlusion is found.
    pub occlusion: bool,
    /// Whether light maps also hold where light comes from, so that normal maps bend it.
    pub directional: bool,
    /// Whether light maps become what surfaces send out of that light, for viewers that know no light maps: then they hold
    /// what comes straight from lamps, too, but for dynamic ones. Surfaces that shine stay as they are.
    pub as_emission: bool,
    /// Rays from a texel in each round.
    pub samples: u32,
    /// How often light is sent back.
    pub bounces: u32,
    /// Whether the noise of samples is taken out.
    pub denoise: bool,
    /// At this distance in metres surfaces do not occlude any more, and less the nearer they are to it; where it is
    /// infinite, all occlude alike, and inside a closed room nothing is open.
    pub occlusion_distance_m: f32,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            layout: LayoutSettings::default(),
            light: true,
            occlusion: false,
            directional: false,
            as_emission: false,
            samples: 256,
            bounces: 3,
            denoise: true,
            occlusion_distance_m: 2.0,
        }
    }
}

/// Checks how many rays there are, and how often light is sent back.
pub(crate) fn check_rays((samples, whence): (u32, &str), bounces: u32) -> Result<(), BakeError> {
    if !(1..=SAMPLES_MAX).contains(&samples) {
        return Err(BakeError::Setting(format!("{samples} rays {whence}; write 1 to {SAMPLES_MAX}")));
    }
    if bounces > BOUNCES_MAX {
        return Err(BakeError::Setting(format!("{bounces} bounces; write 0 to {BOUNCES_MAX}")));
    }
    Ok(())
}

impl BakeSettings {
    fn check(&self) -> Result<(), BakeError> {
        let Self { samples, bounces, occlusion_distance_m, .. } = *self;
        check_rays((samples, "from a texel"), bounces)?;
        if self.directional && (!self.light || self.as_emission) {
            let message = "directional light maps without light maps; leave `directional` out, or bake light maps";
            return Err(BakeError::Setting(message.into()));
        }
        if occlusion_distance_m.is_nan() || occlusion_distance_m <= 0.0 {
            let message = format!("occlusion within {occlusion_distance_m} m; write a distance above 0");
            return Err(BakeError::Setting(message));
        }
        Ok(())
    }
}

/// What a texel has of its light: irradiance, and, of six numbers, the moment of its directions.
fn sum_of<const N: usize>(irradiance: Vec3, moment: Vec3) -> [f32; N] {
    record(irradiance, &[], moment)
}

/// `N` numbers of a texel: those of its irradiance, `between`, and those of the moment as far as there is room.
fn record<const N: usize>(irradiance: Vec3, between: &[f32], moment: Vec3) -> [f32; N] {
    let mut numbers = irradiance.to_array().into_iter().chain(between.iter().copied()).chain(moment.to_array());
    std::array::from_fn(|_| numbers.next().unwrap_or(0.0))
}

/// The moment at the end of the numbers of a texel, none where there are none.
fn moment_in(numbers: &[f32]) -> Vec3 {
    if let [x, y, z] = numbers { Vec3::new(*x, *y, *z) } else { Vec3::ZERO }
}

/// What was found of a scene's surfaces.
#[derive(Clone, Debug)]
pub struct BakedMaps {
    /// Where surfaces lie in the maps.
    pub layout: Layout,
    /// Texels of all pages, one page after the other, rows from the top: irradiance divided by π, which is what a white
    /// surface sends back. Empty if it was not asked for.
    pub light: Vec<[f32; 3]>,
    /// Where that light comes from, texel by texel, as [`LightMap::direction`](manypass_scene::material::LightMap) has it:
    /// the mean, in world space, of unit directions towards it, each weighted by the luminance of its irradiance; 0 where
    /// there is no light. Its length is from 0 to 1. Empty if it was not asked for.
    pub direction: Vec<[f32; 3]>,
    /// Whether `light` is what surfaces send back in their own colours ([`BakeSettings::as_emission`]).
    pub is_emission: bool,
    /// The share of even light from everywhere that reaches each texel. Empty if it was not asked for.
    pub occlusion: Vec<[f32; 1]>,
    /// What differs from what was asked for, one line each.
    pub notes: Vec<String>,
}

/// What stays of a scene while it is baked.
pub struct Baker<'a> {
    settings: BakeSettings,
    surfaces: &'a Surfaces,
    emitters: Emitters<'a>,
    layout: Layout,
}

impl<'a> Baker<'a> {
    /// Lays out the surfaces of a scene. `around` is what is seen where nothing of the scene is.
    ///
    /// # Errors
    /// Settings are out of range, there is nothing to light, the maps would be too large, or `progress` says to stop.
    pub fn new(
        scene: &Scene,
        surfaces: &'a Surfaces,
        around: Option<&'a dyn DistantLight>,
        settings: &BakeSettings,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        settings.check()?;
        let layout = Layout::new(surfaces, &settings.layout, progress)?;
        Ok(Self { settings: *settings, surfaces, emitters: Emitters::new(scene, surfaces, around), layout })
    }

    /// A number that is another one for another scene, other settings, or another version of this crate. Two bakes that
    /// have the same find the same.
    pub fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        hasher.write(env!("CARGO_PKG_VERSION").as_bytes());
        hasher.write_u32(VERSION);
        hasher.write(format!("{:?}", self.settings).as_bytes());
        self.surfaces.hash_into(&mut hasher);
        self.emitters.hash_into(&mut hasher);
        hasher.finish()
    }

    /// Finds the light of all texels. What `keeper` knows is not computed again.
    ///
    /// # Errors
    /// `progress` says to stop.
    pub fn run(self, progress: &dyn Progress, keeper: &dyn Keeper) -> Result<BakedMaps, BakeError> {
        let tracer = Tracer::new(self.surfaces);
        let mut texels = Texels::new(self.surfaces, &self.layout);
        let mut inside = vec![false; self.layout.texel_count()];
        let gather = self.gather(&tracer, &texels);
        share_out(&mut inside, (progress, Stage::Inside), |index| gather.is_inside(index))?;
        texels.put_inside(&inside);
        drop(inside);
        let gather = self.gather(&tracer, &texels);
        let (light, direction) = match self.settings {
            BakeSettings { light: false, .. } => (Vec::new(), Vec::new()),
            BakeSettings { directional: false, .. } => {
                (self.divided(self.light::<3, 7, 4>(&gather, progress, keeper)?, gather.texels), Vec::new())
            }
            _ => self.with_directions(self.light::<6, 10, 7>(&gather, progress, keeper)?, gather.texels),
        };
        let occlusion = if self.settings.occlusion { self.occlusion(&gather, progress, keeper)? } else { Vec::new() };
        let mut notes = self.surfaces.warnings().to_vec();
        notes.extend(self.layout.notes.iter().cloned());
        if !self.settings.occlusion {
            let lost = self.surfaces.own_occlusion.iter();
            notes.extend(lost.map(|name| format!("material `{name}`: its occlusion on the second UV set is left out")));
        }
        drop(texels);
        let is_emission = self.settings.as_emission;
        Ok(BakedMaps { layout: self.layout, light, direction, is_emission, occlusion, notes })
    }

    fn gather<'g>(&'g self, tracer: &'g Tracer<'g>, texels: &'g Texels<'g>) -> Gather<'g> {
        let (surfaces, emitters, samples) = (self.surfaces, &self.emitters, self.settings.samples);
        Gather { surfaces, tracer, emitters, texels, samples }
    }

    fn size(&self) -> (usize, usize) {
        (self.layout.width as usize, self.layout.height as usize)
    }

    /// One round after the other: irradiance, and where it comes from if a texel has six numbers ([`sum_of`]); of texels
    /// without a surface nothing. A texel has 36 bytes here at the most, 60 with directions: in rounds the sum of light, its
    /// variance, and what the last round and this one have brought; afterwards light and variance twice, while noise is taken
    /// out; and its triangle. Of each texel keepers are given `DIRECT` numbers in the first round, the sum, its variance and
    /// what surfaces send back; and `BOUNCE` numbers in others, the sum and its variance.
    fn light<const N: usize, const DIRECT: usize, const BOUNCE: usize>(
        &self,
        gather: &Gather,
        progress: &dyn Progress,
        keeper: &dyn Keeper,
    ) -> Result<Vec<[f32; N]>, BakeError> {
        const { assert!(DIRECT == N + 4 && BOUNCE == N + 1) };
        let count = self.layout.texel_count();
        let padding = self.settings.layout.padding;
        let (mut sum, mut source, mut variance) =
            (vec![[0.0; N]; count], vec![[f16::ZERO; 3]; count], vec![0.0; count]);
        let direct = |index: usize| {
            let [held, added] = gather.of_lamps(index);
            let others = gather.of_others(index);
            let all = held.irradiance + added.irradiance + others.value;
            let numbers = [others.variance, all.x, all.y, all.z];
            record::<DIRECT>(others.value, &numbers, others.moment)
        };
        let blocks = sum.chunks_mut(BLOCK).zip(source.chunks_mut(BLOCK)).zip(variance.chunks_mut(BLOCK));
        let stage = (progress, Stage::Direct);
        keep_blocks(blocks, (BLOCK, count), stage, (keeper, 0), direct, |((sum, source), variance), values| {
            for (index, value) in values.iter().map(|value| &value[..]).enumerate() {
                let [a, b, c, of_variance, red, green, blue, moment @ ..] = value else { continue };
                sum[index] = sum_of(Vec3::new(*a, *b, *c), moment_in(moment));
                (variance[index], source[index]) = (*of_variance, Light::of(Vec3::new(*red, *green, *blue) / PI));
            }
        })?;
        for round in 0..self.settings.bounces {
            fill(&mut source, gather.texels, self.size(), padding);
            let mut next = vec![[f16::ZERO; 3]; count];
            let of_texel = |index: usize| {
                let mean = gather.bounced(index, round, &source);
                record::<BOUNCE>(mean.value, &[mean.variance], mean.moment)
            };
            let blocks = sum.chunks_mut(BLOCK).zip(next.chunks_mut(BLOCK)).zip(variance.chunks_mut(BLOCK));
            let stage = (progress, Stage::Bounce(round + 1));
            keep_blocks(
                blocks,
                (BLOCK, count),
                stage,
                (keeper, round + 1),
                of_texel,
                |((sum, next), variance), values| {
                    for (index, value) in values.iter().map(|value| &value[..]).enumerate() {
                        let [a, b, c, of_variance, moment @ ..] = value else { continue };
                        let light = Vec3::new(*a, *b, *c);
                        let before = &sum[index];
                        sum[index] =
                            sum_of(Vec3::from_slice(before) + light, moment_in(&before[3..]) + moment_in(moment));
                        next[index] = Light::of(light / PI);
                        variance[index] += of_variance;
                    }
                },
            )?;
            source = next;
        }
        drop(source);
        if self.settings.denoise {
            sum = denoise(sum, variance, gather.texels, self.size(), (progress, Stage::Finish))?;
        } else {
            drop(variance);
        }
        let as_emission = self.settings.as_emission;
        if as_emission || self.emitters.holds_lamps() {
            // Found again, which is little work beside all else: to keep it would take a third more memory.
            let blocks = sum.chunks_mut(BLOCK);
            each_block(blocks, (BLOCK, count), (progress, Stage::Finish), |number, block| {
                for (index, sum) in block.iter_mut().enumerate() {
                    let index = number * BLOCK + index;
                    let [held, added] = gather.of_lamps(index);
                    let light = Vec3::from_slice(sum) + held.irradiance;
                    let sent_back = || (light + added.irradiance) * gather.reflectance(index);
                    let moment = moment_in(&sum[3..]) + held.moment;
                    *sum = sum_of(if as_emission { sent_back() } else { light }, moment);
                }
            })?;
        }
        Ok(sum)
    }

    /// Irradiance of all texels as maps have it: spread into what lies around charts, without cuts, and divided by π.
    fn divided(&self, mut light: Vec<[f32; 3]>, texels: &Texels) -> Vec<[f32; 3]> {
        fill(&mut light, texels, self.size(), self.settings.layout.padding);
        stitch(&mut light, &seams(self.surfaces, &self.layout), self.size(), 0.0);
        light.iter_mut().flatten().for_each(|value| *value /= PI);
        light
    }

    /// The same, and the mean directions of light. What is spread and brought together along cuts is their moments, which
    /// are light that has a direction: only then they are divided.
    fn with_directions(&self, both: Vec<[f32; 6]>, texels: &Texels) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
        let light = both.iter().map(|[a, b, c, ..]| [*a, *b, *c]).collect();
        let mut moments: Vec<[f32; 3]> = both.iter().map(|[.., x, y, z]| [*x, *y, *z]).collect();
        drop(both);
        let light = self.divided(light, texels);
        fill(&mut moments, texels, self.size(), self.settings.layout.padding);
        stitch(&mut moments, &seams(self.surfaces, &self.layout), self.size(), f32::NEG_INFINITY);
        for (moment, light) in moments.iter_mut().zip(&light) {
            let irradiance = luminance(Vec3::from(*light) * PI);
            let mean = if irradiance > 0.0 { Vec3::from(*moment) / irradiance } else { Vec3::ZERO };
            // Where cuts are brought together light and moments change by different shares.
            *moment = if mean.is_finite() { mean.clamp_length_max(1.0) } else { Vec3::ZERO }.to_array();
        }
        (light, moments)
    }

    fn occlusion(
        &self,
        gather: &Gather,
        progress: &dyn Progress,
        keeper: &dyn Keeper,
    ) -> Result<Vec<[f32; 1]>, BakeError> {
        let count = self.layout.texel_count();
        let (mut open, mut variance) = (vec![[0.0; 3]; count], vec![0.0; count]);
        let distance_m = self.settings.occlusion_distance_m;
        let of_texel = |index: usize| {
            let mean = gather.openness(index, distance_m);
            [mean.value.x, mean.variance]
        };
        let blocks = open.chunks_mut(BLOCK).zip(variance.chunks_mut(BLOCK));
        let stage = (progress, Stage::Occlusion);
        keep_blocks(
            blocks,
            (BLOCK, count),
            stage,
            (keeper, ROUND_OF_OCCLUSION),
            of_texel,
            |(open, variance), values| {
                for (index, [value, of_variance]) in values.iter().enumerate() {
                    (open[index], variance[index]) = ([*value; 3], *of_variance);
                }
            },
        )?;
        if self.settings.denoise {
            open = denoise(open, variance, gather.texels, self.size(), (progress, Stage::Finish))?;
        }
        fill(&mut open, gather.texels, self.size(), self.settings.layout.padding);
        stitch(&mut open, &seams(self.surfaces, &self.layout), self.size(), 0.0);
        Ok(open.into_iter().map(|[value, ..]| [value]).collect())
    }
}

/// Finds what `settings` ask for of a scene's surfaces that stay where they are, in one go. `around` is what is seen where
/// nothing of the scene is.
///
/// # Errors
/// As [`Baker::new`] and [`Baker::run`] have them.
pub fn bake(
    scene: &Scene,
    around: Option<&dyn DistantLight>,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<BakedMaps, BakeError> {
    let surfaces = Surfaces::new(scene);
    Baker::new(scene, &surfaces, around, settings, progress)?.run(progress, &())
}
