//! How much a camera shows of a model.

use super::Framing;
use crate::Projection;
use glam::{Mat4, Vec2};

/// A camera that shows less of a model's outer points than this does not show the model.
pub const LEAST_OF_MODEL: f32 = 0.1;

/// A camera in whose picture the rectangle around a model takes a smaller share than this does not show the model.
pub const LEAST_OF_PICTURE: f32 = 0.1;

/// What of a model a camera has in its picture; what hides it is not looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// The share of the model's outer points that lie in the picture.
    pub of_model: f32,
    /// The share of the picture that the rectangle around them takes.
    pub of_picture: f32,
}

impl Shown {
    /// Whether that is enough for a picture of the model.
    pub fn is_enough(self) -> bool {
        self.of_model >= LEAST_OF_MODEL && self.of_picture >= LEAST_OF_PICTURE
    }
}

impl Framing {
    /// What a camera shows of what is framed, in a picture whose width is `aspect` times its height.
    pub fn shown_by(&self, (world_from_view, projection): (Mat4, Projection), aspect: f32) -> Shown {
        let view_from_world = world_from_view.inverse();
        let half = projection.half_extent(aspect);
        let is_parallel = matches!(projection, Projection::Orthographic { .. });
        let (mut low, mut high, mut inside, mut all) = (Vec2::INFINITY, Vec2::NEG_INFINITY, 0u32, 0u32);
        for point in self.points.iter() {
            let seen = view_from_world.transform_point3(point + self.center_world());
            let depth = -seen.z;
            let place = seen.truncate() / (half * if is_parallel { 1.0 } else { depth });
            all += 1;
            if depth <= 0.0 || !place.is_finite() {
                continue;
            }
            inside += u32::from(place.abs().max_element() <= 1.0);
            (low, high) = (low.min(place), high.max(place));
        }
        let extent = (high.clamp(Vec2::NEG_ONE, Vec2::ONE) - low.clamp(Vec2::NEG_ONE, Vec2::ONE)).max(Vec2::ZERO);
        let of_picture = if low.is_finite() { 0.25 * extent.x * extent.y } else { 0.0 };
        Shown { of_model: inside as f32 / all.max(1) as f32, of_picture }
    }
}
