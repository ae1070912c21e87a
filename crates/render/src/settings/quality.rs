//! Settings of the frame-time budget.

use crate::setting::settings;

settings! {
    /// Settings of the frame-time budget of live views.
    pub struct QualitySettings {
        /// The frame-time budget of live views. Settings that were not chosen come from the best rung of the quality
        /// ladder that keeps to it (docs/quality.md). 0 is no budget. It is for the page and `bench --live`; stills
        /// refuse it.
        budget_ms: f32 = 0.0, in 0.0..=100000.0, unit "ms";
    }
}
