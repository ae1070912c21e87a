//! How deep a box is within a column of light: so shadow maps of parallel light need no more depth than what they show.

use glam::{Mat3, Vec2, Vec3};
use manypass_scene::Aabb;

/// The corners of the faces of a box, as indices into [`Aabb::corners`].
const FACES: [[usize; 4]; 6] = [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];

/// The greatest and the least z in light space of the part of a box that lies within `half_m` of `center` in x and y;
/// none if the two do not meet.
pub(super) fn column_range(bounds: &Aabb, light_from_world: &Mat3, center: Vec2, half_m: f32) -> Option<(f32, f32)> {
    if bounds.is_empty() {
        return None;
    }
    let corners = bounds.corners().map(|corner| *light_from_world * corner - center.extend(0.0));
    let range = |points: &[Vec3]| points.iter().map(|at| (at.z, at.z)).reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)));
    if corners.iter().all(|corner| corner.truncate().abs().max_element() <= half_m) {
        return range(&corners);
    }
    // The column has no ends, so that its extremes within the box lie on the faces of the box.
    let of_face = |face: &[usize; 4]| {
        let mut polygon: Vec<Vec3> = face.iter().map(|at| corners[*at]).collect();
        for side in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
            polygon = clipped(&polygon, side, half_m);
        }
        range(&polygon)
    };
    FACES.iter().filter_map(of_face).reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))
}

/// The part of a convex polygon where `side · p ≤ limit` (Sutherland & Hodgman 1974).
fn clipped(polygon: &[Vec3], side: Vec3, limit: f32) -> Vec<Vec3> {
    let mut inside = Vec::with_capacity(polygon.len() + 1);
    for (at, &to) in polygon.iter().enumerate() {
        let from = polygon[(at + polygon.len() - 1) % polygon.len()];
        let (before, after) = (limit - side.dot(from), limit - side.dot(to));
        if (before < 0.0) != (after < 0.0) {
            inside.push(from + (to - from) * (before / (before - after)));
        }
        if after >= 0.0 {
            inside.push(to);
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn a_large_floor_is_as_deep_as_its_part_in_the_column() {
        // Light at 30° over a floor of 200 km: a column of 10 m a side meets 10 m / tan 30° of depth.
        let rotation = Quat::from_rotation_x(-30f32.to_radians());
        let light_from_world = Mat3::from_quat(rotation.inverse());
        let floor = Aabb { min: Vec3::new(-1e5, 0.0, -1e5), max: Vec3::new(1e5, 0.0, 1e5) };
        let (nearest, farthest) = column_range(&floor, &light_from_world, Vec2::ZERO, 5.0).unwrap();
        let expected = 10.0 / 30f32.to_radians().tan();
        assert!((nearest - farthest - expected).abs() < 0.1, "{nearest} {farthest} {expected}");
        assert!((nearest + farthest).abs() < 0.1, "{nearest} {farthest}");
    }

    #[test]
    fn a_small_box_is_as_deep_as_itself_and_one_beside_the_column_is_not_there() {
        let cube = |x: f32| Aabb { min: Vec3::new(x, -1.0, -1.0), max: Vec3::new(x + 2.0, 1.0, 1.0) };
        assert_eq!(column_range(&cube(-1.0), &Mat3::IDENTITY, Vec2::ZERO, 3.0), Some((1.0, -1.0)));
        assert_eq!(column_range(&cube(2.0), &Mat3::IDENTITY, Vec2::ZERO, 3.0), Some((1.0, -1.0)));
        assert_eq!(column_range(&cube(4.0), &Mat3::IDENTITY, Vec2::ZERO, 3.0), None);
        assert_eq!(column_range(&Aabb::EMPTY, &Mat3::IDENTITY, Vec2::ZERO, 3.0), None);
    }
}
