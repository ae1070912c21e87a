//! Settings of light culling.

use crate::setting::{choices, settings};

choices! {
    /// The method of light culling: how the lights that reach a pixel are found.
    pub enum LightCulling {
        /// A list for every cluster.
        #[default]
        Clustered = "clustered",
        /// A list for every tile of the picture, without lights before or behind all of the tile's surfaces (deferred
        /// path).
        Tiled = "tiled",
        /// A light volume, a sphere or cone, is drawn for each light and adds its light (deferred path).
        Volumes = "volumes",
        /// The same, only for pixels that the stencil marks as inside the volume (deferred path).
        VolumesStencil = "volumes-stencil",
        /// Every pixel visits every light.
        None = "none",
    }
}

settings! {
    /// Settings of light culling.
    pub struct LightSettings {
        /// The method of light culling: how the lights that reach a pixel are found.
        culling: LightCulling = LightCulling::Clustered;
        /// The width of a light's range in the picture below which the light is left out, with its shadow map. Below
        /// twice this width its range shrinks. The light is lost.
        min_px: f32 = 0.0, in 0.0..=64.0, unit "px";
    }
}

settings! {
    /// Settings of the light lists of clusters and tiles.
    pub struct ClusterSettings {
        /// The side of a tile of the light lists, of clusters and of tiled culling.
        tile_px: u32 = 16, in 8..=128, unit "px";
        /// The number of slices of clusters along the view axis.
        slices: u32 = 32, in 1..=64, needs "lights.culling=clustered";
    }
}
