//! Settings of how lights are found.

use crate::setting::{choices, settings};

choices! {
    /// How lights are kept from pixels that they do not reach.
    pub enum LightCulling {
        /// A list for every cluster.
        #[default]
        Clustered = "clustered",
        /// Every pixel visits every light.
        None = "none",
    }
}

settings! {
    /// Settings of how lights are found.
    pub struct LightSettings {
        /// How lights are kept from pixels that they do not reach.
        culling: LightCulling = LightCulling::Clustered;
    }
}

settings! {
    /// Settings of the lists of lights.
    pub struct ClusterSettings {
        /// The side of a tile of the light lists.
        tile_px: u32 = 16, in 8..=128, unit "px", needs "lights.culling=clustered";
        /// The number of slices of the light lists along the view axis.
        slices: u32 = 32, in 1..=64, needs "lights.culling=clustered";
    }
}
