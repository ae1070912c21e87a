//! The samples of the lobes of GGX by which the environment is blurred, and its levels of roughness.

use crate::constants::{
    ENVIRONMENT_LEVEL_COARSE, ENVIRONMENT_LEVEL_HALF, ENVIRONMENT_LEVEL_LAST, ENVIRONMENT_ROUGHNESS_FIRST,
};
use crate::gpu::Gpu;
use crate::gpu::data_texture::DataTexture;
use glam::Vec3;
pub(crate) use manypass_scene::environment::CUBE_FACES as FACES;
use std::f32::consts::{PI, TAU};

/// The samples of lobes that are neither narrow nor wide.
const SAMPLES: u32 = 512;

/// The most samples of a lobe, a row of the table: all texels of the faces.
const SAMPLES_MAX: u32 = 6 * IRRADIANCE_SIDE * IRRADIANCE_SIDE;

/// The side of the faces whose texels are all directions of a wide lobe, and of that of irradiance.
const SPHERE_SIDE: u32 = 8;
const IRRADIANCE_SIDE: u32 = 16;

/// What the lobe of a level is summed from.
#[derive(Clone, Debug)]
pub(crate) struct Lobe {
    /// The square of the perceptual roughness.
    pub alpha: f32,
    /// Whether the samples are all directions, and not those of the lobe.
    pub is_of_sphere: bool,
    /// Directions of the lobe about +Z, seen along +Z, whose z is their weight, with the level of the halves of the environment
    /// that holds as much of all directions as a sample stands for. Or all directions with their solid angles.
    pub samples: Vec<[f32; 4]>,
    /// The level of the halves for all directions.
    pub source_level: f32,
}

impl Lobe {
    /// `count` directions by importance, for a source whose finest faces have `source_side` texels a side.
    fn by_importance(alpha: f32, count: u32, source_side: u32) -> Self {
        let a2 = alpha * alpha;
        let texel = 4.0 * PI / (6.0 * (source_side * source_side) as f32);
        let levels = source_side.ilog2() as f32;
        let sample = |i: u32| {
            // The sequence of Hammersley.
            let (u, v) = ((i as f32 + 0.5) / count as f32, i.reverse_bits() as f32 / 4_294_967_296.0);
            let cos_squared = (1.0 - u) / (1.0 + (a2 - 1.0) * u);
            let (cos, sin) = (cos_squared.sqrt(), (1.0 - cos_squared).max(0.0).sqrt());
            let z = 2.0 * cos_squared - 1.0;
            let across = 2.0 * cos * sin;
            let d = 1.0 - cos_squared * (1.0 - a2);
            // Of the direction of light: the distribution of half vectors divided by 4.
            let density = a2 / (PI * d * d) * 0.25;
            let level = 0.5 * (1.0 / (count as f32 * density) / texel).log2();
            (z > 0.0).then(|| [across * (TAU * v).cos(), across * (TAU * v).sin(), z, level.clamp(0.0, levels)])
        };
        Self { alpha, is_of_sphere: false, samples: (0..count).filter_map(sample).collect(), source_level: 0.0 }
    }

    /// All directions: the texels of faces of `side` texels a side. Wide lobes are smooth at that distance.
    pub fn of_sphere(alpha: f32, side: u32, source_side: u32) -> Self {
        let side = side.min(source_side);
        let place = |at: u32| (2.0 * at as f32 + 1.0) / side as f32 - 1.0;
        let texels = (0..side * side).map(|i| [place(i % side), place(i / side)]);
        let sample = |[right, down, forward]: [Vec3; 3], [x, y]: [f32; 2]| {
            let direction = forward + x * right + y * down;
            let solid_angle = 4.0 / (side * side) as f32 / direction.length().powi(3);
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
                level if level == ENVIRONMENT_LEVEL_LAST => Self::of_sphere(alpha, IRRADIANCE_SIDE, source_side),
                level if level > ENVIRONMENT_LEVEL_HALF + 1.0 => Self::of_sphere(alpha, SPHERE_SIDE, source_side),
                // Their tiles are large, and the narrowest lobes hold few texels of the source.
                level if level < 4.0 => Self::by_importance(alpha, 32, source_side),
                level if level < ENVIRONMENT_LEVEL_COARSE => Self::by_importance(alpha, 96, source_side),
                _ => Self::by_importance(alpha, SAMPLES, source_side),
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
        ENVIRONMENT_ROUGHNESS_FIRST * ((level - 1.0) / 3.0).exp2()
    } else {
        (0.5 + (level - ENVIRONMENT_LEVEL_HALF) / 8.0).min(1.0)
    }
}

/// The level of a perceptual roughness, from 0 to 1: as `environment_tiles.wgsl` has it.
pub(crate) fn level_of_roughness(roughness: f32) -> f32 {
    let ratio = roughness / ENVIRONMENT_ROUGHNESS_FIRST;
    if ratio < 1.0 {
        ratio
    } else if roughness < 0.5 {
        1.0 + 3.0 * ratio.log2()
    } else {
        ENVIRONMENT_LEVEL_HALF + (roughness - 0.5) * 8.0
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
        assert_eq!(level_of_roughness(0.25), ENVIRONMENT_LEVEL_COARSE);
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
        assert!((solid_angle / (4.0 * PI) - 1.0).abs() < 0.01, "{solid_angle}");
    }
}
