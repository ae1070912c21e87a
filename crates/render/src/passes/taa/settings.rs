//! Settings of temporal anti-aliasing.

use crate::setting::settings;

settings! {
    /// Settings of temporal anti-aliasing.
    pub struct TaaSettings {
        /// Whether frames that follow each other are anti-aliased by what the ones before showed: live views, and
        /// sequences of pictures of one sample. Stills of several samples are not.
        enabled: bool = false, needs "render.path=deferred";
        /// The most that the frames before count where something moves; the rest is the frame itself. More is smoother
        /// and softer.
        feedback: f32 = 0.8, in 0.0..=0.98, unit "share", needs "taa.enabled=true";
        /// Over how many frames the mean is taken where nothing moves.
        samples: u32 = 64, in 1..=100, unit "frames", needs "taa.enabled=true";
        /// How far the frames before may differ from what the frame shows around a pixel, in standard deviations. Less
        /// leaves no trails, and more flicker.
        clip: f32 = 1.0, in 0.25..=8.0, unit "standard deviations", needs "taa.enabled=true";
    }
}
