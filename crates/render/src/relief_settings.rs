//! Settings of relief from height maps.

use crate::setting::{rounded_up, settings};

settings! {
    /// Settings of relief from height maps.
    pub struct ReliefSettings {
        /// The fewest layers of a height map in parallax mapping by steps (`steep`, `occlusion`). They are used seen
        /// from above, and where texels are large. Rounded up to 1, 4, 8, 16, 32, 64, 128 or 256, to limit the number
        /// of pipelines.
        steps_min: u32 = 8, in 1..=256;
        /// The most layers, used where the line of sight crosses many texels; 0 for 32 with `steep` and 128 with
        /// `occlusion`. Less than `relief.steps_min` counts as that. Rounded up to 0, 4, 16, 32, 64, 128, 256 or 1024,
        /// to limit the number of pipelines.
        steps_max: u32 = 0, in 0..=1024;
    }
}

impl ReliefSettings {
    /// The `override` constants that shaders take for them: none where they are as declared.
    pub(crate) fn constants(&self) -> impl Iterator<Item = (&'static str, u32)> {
        let default = Self::default();
        let least = rounded_up(self.steps_min, &[1, 4, 8, 16, 32, 64, 128, 256]);
        let most = rounded_up(self.steps_max, &[0, 4, 16, 32, 64, 128, 256, 1024]);
        let all = [("relief_steps_min", least, default.steps_min), ("relief_steps_max", most, default.steps_max)];
        all.into_iter().filter(|(_, value, default)| value != default).map(|(name, value, _)| (name, value))
    }
}
