//! Fisheye pictures: what is asked of the views that they are put together from.

use super::Renderer;
use super::part::PlannedView;
use super::view_kind::{Drawing, ViewKind};
use crate::camera_settings::Fisheye;
use crate::fisheye::{Face, FisheyeFaces, FisheyeInfo};
use crate::request::{Averaging, FrameRequest};
use crate::view::{self, View};
use glam::{Mat4, Vec2};
use manypass_scene::Projection;

impl Renderer {
    /// The views that the picture of `request` is put together from, if that is one of a fisheye.
    pub fn fisheye(&self, request: &FrameRequest) -> Option<FisheyeInfo> {
        Some(faces_of(request, self.gpu.capabilities.max_texture_size)?.info())
    }
}

fn faces_of(request: &FrameRequest, limit_px: u32) -> Option<FisheyeFaces> {
    // Views are shaded at that scale.
    let limit_px = (limit_px as f32 / request.settings.render.scale.max(1.0)) as u32;
    FisheyeFaces::new(&request.settings.camera, (request.width, request.height), limit_px)
}

/// The views that a picture is made of, the picture itself last, each with its name.
pub(super) fn parts_of(name: &str, request: FrameRequest, limit_px: u32) -> Vec<PlannedView> {
    let Some(of_fisheye) = faces_of(&request, limit_px) else {
        return vec![PlannedView::new(name.into(), request, ViewKind::picture())];
    };
    let before = if name.is_empty() { String::new() } else { format!("{name}/") };
    let face = |face: &Face| {
        PlannedView::new(format!("{before}fisheye/{}", face.side.name()), request_of(face, &request), kind_of(*face))
    };
    let mut parts: Vec<_> = of_fisheye.faces.iter().map(face).collect();
    let drawing = Drawing::Fisheye(of_fisheye);
    let kind =
        ViewKind { drawing, draws_surfaces: false, is_sheared: true, keeps_border: false, ..ViewKind::picture() };
    parts.push(PlannedView::new(name.into(), request, kind));
    parts
}

/// A view that a picture is put together from. Its frustum is sheared.
fn kind_of(face: Face) -> ViewKind {
    let shear = (face.shift_ndc(), face.beyond());
    ViewKind { is_sheared: true, shear, ..ViewKind::within(Drawing::Face(face)) }
}

/// What is asked of a view where `request` is asked of the picture.
fn request_of(face: &Face, request: &FrameRequest) -> FrameRequest {
    let (width, height) = face.size();
    let (near_m, far_m) = match request.camera.projection {
        Projection::Perspective { near_m, far_m, .. } => (near_m, far_m),
        Projection::Orthographic { near_m, far_m, .. } => (near_m, Some(far_m)),
    };
    let camera = View {
        world_from_view: request.camera.world_from_view * Mat4::from_quat(face.side.rotation()),
        projection: Projection::Perspective { fov_y_rad: face.fov_y_rad(), near_m, far_m },
    };
    // Without what its variables and effects would be.
    let averaging = Averaging::Radiance;
    let (want_aovs, effects, previous) = (Vec::new(), Vec::new(), None);
    let of_face = FrameRequest { width, height, camera, averaging, want_aovs, effects, previous, ..request.clone() };
    of_face.with(|settings| settings.camera.fisheye = Fisheye::None)
}

/// From a place on a side to its texture, in a frame of `request` whose view is shaded at a size.
pub(super) fn uv_from_place(face: &Face, request: &FrameRequest, shaded_size: (u32, u32)) -> [f32; 4] {
    let (sample_index, sample_count) = request.sample();
    let shaded_px = Vec2::new(shaded_size.0 as f32, shaded_size.1 as f32);
    face.uv_from_place(view::jitter_px(sample_index, sample_count) / shaded_px)
}
