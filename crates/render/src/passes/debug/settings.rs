//! Settings of debug views.

use crate::setting::{choices, settings};

choices! {
    /// A debug view, shown in place of the picture.
    pub enum DebugView {
        /// The picture.
        #[default]
        Off = "off",
        /// Lights that are visited for a pixel.
        Lights = "lights",
        /// Fragments of surfaces that are drawn for a pixel.
        Overdraw = "overdraw",
        /// Texture coordinates.
        Uv = "uv",
        /// World normals.
        Normals = "normals",
        /// Texels of the base colour per pixel.
        TexelDensity = "texel_density",
        /// Invalid inputs.
        Flags = "flags",
        /// Slices of light clusters along the view axis.
        Clusters = "clusters",
        /// Shadow cascades of directional lights.
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
    /// Settings of debug views.
    pub struct DebugSettings {
        /// The debug view in place of the picture. Per pixel it shows visited lights, drawn fragments, texture
        /// coordinates, world normals, texels of the base colour, or invalid inputs. Or it shows slices of clusters,
        /// cascades, levels of detail, probes as spheres, or the probes that light each pixel. Radiance and AOVs do not
        /// change. `--contact-sheet` has the legend.
        view: DebugView = DebugView::Off;
    }
}
