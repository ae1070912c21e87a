//! Settings of temporal anti-aliasing.

use crate::setting::settings;

settings! {
    /// Settings of temporal anti-aliasing.
    pub struct TaaSettings {
        /// Temporal anti-aliasing: each frame reuses the frames before. It is for live views, and for sequences of
        /// pictures of one sample. Stills of several samples do without it.
        enabled: bool = false, needs "render.path=deferred";
        /// The largest weight of the history where something moves; the rest is the frame itself. More is smoother and
        /// softer.
        feedback: f32 = 0.8, in 0.0..=0.98, unit "share", needs "taa.enabled=true";
        /// The number of frames of the mean where nothing moves.
        samples: u32 = 64, in 1..=100, unit "frames", needs "taa.enabled=true";
        /// How far the history may differ from the pixel's neighbourhood in the frame. Less leaves no trails, but more
        /// flicker.
        clip: f32 = 1.0, in 0.25..=8.0, unit "standard deviations", needs "taa.enabled=true";
    }
}
