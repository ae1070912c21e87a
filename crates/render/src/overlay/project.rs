//! Where places of the world are in the picture.

use crate::fisheye::FisheyeLens;
use crate::view::View;
use glam::{Mat4, Vec2, Vec3};
use manypass_scene::Projection;

/// A place in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PicturePoint {
    /// From the upper left corner.
    pub place_px: Vec2,
    /// Along the view's axis.
    pub distance_m: f32,
}

/// A camera and its picture.
#[derive(Debug)]
pub(super) struct Projector {
    view_from_world: Mat4,
    projection: Projection,
    pub size_px: Vec2,
    lens: Option<FisheyeLens>,
}

impl Projector {
    pub fn new(camera: &View, (width, height): (u32, u32), lens: Option<FisheyeLens>) -> Self {
        let size_px = Vec2::new(width as f32, height as f32);
        Self { view_from_world: camera.world_from_view.inverse(), projection: camera.projection, size_px, lens }
    }

    /// A point in view space.
    pub fn view(&self, position_world: Vec3) -> Vec3 {
        self.view_from_world.transform_point3(position_world)
    }

    /// The least distance at which points are seen.
    pub fn near_m(&self) -> f32 {
        match self.projection {
            Projection::Perspective { near_m, .. } => near_m.max(1e-6),
            Projection::Orthographic { .. } => f32::MIN,
        }
    }

    /// Where a point of view space is seen; none behind the eye, and outside of a fisheye's circle.
    pub fn picture(&self, position_view: Vec3) -> Option<PicturePoint> {
        let distance_m = -position_view.z;
        if let Some(lens) = &self.lens {
            let place = lens.place(position_view.as_dvec3())?.as_vec2();
            return Some(PicturePoint { place_px: 0.5 * self.size_px + Vec2::new(place.x, -place.y), distance_m });
        }
        if distance_m < self.near_m() {
            return None;
        }
        let half = self.projection.half_extent(self.size_px.x / self.size_px.y);
        let divisor = if matches!(self.projection, Projection::Orthographic { .. }) { 1.0 } else { distance_m };
        let ndc = position_view.truncate() / divisor / half;
        let place_px = (ndc * Vec2::new(0.5, -0.5) + 0.5) * self.size_px;
        place_px.is_finite().then_some(PicturePoint { place_px, distance_m })
    }

    /// What is linear across the picture and rises towards the eye, of a distance.
    pub fn nearness(&self, distance_m: f32) -> f32 {
        match self.projection {
            Projection::Perspective { .. } => 1.0 / distance_m.max(1e-6),
            Projection::Orthographic { .. } => -distance_m,
        }
    }

    /// Whether a fisheye sees it.
    pub fn is_fisheye(&self) -> bool {
        self.lens.is_some()
    }
}
