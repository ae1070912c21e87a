//! Settings of screen-space global illumination.

use crate::resolution::Resolution;
use crate::setting::{rounded_up, settings};

settings! {
    /// Settings of screen-space global illumination (SSGI): one diffuse bounce between opaque surfaces that the picture
    /// shows.
    pub struct GiSettings {
        /// Screen-space global illumination (SSGI): opaque surfaces light each other diffusely, in place of the
        /// environment from the same directions. Transmissive surfaces have no part in it, nor has anything outside the
        /// picture. Stills draw all samples of all pixels.
        enabled: bool = false, needs "render.path=deferred";
        /// The distance over which surfaces light each other; the last quarter fades out. 0 for a quarter of the
        /// visible extent.
        radius_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "gi.enabled=true";
        /// The thickness model of occluders: 0 extends them without end behind their visible front, 1 makes them thin
        /// sheets.
        thinness: f32 = 0.1, in 0.0..=1.0, unit "share", needs "gi.enabled=true";
        /// The clamp on the radiance that surfaces send. It avoids fireflies of small lamps, most of which are lights
        /// as well. 0 clamps nothing.
        brightness_max: f32 = 2.0, in 0.0..=1e6, unit "× white", needs "gi.enabled=true";
        /// The size of the pass. The result is upsampled from texels of the same surface.
        resolution: Resolution = Resolution::Half, needs "gi.enabled=true";
        /// The number of directions in the picture that are searched for light, each to both sides. Rounded up to 1, 2,
        /// 3, 4, 6, 8, 12 or 16, to limit the number of pipelines.
        slices: u32 = 2, in 1..=16, needs "gi.enabled=true";
        /// The number of pixels that are read along each side of a direction. Rounded up to 2, 4, 8, 12, 16, 24, 32 or
        /// 64, to limit the number of pipelines.
        steps: u32 = 12, in 1..=64, needs "gi.enabled=true";
    }
}

impl GiSettings {
    /// The lengths of loops that shaders have for them.
    pub(super) fn constants(&self) -> [(&'static str, u32); 2] {
        let slices = rounded_up(self.slices, &[1, 2, 3, 4, 6, 8, 12, 16]);
        [("slices", slices), ("steps", rounded_up(self.steps, &[2, 4, 8, 12, 16, 24, 32, 64]))]
    }
}
