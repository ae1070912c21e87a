//! Settings of relief from height maps.

use crate::setting::settings;

settings! {
    /// Settings of relief from height maps.
    pub struct ReliefSettings {
        /// Parallax mapping by steps (`steep`, `occlusion`) divides the depth of a height map into this many layers at
        /// least: where it is seen from above, and where texels are large.
        steps_min: u32 = 8, in 1..=256;
        /// And into this many at most, where the line of sight passes over many texels; 0 for 32 with `steep` and 128
        /// with `occlusion`. What is less than `relief.steps_min` counts as that.
        steps_max: u32 = 0, in 0..=1024;
    }
}

impl ReliefSettings {
    /// The `override` constants that shaders take for them: none where they are as declared.
    pub(crate) fn constants(&self) -> impl Iterator<Item = (&'static str, u32)> {
        let default = Self::default();
        let all = [
            ("relief_steps_min", self.steps_min, default.steps_min),
            ("relief_steps_max", self.steps_max, default.steps_max),
        ];
        all.into_iter().filter(|(_, value, default)| value != default).map(|(name, value, _)| (name, value))
    }
}
