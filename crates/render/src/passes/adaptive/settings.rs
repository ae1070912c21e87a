//! Settings of samples that are left out.

use crate::setting::settings;

settings! {
    /// Settings of stills whose later samples leave out what the earlier ones agree on.
    pub struct AdaptiveSettings {
        /// Tiles of 4 × 4 pixels get no more samples once a quarter or a half of a picture's samples changed their display
        /// colour by at most so many 255ths over the same number before; 0 gives every pixel all samples. Pictures of linear light get all, and so do
        /// frames in which pixels show what lies beside them: with glass, light in fog, effects, or shaded at another size.
        threshold: f32 = 1.0, in 0.0..=16.0;
    }
}
