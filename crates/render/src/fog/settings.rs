//! Settings of distance fog.

use super::FogMode;
use crate::setting::{LinearColor, settings};

settings! {
    /// Settings of distance fog.
    pub struct FogSettings {
        /// How fog grows with the distance from the eye, measured along the ray; exponential modes need `density_per_m`,
        /// linear ones `end_m`.
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
    }
}
