//! Settings of the frame as a whole.

use crate::setting::{choices, settings};

choices! {
    /// The shading path: where opaque surfaces are shaded.
    pub enum Path {
        /// Deferred shading: surfaces go into the G-buffer, and light is added afterwards.
        #[default]
        Deferred = "deferred",
        /// Forward shading: every surface is shaded where it is drawn.
        Forward = "forward",
        /// Forward shading that draws every surface again for each eight lights that reach it.
        ForwardBatched = "forward-batched",
        /// Gouraud shading: forward, with light computed at vertices.
        Gouraud = "gouraud",
    }
}

settings! {
    /// Settings of the frame as a whole.
    pub struct RenderSettings {
        /// Where opaque surfaces are shaded: from the G-buffer (`deferred`), or where they are drawn (forward).
        path: Path = Path::Deferred;
        /// The factor from the output's width and height to those of shading, each rounded to whole pixels. The output
        /// keeps its size.
        scale: f32 = 1.0, in 0.25..=2.0, unit "factor";
    }
}
