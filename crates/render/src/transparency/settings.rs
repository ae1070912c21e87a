//! Settings of blended, masked and transmissive surfaces.

use super::{Masks, TransparencyMode};
use crate::setting::settings;

settings! {
    /// Settings of blended, masked and transmissive surfaces.
    pub struct TransparencySettings {
        /// How blended surfaces are composited. `sorted` draws objects from back to front. `weighted` is a weighted
        /// mean, which is order-independent. `stochastic` makes a fragment opaque in as many samples of a still as
        /// alpha says. That is right in any order after many samples, and noisy before (docs/transparency.md).
        mode: TransparencyMode = TransparencyMode::Sorted;
        /// Which fragments alpha masks drop. `cutoff` drops those with less alpha than the cutoff. `hashed` drops those
        /// with less alpha than a hash of their position, where texels are smaller than pixels. So fine masks keep
        /// their coverage at a distance. `auto` is `hashed` in stills of four samples and more, and `cutoff` elsewhere.
        masks: Masks = Masks::Auto;
        /// The most transmissive objects that are seen behind each other. Of more objects, the farthest ones hide each
        /// other. There are only as many layers as objects overlap in the picture. Each layer takes one more copy of
        /// the picture behind it.
        refractive_layers: u32 = 4, in 1..=8;
    }
}
