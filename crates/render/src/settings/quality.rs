//! Settings of quality.

use crate::setting::settings;

settings! {
    /// Settings of how much time a live frame may take.
    pub struct QualitySettings {
        /// So long a frame of a live view may take: settings that were not chosen are those of the best rung of a ladder
        /// that keeps to it (docs/quality.md). 0 chooses none. For the page and `bench --live`; stills refuse it.
        budget_ms: f32 = 0.0, in 0.0..=100000.0, unit "ms";
    }
}
