//! Settings of distance fog.

use super::FogMode;
use crate::setting::{LinearColor, settings};

settings! {
    /// Settings of distance fog.
    pub struct FogSettings {
        /// How fog grows with the distance from the eye, measured along the ray; exponential modes need
        /// `density_per_m`, linear ones `end_m`.
        mode: FogMode = FogMode::None;
        /// The colour of fog that nothing is seen through.
        color: LinearColor = LinearColor([0.5, 0.55, 0.6]);
        /// Multiplies the colour, which makes the radiance of fog; strong lights need strong fog to be seen in.
        intensity: f32 = 1.0, in 0.0.., unit "factor";
        /// How dense exponential fog is: 1 / the distance at which a share of 1/e comes through.
        density_per_m: f32 = 0.05, in 0.0.., unit "1/m";
        /// Up to this distance there is no fog.
        start_m: f32 = 0.0, in 0.0.., unit "m";
        /// From this distance on linear fog hides everything; at or before `start_m` it is a wall there.
        end_m: f32 = 50.0, in 0.0.., unit "m", needs "fog.mode=linear";
        /// Whether the environment behind all surfaces, which is infinitely far away, is hidden as well.
        background: bool = false, needs "background.source=environment";
        /// Every so many metres upwards fog is 1/e as dense; 0 for fog that is the same everywhere.
        scale_height_m: f32 = 0.0, in 0.0.., unit "m", needs "fog.mode=exponential";
        /// The height at which fog that thins out upwards is as dense as `density_per_m` says.
        base_height_m: f32 = 0.0, in -1e9..=1e9, unit "m", needs "fog.mode=exponential";
        /// Of what fog takes of light, the share that it scatters once from lights towards the eye, past what casts
        /// shadows; 0 leaves lights out of fog, 1 is fog of water. Light loses nothing on its way from the light to the
        /// fog.
        scattering: f32 = 0.0, in 0.0..=1.0, unit "share", needs "fog.mode=exponential";
        /// Light in fog: the mean cosine of its turns (Henyey and Greenstein): 0 scatters evenly, towards 1 forwards,
        /// so that fog is brightest before a light.
        anisotropy: f32 = 0.0, in -0.95..=0.95, needs "fog.mode=exponential";
        /// Light in fog: places along a ray at which a light is looked for that shines everywhere; more have less
        /// noise.
        steps: u32 = 16, in 1..=128, needs "fog.mode=exponential";
        /// Light in fog: how far it is looked for where no surface is.
        far_m: f32 = 1000.0, in 0.0..=1e6, unit "m", needs "fog.mode=exponential";
        /// Light in fog: whether it is found at half the width and height, and brought to the full size by depth.
        half: bool = true, needs "fog.mode=exponential";
    }
}
