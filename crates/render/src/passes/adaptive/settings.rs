//! Settings of adaptive sampling.

use crate::setting::settings;

settings! {
    /// Settings of adaptive sampling: later samples of a still skip converged tiles.
    pub struct AdaptiveSettings {
        /// Adaptive sampling: converged tiles of 4 × 4 pixels are skipped by later samples. It compares the mean of a
        /// quarter or half of a still's samples with that of half as many. A tile has converged if they differ by at
        /// most this many 255ths of the display's range. 0 gives every pixel all samples. Stills with linear output
        /// take all samples. So do stills whose pixels read their neighbours: with transmissive surfaces, volumetric
        /// fog, ambient occlusion, screen-space reflections or global illumination. The same holds for contact shadows,
        /// effects on radiance, and another `render.scale`. Depth of field and motion blur of the camera take all
        /// samples, too.
        threshold: f32 = 2.0, in 0.0..=16.0;
    }
}
