//! Settings of the frame as a whole.

use crate::setting::{choices, settings};

choices! {
    /// Where shading happens.
    pub enum Path {
        /// Opaque surfaces into the G-buffer, light afterwards.
        #[default]
        Deferred = "deferred",
        /// Every surface where it is drawn.
        Forward = "forward",
        /// Every surface where it is drawn, and again for each eight of the lights that reach it.
        ForwardBatched = "forward-batched",
        /// Every surface where it is drawn, with light computed at its vertices.
        Gouraud = "gouraud",
    }
}

settings! {
    /// Settings of the frame as a whole.
    pub struct RenderSettings {
        /// Where shading happens: after opaque surfaces are in the G-buffer, or where each surface is drawn.
        path: Path = Path::Deferred;
        /// Shading happens at this many times the output's width and height, each rounded to whole pixels; the output
        /// keeps its size.
        scale: f32 = 1.0, in 0.25..=2.0, unit "factor";
    }
}
