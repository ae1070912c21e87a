//! Settings of surfaces that alpha covers.

use super::{Masks, TransparencyMode};
use crate::setting::settings;

settings! {
    /// Settings of surfaces that alpha covers.
    pub struct TransparencySettings {
        /// In which way surfaces that alpha covers in part become one picture: sorted, each object over those behind
        /// it; as a weighted mean, which is the same in any order; or opaque in so many of a still's samples as alpha
        /// says, which is right in any order after many samples and noisy before (docs/transparency.md).
        mode: TransparencyMode = TransparencyMode::Sorted;
        /// Which fragments masks drop: those with less alpha than the cutoff, or at a distance, where texels are
        /// smaller than pixels, those with less than a hash of their place, so that as much stays of a fine mask as
        /// covers its pixels. `auto` is `hashed` in stills of four samples and more, and `cutoff` elsewhere.
        masks: Masks = Masks::Auto;
        /// How many objects that light comes through are seen behind each other at most: where more are, the farthest
        /// of them hide each other. There are no more layers than objects that overlap in the picture, each for one
        /// more copy of the picture behind it.
        refractive_layers: u32 = 4, in 1..=8;
    }
}
