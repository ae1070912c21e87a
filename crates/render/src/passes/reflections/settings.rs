//! Settings of reflections of the picture.

use crate::resolution::Resolution;
use crate::setting::{Switch, rounded_up, settings};

settings! {
    /// Settings of reflections of the picture.
    pub struct ReflectionSettings {
        /// Whether opaque surfaces reflect each other, as far as the picture shows them, in place of the environment
        /// behind. Glass does not; stills draw all samples of all pixels.
        enabled: Switch = Switch::Auto;
        /// The roughest surfaces that reflect the picture; over the last fifth below it that fades out.
        roughness_max: f32 = 0.5, in 0.0..=1.0, unit "perceptual roughness", needs "reflections.enabled=true";
        /// The size at which rays are followed; what they find is brought to the picture's by what lies on the same
        /// surface.
        resolution: Resolution = Resolution::Half, needs "reflections.enabled=true";
        /// How far rays go; what lies in the last quarter fades out. 0 for as far as anything is drawn, without
        /// fading.
        distance_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "reflections.enabled=true";
        /// How far surfaces are taken to go on behind what is seen of them, so that rays which pass there end; the
        /// farther behind, the less that counts. 0 for a 250th of the extent of what is seen.
        thickness_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "reflections.enabled=true";
        /// What a ray brings is cut to so many times the display's white, divided by the square of the surface's
        /// roughness: mirrors show lamps as bright as they are, unless a single ray meets one, and rough surfaces have
        /// no bright dots of the few rays that do. It rises by the square root of the number of samples that the
        /// picture averages. 0 cuts nothing.
        brightness_max: f32 = 0.5, in 0.0..=1e6, unit "× white", needs "reflections.enabled=true";
        /// The most steps of a ray, over pixels or over squares of up to 64 × 64 of them where nothing is as near;
        /// rays that need more find nothing. Rounded up to 32, 96, 256 or 1024, so that a slider makes few pipelines.
        steps: u32 = 96, in 1..=1024, needs "reflections.enabled=true";
    }
}

impl ReflectionSettings {
    /// The most steps that shaders have, which are in two pipelines where rays are traced at half the size.
    pub(super) fn length(&self) -> u32 {
        rounded_up(self.steps, &[32, 96, 256, 1024])
    }
}
