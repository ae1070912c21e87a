//! Settings of upscaling.

use crate::setting::{choices, settings};

choices! {
    /// How pictures are upscaled.
    pub enum UpscaleMethod {
        /// Linear interpolation of four shaded pixels.
        #[default]
        Bilinear = "bilinear",
        /// Twelve shaded pixels, weighted along edges.
        Edges = "edges",
        /// Temporal anti-aliasing, whose mean has the picture's size; frames without it use `edges`.
        Temporal = "temporal",
    }
}

settings! {
    /// Settings of upscaling, from the size at which frames are shaded to that of the picture.
    pub struct UpscaleSettings {
        /// The upscaling of pictures that are shaded at less than their own size (`render.scale` below 1). It is
        /// linear, along edges, or temporal, which needs `taa.enabled=true`.
        method: UpscaleMethod = UpscaleMethod::Bilinear;
    }
}
