//! What monitors are: from where they are seen, and how large.

use super::options::CaptureOptions;
use crate::{NodeId, Projection};
use glam::Mat4;

/// From where a monitor's picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MonitorCamera {
    /// From the camera of a node, wherever that is.
    Node(NodeId),
    /// From one place.
    Fixed {
        /// The camera's transform: it looks along its −Z, with its +Y up.
        world_from_view: Mat4,
        /// How space is mapped to the picture.
        projection: Projection,
    },
}

/// What a camera of the scene sees, as the texels of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// From where.
    pub camera: MonitorCamera,
    /// Width of its picture in texels.
    pub width: u32,
    /// Height of its picture in texels.
    pub height: u32,
    /// By how many stops it is exposed more than the picture that shows it.
    pub exposure_stops: f32,
    /// How it is drawn.
    pub options: CaptureOptions,
}

impl Monitor {
    /// As bright as the picture that shows it, drawn as that is, in every frame.
    pub fn new(camera: MonitorCamera, width: u32, height: u32) -> Self {
        Self { camera, width, height, exposure_stops: 0.0, options: CaptureOptions::default() }
    }
}
