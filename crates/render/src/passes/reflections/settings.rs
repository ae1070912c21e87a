//! Settings of screen-space reflections.

use crate::resolution::Resolution;
use crate::setting::{Switch, rounded_up, settings};

settings! {
    /// Settings of screen-space reflections (SSR).
    pub struct ReflectionSettings {
        /// Screen-space reflections (SSR): opaque surfaces reflect each other in place of the environment, as far as
        /// the picture shows them. Transmissive surfaces have none. Stills draw all samples of all pixels.
        enabled: Switch = Switch::Auto;
        /// The roughness up to which surfaces have screen-space reflections. These fade out over the last fifth below
        /// it.
        roughness_max: f32 = 0.5, in 0.0..=1.0, unit "perceptual roughness", needs "reflections.enabled=true";
        /// The size at which rays are traced. The result is upsampled from texels of the same surface.
        resolution: Resolution = Resolution::Half, needs "reflections.enabled=true";
        /// The length of rays; the last quarter fades out. 0 for as far as anything is drawn, without fading.
        distance_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "reflections.enabled=true";
        /// The thickness of surfaces behind their visible front; rays that pass there end. Hits farther behind count
        /// less. 0 for a 250th of the visible extent.
        thickness_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "reflections.enabled=true";
        /// The clamp on the radiance that a ray brings, divided by the square of the surface's roughness. Mirrors show
        /// lamps as bright as they are, unless a single ray meets one. Rough surfaces get no fireflies. The clamp rises
        /// with the square root of the number of samples that the picture averages. 0 clamps nothing.
        brightness_max: f32 = 0.5, in 0.0..=1e6, unit "× white", needs "reflections.enabled=true";
        /// The most steps of a ray. A step crosses one pixel, or a square of up to 64 × 64 where nothing is as near.
        /// Rays that need more steps find nothing. Rounded up to 32, 96, 256 or 1024, to limit the number of pipelines.
        steps: u32 = 96, in 1..=1024, needs "reflections.enabled=true";
    }
}

impl ReflectionSettings {
    /// The most steps that shaders have, which are in two pipelines where rays are traced at half the size.
    pub(super) fn length(&self) -> u32 {
        rounded_up(self.steps, &[32, 96, 256, 1024])
    }
}
