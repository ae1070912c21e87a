//! Views of a frame before it is known what they draw: pictures, and those for the sake of what pictures show.

use super::view_kind::{MirrorLink, ViewKind};
use crate::camera_settings::{CameraSettings, Fisheye};
use crate::quality::Quality;
use crate::request::{FrameRequest, RenderError};
use crate::settings::Settings;
use crate::view::{DepthRange, View};
use manypass_scene::Projection;

/// A view of a frame, before it is known what it draws.
pub(super) struct PlannedView {
    pub name: String,
    pub request: FrameRequest,
    pub kind: ViewKind,
    /// The mirrors that it shows, whose views come before it.
    pub mirrors: Vec<MirrorLink>,
    /// In how many other pictures the monitor is seen for whose sake it is drawn.
    pub level: Option<u32>,
}

impl PlannedView {
    pub fn new(name: String, request: FrameRequest, kind: ViewKind) -> Self {
        Self { name, request, kind, mirrors: Vec::new(), level: None }
    }
}

/// The views of a frame, innermost first: those that it was asked for, and others for their sake; and how many of the
/// latter it leaves out.
#[derive(Default)]
pub(super) struct Captures {
    pub parts: Vec<PlannedView>,
    pub left_out: u32,
}

/// All distances that a camera may see.
pub(super) fn widest_range(camera: &View) -> DepthRange {
    let (near_m, far_m) = match camera.projection {
        Projection::Perspective { near_m, far_m, .. } => (near_m, far_m.unwrap_or(f32::MAX)),
        Projection::Orthographic { near_m, far_m, .. } => (near_m, far_m),
    };
    DepthRange { near_m, far_m: far_m.max(near_m * 1.001 + 1e-6) }
}

/// The settings of a picture within one whose settings are `settings`: of its own tier, but for what all views share.
pub(super) fn settings_of(quality: Option<&str>, settings: &Settings) -> Result<Settings, RenderError> {
    let mut own = settings.clone();
    own.render.scale = 1.0;
    if let Some(name) = quality {
        let quality = Quality::named(name).ok_or_else(|| RenderError::CaptureQuality { quality: name.into() })?;
        own.apply_quality(quality)?;
        own.textures = settings.textures.clone();
        own.shadows = settings.shadows.clone();
    }
    own.camera = CameraSettings { f_stop: 0.0, fisheye: Fisheye::None, ..own.camera };
    own.debug = Default::default();
    own.aov = Default::default();
    Ok(own)
}
