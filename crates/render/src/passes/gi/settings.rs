//! Settings of light between surfaces.

use crate::resolution::Resolution;
use crate::setting::{rounded_up, settings};

settings! {
    /// Settings of diffuse light that opaque surfaces send each other, as far as the picture shows them: global
    /// illumination in screen space, of one bounce.
    pub struct GiSettings {
        /// Whether opaque surfaces light each other diffusely, in place of the environment from the same directions.
        /// Glass, and light and surfaces beyond the picture have no part in it; stills draw all samples of all pixels.
        enabled: bool = false, needs "render.path=deferred";
        /// How far light comes; what lies in the last quarter fades out. 0 for a quarter of the extent of what is
        /// seen.
        radius_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "gi.enabled=true";
        /// How soon light comes past behind what rises before a surface: 0 takes everything to go on behind what is
        /// seen of it, 1 takes it to be as thin as a sheet.
        thinness: f32 = 0.1, in 0.0..=1.0, unit "share", needs "gi.enabled=true";
        /// What surfaces send is cut to so many times the display's white, so that small lamps, which mostly
        /// are lights as well, make no bright dots. 0 cuts nothing.
        brightness_max: f32 = 2.0, in 0.0..=1e6, unit "× white", needs "gi.enabled=true";
        /// The size at which light is found; it is brought to the picture's by what lies on the same surface.
        resolution: Resolution = Resolution::Half, needs "gi.enabled=true";
        /// Directions in the picture in which light is looked for, each to both sides; rounded up to 1, 2, 3, 4, 6, 8,
        /// 12 or 16, so that a slider makes few pipelines.
        slices: u32 = 2, in 1..=16, needs "gi.enabled=true";
        /// Pixels that are looked at along each side of a direction; rounded up to 2, 4, 8, 12, 16, 24, 32 or 64, so that
        /// a slider makes few pipelines.
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
