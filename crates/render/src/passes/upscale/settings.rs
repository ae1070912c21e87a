//! Settings of upscaling.

use crate::setting::{choices, settings};

choices! {
    /// How a picture is enlarged that is shaded at less than its own size.
    pub enum UpscaleMethod {
        /// Linearly between four shaded pixels.
        #[default]
        Bilinear = "bilinear",
        /// From twelve of them, along the edges that they show.
        Edges = "edges",
        /// By anti-aliasing over time, whose mean has the picture's size; frames that it does not act on as by `edges`.
        Temporal = "temporal",
    }
}

settings! {
    /// Settings of upscaling, from the size at which frames are shaded to that of the picture.
    pub struct UpscaleSettings {
        /// How pictures are enlarged that are shaded at less than their own size (`render.scale` below 1): linearly,
        /// along edges, or by the frames before, which needs `taa.enabled=true`.
        method: UpscaleMethod = UpscaleMethod::Bilinear;
    }
}
