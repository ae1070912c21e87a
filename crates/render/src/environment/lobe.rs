//! The samples of the lobes of GGX by which the environment is blurred, and its levels of roughness.

use crate::constants::{
    ENVIRONMENT_LEVEL_COARSE, ENVIRONMENT_LEVEL_HALF, ENVIRONMENT_LEVEL_LAST, ENVIRONMENT_LEVEL_MEDIUM,
    ENVIRONMENT_ROUGHNESS_FIRST,
};
use crate::gpu::Gpu;
use crate::gpu::data_texture::DataTexture;
use glam::Vec3;
pub(crate) use manypass_scene::environment::CUBE_FACES as FACES;
use std::f32::consts::PI;
use std::f64;

/// The samples of the lobes of fine tiles, of those of medium size, and of coarse ones up to roughness 0.5.
const SAMPLES: [u32; 3] = [64, 320, 1024];

/// By which power the solid angle that a sample stands for grows with the height that the lobe has lost: importance
/// has 2.
const TAIL: f64 = 1.5;
/// A sample stands for as much of a texel of the source at least.
const CORE_TEXELS: f64 = 0.5;
/// How much finer levels are than what a sample stands for: bilinear samples of them are wider than their texels.
const LEVEL_BIAS: f64 = -0.5;

/// The golden angle as a share of a turn, counted the other way around: points on a spiral that turns by it from one to
/// the next are about as far from their neighbours everywhere.
const GOLDEN_TURN: f64 = 0.618_033_988_749_894_9;

/// The most samples of a lobe, which are those of wide ones, and the texels of a row of the table.
const SAMPLES_MAX: u32 = 6 * SPHERE_SIDE * SPHERE_SIDE;

/// The side of the faces whose texels are all directions of wide lobes.
const SPHERE_SIDE: u32 = 16;

/// What the lobe of a level is summed from.
#[derive(Clone, Debug)]
pub(crate) struct Lobe {
    /// The square of the perceptual roughness; of all directions less what the source is blurred by.
    pub alpha: f32,
    /// Whether the samples are all directions, and not those of the lobe.
    pub is_of_sphere: bool,
    /// X and y of directions about +Z, along which the lobe is seen; their weights, n·l times what the lobe has of the
    /// ring that a sample stands for; and the level of the halves of the environment whose texels are about as large as
    /// what it stands for. Or all directions with their solid angles.
    pub samples: Vec<[f32; 4]>,
    /// The level of the halves for all directions.
    pub source_level: f32,
}

impl Lobe {
    /// `count` directions, for a source whose finest faces have `source_side` texels a side.
    ///
    /// They are denser where the lobe is higher, but by less than importance asks for, because what is bright may be
    /// far from its middle; and nowhere much denser than the source's texels. Each stands for a ring's part of all
    /// directions, with what the lobe has there.
    fn of_rings(alpha: f32, count: u32, source_side: u32) -> Self {
        const STEPS: usize = 512;
        let a2 = f64::from(alpha * alpha);
        let texel = 4.0 * f64::consts::PI / f64::from(6 * source_side * source_side);
        // By the square of the sine of the half vector's angle, up to the horizon: it is the solid angle divided by 4
        // pi.
        let height = |s: f64| (a2 + s * (1.0 - a2)) / a2;
        let place = |step: usize| a2 * ((step as f64 / STEPS as f64 * (0.5 / a2).ln_1p()).exp_m1());
        let density =
            |s: f64, scale: f64| (scale / height(s).powf(TAIL)).min(4.0 * f64::consts::PI / (CORE_TEXELS * texel));
        let sums = |scale: f64| {
            let mut sum = 0.0;
            let mut sums = vec![0.0];
            for step in 0..STEPS {
                let (from, to) = (place(step), place(step + 1));
                sum += density(0.5 * (from + to), scale) * (to - from);
                sums.push(sum);
            }
            sums
        };
        // As many as asked for; fewer where the source has no more to say.
        let mut scale = f64::from(count) / a2;
        for _ in 0..12 {
            scale *= f64::from(count) / sums(scale)[STEPS];
        }
        let sums = sums(scale);
        let at = |share: f64| {
            let wanted = share * sums[STEPS];
            let step = sums.partition_point(|sum| *sum < wanted).clamp(1, STEPS);
            let within = (wanted - sums[step - 1]) / (sums[step] - sums[step - 1]);
            place(step - 1) + (place(step) - place(step - 1)) * within
        };
        let levels = f64::from(source_side.ilog2());
        let level_of =
            |s: f64| (0.5 * (4.0 * f64::consts::PI * s / texel).log2() + LEVEL_BIAS).clamp(0.0, levels).round();
        // A texel of a level is the mean of four finer ones across, as 1 : 3 : 3 : 1, over and over, so that its
        // variance goes to a quarter of its area; bilinear samples add a sixth of it.
        let core_level = level_of(at(1.0 / f64::from(count)));
        let quarter = 4.0f64.powf(core_level);
        let variance = (0.25 * (1.0 - 1.0 / quarter) + 1.0 / 6.0) * quarter * texel;
        let narrow = a2 - variance.min(0.25 * a2);
        let sample = |i: u32| {
            let [from, middle, to] = [0.0, 0.5, 1.0].map(|part| at((f64::from(i) + part) / f64::from(count)));
            let turn = (f64::from(i) * GOLDEN_TURN).fract() * f64::consts::TAU;
            let share = |s: f64| s / (narrow + s * (1.0 - narrow));
            let (z, across) = (1.0 - 2.0 * middle, 2.0 * (middle * (1.0 - middle)).sqrt());
            let weight = z * (share(to) - share(from));
            let [x, y, weight] = [across * turn.cos(), across * turn.sin(), weight].map(|value| value as f32);
            [x, y, weight, level_of(to - from) as f32]
        };
        Self { alpha, is_of_sphere: false, samples: (0..count).map(sample).collect(), source_level: 0.0 }
    }

    /// All directions: the texels of faces of `side` texels a side. Wide lobes are smooth at that distance.
    pub fn of_sphere(alpha: f32, side: u32, source_side: u32) -> Self {
        let side = side.min(source_side);
        let place = |at: u32| (2.0 * at as f32 + 1.0) / side as f32 - 1.0;
        let texels = (0..side * side).map(|i| [place(i % side), place(i / side)]);
        let sample = |[right, down, forward]: [Vec3; 3], [x, y]: [f32; 2]| {
            let direction = forward + x * right + y * down;
            // Of a rectangle on the face, from a corner of the face's own axes to its corner.
            let half = 1.0 / side as f32;
            let to_corner = |x: f32, y: f32| (x * y).atan2((x * x + y * y + 1.0).sqrt());
            let row = |y: f32| to_corner(x + half, y) - to_corner(x - half, y);
            let solid_angle = row(y + half) - row(y - half);
            direction.normalize().extend(solid_angle).to_array()
        };
        let samples = FACES.into_iter().flat_map(|face| texels.clone().map(move |texel| sample(face, texel)));
        let source_level = (source_side / side).ilog2() as f32;
        Self { alpha, is_of_sphere: true, samples: samples.collect(), source_level }
    }

    /// Those of all levels but the mirror's, in their order.
    pub fn of_levels(source_side: u32) -> Vec<Self> {
        let lobe = |level: u32| {
            let alpha = roughness_of_level(level as f32).powi(2);
            match level as f32 {
                level if level < ENVIRONMENT_LEVEL_MEDIUM => Self::of_rings(alpha, SAMPLES[0], source_side),
                level if level < ENVIRONMENT_LEVEL_COARSE => Self::of_rings(alpha, SAMPLES[1], source_side),
                level if level <= ENVIRONMENT_LEVEL_HALF => Self::of_rings(alpha, SAMPLES[2], source_side),
                _ => {
                    // The blur of the level that is read, as in `of_rings`: a quarter of a texel's area, 4 π / 6 side².
                    // A lobe that is narrower by as much makes up for it.
                    let variance = PI / (6 * SPHERE_SIDE * SPHERE_SIDE) as f32;
                    Self::of_sphere((alpha * alpha - variance).sqrt(), SPHERE_SIDE, source_side)
                }
            }
        };
        (1..=ENVIRONMENT_LEVEL_LAST as u32).map(lobe).collect()
    }
}

/// The perceptual roughness of a level.
pub(crate) fn roughness_of_level(level: f32) -> f32 {
    if level < 1.0 {
        level * ENVIRONMENT_ROUGHNESS_FIRST
    } else if level < ENVIRONMENT_LEVEL_HALF {
        ENVIRONMENT_ROUGHNESS_FIRST * ((level - 1.0) / 4.0).exp2()
    } else {
        (0.5 + (level - ENVIRONMENT_LEVEL_HALF) / 16.0).min(1.0)
    }
}

/// The level of a perceptual roughness, from 0 to 1: as `environment_tiles.wgsl` has it.
pub(crate) fn level_of_roughness(roughness: f32) -> f32 {
    let ratio = roughness / ENVIRONMENT_ROUGHNESS_FIRST;
    if ratio < 1.0 {
        ratio
    } else if roughness < 0.5 {
        1.0 + 4.0 * ratio.log2()
    } else {
        ENVIRONMENT_LEVEL_HALF + (roughness - 0.5) * 16.0
    }
}

/// The integral over all directions of light of n·l D / 4, the lobe of a roughness `alpha` seen along the normal.
pub(crate) fn lobe_integral(alpha: f32) -> f32 {
    let a2 = f64::from(alpha).powi(2).max(1e-12);
    // D has the denominator (a - b x)² with x = n·l.
    let b = 0.5 * (1.0 - a2);
    let a = 1.0 - b;
    let integral = if b < 1e-3 { 0.5 / (a * a) } else { ((a2 / a).ln() + a / a2 - 1.0) / (b * b) };
    (0.5 * a2 * integral) as f32
}

/// The samples of lobes on the device, a row each.
#[derive(Debug)]
pub(crate) struct LobeTable(DataTexture);

impl LobeTable {
    /// Of `lobes`.
    pub fn new(gpu: &Gpu, lobes: &[Lobe]) -> Self {
        let mut texture = DataTexture::new(&gpu.device, "lobe", wgpu::TextureFormat::Rgba32Float, SAMPLES_MAX);
        let mut texels = vec![[0f32; 4]; lobes.len() * SAMPLES_MAX as usize];
        for (row, lobe) in texels.chunks_exact_mut(SAMPLES_MAX as usize).zip(lobes) {
            row[..lobe.samples.len()].copy_from_slice(&lobe.samples);
        }
        // Few rows fit every device.
        texture.write(&gpu.device, &gpu.queue, &texels);
        Self(texture)
    }

    /// The texture.
    pub fn view(&self) -> &wgpu::TextureView {
        self.0.view()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_roughness_are_inverse() {
        for i in 0..=1000u16 {
            let roughness = f32::from(i) / 1000.0;
            assert!((roughness_of_level(level_of_roughness(roughness)) - roughness).abs() < 1e-5, "{roughness}");
        }
        assert_eq!(level_of_roughness(1.0), ENVIRONMENT_LEVEL_LAST);
        assert!((roughness_of_level(ENVIRONMENT_LEVEL_HALF) - 0.5).abs() < 1e-6);
        assert!((roughness_of_level(ENVIRONMENT_LEVEL_HALF - 0.001) - 0.5).abs() < 1e-3);
    }

    #[test]
    fn integrals_of_lobes_are_sums() {
        for alpha in [0.05f32, 0.3, 0.9, 1.0] {
            let steps = 200_000u32;
            let sum: f64 = (0..steps)
                .map(|i| {
                    let x = (f64::from(i) + 0.5) / f64::from(steps);
                    let a2 = f64::from(alpha * alpha);
                    let d = 1.0 - 0.5 * (1.0 + x) * (1.0 - a2);
                    0.5 * x * a2 / (d * d) / f64::from(steps)
                })
                .sum();
            assert!((f64::from(lobe_integral(alpha)) / sum - 1.0).abs() < 1e-3, "{alpha}: {sum}");
        }
    }

    #[test]
    fn all_directions_are_a_sphere() {
        let solid_angle: f32 = Lobe::of_sphere(1.0, 16, 128).samples.iter().map(|sample| sample[3]).sum();
        assert!((solid_angle / (4.0 * PI) - 1.0).abs() < 1e-5, "{solid_angle}");
    }
}
