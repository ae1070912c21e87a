//! Distance fog: what the medium between eye and surface takes from a surface's radiance, and what it gives. The
//! uniform of `fog.wgsl`, which the pass `fog` and surfaces that are shaded where they are drawn have in common.

mod settings;

pub use settings::FogSettings;

use crate::colour::finite_product;
use crate::constants::RADIANCE_MAX;
use crate::setting::choices;
use bytemuck::{Pod, Zeroable};

/// The constant of shaders that shade surfaces where they are drawn: whether they add the light that fog scatters
/// before them.
pub const IN_LIT_FOG: &str = "in_lit_fog";

choices! {
    /// How fog grows with the distance.
    pub enum FogMode {
        /// There is none.
        #[default]
        None = "none",
        /// In equal parts from one distance to another, where nothing else is seen any more.
        Linear = "linear",
        /// As a uniform medium does (Beer 1852, Lambert 1760): exp(-density · distance) of the light comes through.
        Exponential = "exponential",
        /// Thinner near the eye and denser far away: exp(-(density · distance)²) comes through.
        ExponentialSquared = "exponential-squared",
    }
}

/// The uniform of `fog.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FogUniform {
    /// The radiance of fog that nothing is seen through, pre-exposed.
    radiance: [f32; 3],
    /// Up to this distance there is none.
    start_m: f32,
    /// 1 / the distance over which linear fog grows; 0 unless it is linear.
    linear_per_m: f32,
    /// The density of exponential fog, else 0.
    density_per_m: f32,
    /// The density of squared exponential fog, else 0.
    squared_density_per_m: f32,
    /// 1 / the height over which density falls to 1/e; 0 for uniform fog.
    falloff_per_m: f32,
    /// The height at which density is as stated.
    base_height_m: f32,
    /// Of the light that fog takes, the share that it scatters.
    scattering: f32,
    /// The mean cosine of the turns of scattered light.
    anisotropy: f32,
    /// How far light is looked for where no surface is.
    far_m: f32,
    /// Places along a ray where a light that shines everywhere is looked at.
    steps: u32,
    /// Zeros.
    padding_a: f32,
    padding_b: f32,
    padding_c: f32,
}

impl FogSettings {
    /// Whether light from lights is seen in the fog.
    pub fn scatters(&self) -> bool {
        self.mode == FogMode::Exponential && self.scattering > 0.0 && self.density_per_m > 0.0
    }
}

impl FogUniform {
    /// The fog of a frame with this pre-exposure.
    pub fn new(settings: &FogSettings, pre_exposure: f32) -> Self {
        let scale = finite_product(settings.intensity, pre_exposure);
        let of = |mode: FogMode, value: f32| if settings.mode == mode { value } else { 0.0 };
        // Where it ends before it begins it is a wall.
        let depth_m = (settings.end_m - settings.start_m).max(1e-6);
        Self {
            radiance: settings.color.0.map(|color| finite_product(color, scale).clamp(0.0, RADIANCE_MAX)),
            start_m: settings.start_m,
            linear_per_m: of(FogMode::Linear, 1.0 / depth_m),
            density_per_m: of(FogMode::Exponential, settings.density_per_m),
            squared_density_per_m: of(FogMode::ExponentialSquared, settings.density_per_m),
            falloff_per_m: if settings.scale_height_m > 0.0 { settings.scale_height_m.max(1e-6).recip() } else { 0.0 },
            base_height_m: settings.base_height_m,
            scattering: settings.scattering,
            anisotropy: settings.anisotropy,
            far_m: settings.far_m,
            steps: settings.steps,
            padding_a: 0.0,
            padding_b: 0.0,
            padding_c: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "forward",
            "Fog",
            FogUniform,
            [
                radiance,
                start_m,
                linear_per_m,
                density_per_m,
                squared_density_per_m,
                falloff_per_m,
                base_height_m,
                scattering,
                anisotropy,
                far_m,
                steps,
                padding_a,
                padding_b,
                padding_c
            ]
        );
    }

    #[test]
    fn numbers_stay_finite() {
        let mut settings = FogSettings { mode: FogMode::Linear, start_m: 5.0, end_m: 5.0, ..FogSettings::default() };
        settings.intensity = f32::MAX;
        let uniform = FogUniform::new(&settings, f32::MAX);
        assert!(uniform.radiance.iter().all(|value| *value == RADIANCE_MAX) && uniform.linear_per_m.is_finite());
        assert_eq!(FogUniform::new(&FogSettings::default(), 1.0).linear_per_m, 0.0);
    }
}
