//! Settings of samples that are left out.

use crate::setting::settings;

settings! {
    /// Settings of stills whose later samples leave out what the earlier ones agree on.
    pub struct AdaptiveSettings {
        /// Tiles of 4 × 4 pixels get no more samples once the mean of a quarter of a still's samples, or of half of
        /// them, differs from that of half as many by at most so many 255ths of the display's range; 0 gives every
        /// pixel all samples. Pictures whose linear light is asked for get all, and so do those in which pixels show
        /// what lies beside them: with glass, light in fog, ambient occlusion, reflections, light and shadows of the picture,
        /// effects on radiance, or shaded at another size; and those through a lens or an open shutter.
        threshold: f32 = 2.0, in 0.0..=16.0;
    }
}
