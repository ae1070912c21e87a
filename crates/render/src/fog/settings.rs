//! Settings of distance fog.

use super::FogMode;
use crate::setting::{LinearColor, settings};

settings! {
    /// Settings of distance fog and volumetric fog.
    pub struct FogSettings {
        /// How fog grows with the distance from the eye along the ray. Exponential modes need `density_per_m`, linear
        /// ones `end_m`.
        mode: FogMode = FogMode::None;
        /// The colour of opaque fog.
        color: LinearColor = LinearColor([0.5, 0.55, 0.6]);
        /// Multiplies the colour; the product is the radiance of fog. Under strong lights, only a high intensity makes
        /// fog visible.
        intensity: f32 = 1.0, in 0.0.., unit "factor";
        /// The density of exponential fog: 1 / the distance at which its transmittance is 1/e.
        density_per_m: f32 = 0.05, in 0.0.., unit "1/m";
        /// The distance at which fog begins.
        start_m: f32 = 0.0, in 0.0.., unit "m";
        /// The distance from which linear fog hides everything; at or before `start_m` it is a wall there.
        end_m: f32 = 50.0, in 0.0.., unit "m", needs "fog.mode=linear";
        /// Whether fog hides the environment behind all surfaces, too, which is infinitely far away.
        background: bool = false, needs "background.source=environment";
        /// The scale height of fog: this much higher its density is 1/e; 0 for uniform fog.
        scale_height_m: f32 = 0.0, in 0.0.., unit "m", needs "fog.mode=exponential";
        /// The height at which fog with a scale height has the density `density_per_m`.
        base_height_m: f32 = 0.0, in -1e9..=1e9, unit "m", needs "fog.mode=exponential";
        /// Volumetric fog: the share of the lost light that fog scatters once from lights towards the eye. Shadows
        /// block it (light shafts). 0 leaves lights out, 1 is fog of water. Light is not attenuated between lamp and
        /// fog.
        scattering: f32 = 0.0, in 0.0..=1.0, unit "share", needs "fog.mode=exponential";
        /// Volumetric fog: the mean cosine of the scattering angle (Henyey–Greenstein). 0 scatters evenly. Towards 1 it
        /// scatters forwards, so that fog is brightest in front of a light.
        anisotropy: f32 = 0.0, in -0.95..=0.95, needs "fog.mode=exponential";
        /// Volumetric fog: the number of steps along a ray for lights that reach everywhere; more have less noise.
        steps: u32 = 16, in 1..=128, needs "fog.mode=exponential";
        /// Volumetric fog: the length of rays that meet no surface.
        far_m: f32 = 1000.0, in 0.0..=1e6, unit "m", needs "fog.mode=exponential";
        /// Volumetric fog: whether it is computed at half the width and height, and upsampled by depth.
        half: bool = true, needs "fog.mode=exponential";
    }
}
