//! Settings of the pictures that show how a frame is made.

use crate::setting::{choices, settings};

choices! {
    /// What is shown in place of the picture.
    pub enum DebugView {
        /// The picture.
        #[default]
        Off = "off",
        /// How many lights are visited for a pixel.
        Lights = "lights",
        /// How many fragments of surfaces are drawn for a pixel.
        Overdraw = "overdraw",
        /// Texture coordinates.
        Uv = "uv",
        /// World normals.
        Normals = "normals",
        /// Texels of the base colour a pixel.
        TexelDensity = "texel_density",
        /// Inputs that cannot be right.
        Flags = "flags",
        /// The slices, along the view axis, of the lists of lights.
        Clusters = "clusters",
        /// The cascades that shadows of parallel light are read from.
        Cascades = "cascades",
        /// The levels of detail.
        Levels = "levels",
        /// The picture with its probes as spheres.
        Probes = "probes",
        /// The probes that light a pixel.
        ProbeWeights = "probe_weights",
    }
}

settings! {
    /// Settings of the pictures that show how a frame is made.
    pub struct DebugSettings {
        /// What is shown in place of the picture: lights visited for a pixel, fragments drawn for it, texture
        /// coordinates, world normals, texels of the base colour a pixel, inputs that cannot be right, slices of
        /// clusters, cascades of shadows, levels of detail, the picture with its probes as spheres, or the probes that
        /// light each pixel; radiance and variables stay what they are. `--contact-sheet` has the legend.
        view: DebugView = DebugView::Off;
    }
}
