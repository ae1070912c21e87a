//! The outline of a flat surface in a picture.

use crate::lights::Rectangle;
use crate::view::ViewUniform;
use glam::{Mat4, Vec2, Vec3, Vec4};

/// Pixels that are drawn beyond an edge, because what is sampled between pixels looks at their neighbours.
const MARGIN_PX: f32 = 1.5;

/// Where the corners of a rectangle of the world are seen: the uniform of `passes/mirrors/outline.wgsl`, whose test
/// compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Outline {
    /// Of each edge how far inside of it a pixel lies: the product with (x, y, 1), in pixels.
    pub edges: [Vec4; 4],
}

impl Outline {
    /// Of a rectangle whose corners follow each other around it, in a view of this size.
    pub fn new(uniform: &ViewUniform, corners_world: [Vec3; 4], (width, height): (u32, u32)) -> Self {
        // (x, y, w) in pixels times w, whatever lies behind the eye.
        let placed = corners_world.map(|corner| {
            let clip = uniform.clip_from_world * corner.extend(1.0);
            let (x, y) = ((0.5 * (clip.x + clip.w)) * width as f32, (0.5 * (clip.w - clip.y)) * height as f32);
            Vec3::new(x, y, clip.w)
        });
        let middle = placed.iter().sum::<Vec3>();
        let edge = |at: usize| {
            let line = placed[at].cross(placed[(at + 1) % 4]);
            let length = line.truncate().length();
            if length <= 0.0 || !line.is_finite() {
                return Vec4::new(0.0, 0.0, 1.0, 0.0);
            }
            let side = if line.dot(middle) < 0.0 { -1.0 } else { 1.0 };
            let inside = side * line / length;
            Vec4::new(inside.x, inside.y, inside.z + MARGIN_PX, 0.0)
        };
        Self { edges: [edge(0), edge(1), edge(2), edge(3)] }
    }
}

/// The part of a picture of a size that the corners of something lie in, with the margin of its outline: all of it where a
/// corner is not before the eye.
pub fn rectangle_of(uniform: &ViewUniform, corners_world: [Vec3; 4], (width, height): (u32, u32)) -> Rectangle {
    let size = Vec2::new(width as f32, height as f32);
    let (mut least, mut most) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for corner in corners_world {
        let clip = uniform.clip_from_world * corner.extend(1.0);
        if clip.w <= 0.0 {
            return [0, 0, width, height];
        }
        let ndc = clip.truncate().truncate() / clip.w;
        let place_px = (ndc * Vec2::new(0.5, -0.5) + 0.5) * size;
        (least, most) = (least.min(place_px), most.max(place_px));
    }
    let first = (least - MARGIN_PX).floor().clamp(Vec2::ZERO, size - 1.0);
    let last = (most + MARGIN_PX).ceil().clamp(first + 1.0, size);
    let extent = last - first;
    [first.x as u32, first.y as u32, extent.x as u32, extent.y as u32]
}

/// Whether anything of a flat polygon lies in what a view shows of the world.
///
/// Source: Sutherland & Hodgman 1974, "Reentrant Polygon Clipping".
pub fn is_seen(clip_from_world: &Mat4, corners_world: &[Vec3]) -> bool {
    let mut polygon: Vec<Vec4> = corners_world.iter().map(|corner| *clip_from_world * corner.extend(1.0)).collect();
    let planes =
        [Vec4::W + Vec4::X, Vec4::W - Vec4::X, Vec4::W + Vec4::Y, Vec4::W - Vec4::Y, Vec4::W - Vec4::Z, Vec4::Z];
    for plane in planes {
        let mut left = Vec::with_capacity(polygon.len() + 1);
        for (at, corner) in polygon.iter().enumerate() {
            let next = polygon[(at + 1) % polygon.len()];
            let (here, there) = (plane.dot(*corner), plane.dot(next));
            if here >= 0.0 {
                left.push(*corner);
            }
            if (here >= 0.0) != (there >= 0.0) {
                left.push(*corner + (next - *corner) * (here / (here - there)));
            }
        }
        polygon = left;
    }
    !polygon.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{DepthRange, View};
    use manypass_scene::Projection;

    #[test]
    fn an_outline_holds_what_is_within_it() {
        let projection = Projection::Perspective { fov_y_rad: std::f32::consts::FRAC_PI_2, near_m: 0.1, far_m: None };
        let view = View { world_from_view: Mat4::IDENTITY, projection };
        let uniform = view.uniform(DepthRange { near_m: 0.1, far_m: 100.0 }, 100, 100, Vec2::ZERO, 1.0, 0);
        // From pixel 25 to 75 across, and from 40 to 60 down, at 2 m.
        let corners = [(-1.0, -0.4), (1.0, -0.4), (1.0, 0.4), (-1.0, 0.4)].map(|(x, y)| Vec3::new(x, y, -2.0));
        let mut turned = corners;
        turned.reverse();
        for corners in [corners, turned] {
            let outline = Outline::new(&uniform, corners, (100, 100));
            let holds = |x: f32, y: f32| outline.edges.iter().all(|edge| edge.dot(Vec4::new(x, y, 1.0, 0.0)) >= 0.0);
            for (x, y, expected) in
                [(50.0, 50.0, true), (26.0, 41.0, true), (24.0, 50.0, true), (23.0, 50.0, false), (50.0, 62.0, false)]
            {
                assert_eq!(holds(x, y), expected, "{x} {y}");
            }
            assert_eq!(rectangle_of(&uniform, corners, (100, 100)), [23, 38, 54, 24]);
        }
        // Partly behind the eye: what lies before it is held, and the rectangle is all of the picture.
        let floor = [(-1.0, 5.0), (1.0, 5.0), (1.0, -5.0), (-1.0, -5.0)].map(|(x, z)| Vec3::new(x, -1.0, z));
        let outline = Outline::new(&uniform, floor, (100, 100));
        let holds = |x: f32, y: f32| outline.edges.iter().all(|edge| edge.dot(Vec4::new(x, y, 1.0, 0.0)) >= 0.0);
        assert!(holds(50.0, 90.0) && holds(50.0, 62.0) && !holds(50.0, 55.0) && !holds(5.0, 62.0));
        assert_eq!(rectangle_of(&uniform, floor, (100, 100)), [0, 0, 100, 100]);
        // A wall that no side of the frustum excludes alone, but all together do: behind the eye, and partly before it.
        let turned = uniform.clip_from_world * Mat4::from_rotation_x(0.25);
        let wall = [(-3.0, -3.6), (3.0, -3.6), (3.0, 2.4), (-3.0, 2.4)].map(|(x, y)| Vec3::new(x, y, 0.8));
        assert!(!is_seen(&turned, &wall) && is_seen(&turned, &floor) && is_seen(&uniform.clip_from_world, &corners));
    }
}
