//! Settings of how lights are found.

use crate::setting::{choices, settings};

choices! {
    /// The way of light culling: how the lights that reach a pixel are found.
    pub enum LightCulling {
        /// A list for every cluster.
        #[default]
        Clustered = "clustered",
        /// A list for every tile of the picture; of a list, what lies before or behind all of the tile's surfaces is
        /// passed over (deferred path).
        Tiled = "tiled",
        /// A sphere or cone around each light is drawn, and the light of pixels before its back is added (deferred
        /// path).
        Volumes = "volumes",
        /// The same, but only for pixels that the stencil marks as inside of the volume (deferred path).
        VolumesStencil = "volumes-stencil",
        /// Every pixel visits every light.
        None = "none",
    }
}

settings! {
    /// Settings of how lights are found.
    pub struct LightSettings {
        /// How lights are kept from pixels that they do not reach.
        culling: LightCulling = LightCulling::Clustered;
        /// A light with a range is left out, with its shadow map, where what it reaches is fewer pixels wide than this;
        /// from twice as many on down its range shrinks. Its light is lost.
        min_px: f32 = 0.0, in 0.0..=64.0, unit "px";
    }
}

settings! {
    /// Settings of the lists of lights.
    pub struct ClusterSettings {
        /// The side of a tile of the light lists, be they of clusters or of tiles.
        tile_px: u32 = 16, in 8..=128, unit "px";
        /// The number of slices of the light lists along the view axis.
        slices: u32 = 32, in 1..=64, needs "lights.culling=clustered";
    }
}
