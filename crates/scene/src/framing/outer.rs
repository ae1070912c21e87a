//! Leaves out what no camera has to look for: points that lie inside others.

use crate::turns::{Turns, give_turn, in_slices};
use glam::Vec3;
use std::ops::Range;

/// Fewer points are kept as they are.
const MANY: usize = 65_536;

/// Where the points are looked for that others lie between: along the axes and the diagonals.
const DIRECTIONS: [Vec3; 14] = [
    Vec3::X,
    Vec3::NEG_X,
    Vec3::Y,
    Vec3::NEG_Y,
    Vec3::Z,
    Vec3::NEG_Z,
    Vec3::new(1.0, 1.0, 1.0),
    Vec3::new(-1.0, 1.0, 1.0),
    Vec3::new(1.0, -1.0, 1.0),
    Vec3::new(-1.0, -1.0, 1.0),
    Vec3::new(1.0, 1.0, -1.0),
    Vec3::new(-1.0, 1.0, -1.0),
    Vec3::new(1.0, -1.0, -1.0),
    Vec3::new(-1.0, -1.0, -1.0),
];

/// A point is inside where it is nearer to the middle than a face by this share of the shape's size, far above what
/// rounding does.
const MARGIN: f32 = 1e-4;

/// Takes points out that lie inside the convex hull of 14 others, if there are many: whatever direction is looked
/// along, none of them is the farthest. `center` is among them: far from the origin nothing else is exact.
pub(super) async fn drop_inner(points: &mut Vec<Vec3>, center: Vec3, turns: &mut Turns<'_>) {
    if points.len() < MANY {
        return;
    }
    let farthest = |direction: Vec3| {
        let mut most = (f32::NEG_INFINITY, Vec3::ZERO);
        for point in points.iter() {
            let from_center = *point - center;
            let reach = from_center.dot(direction);
            if reach > most.0 {
                most = (reach, from_center);
            }
        }
        most.1
    };
    let mut corners = [Vec3::ZERO; DIRECTIONS.len()];
    for (corner, direction) in corners.iter_mut().zip(DIRECTIONS) {
        give_turn(turns).await;
        *corner = farthest(direction);
    }
    let size = corners.iter().fold(0.0, |size: f32, corner| size.max(corner.distance(corners[0])));
    let faces = faces(&corners, MARGIN * size);
    if !faces.is_empty() {
        let is_beyond = |point: Vec3, (normal, distance): &(Vec3, f32)| point.dot(*normal) > distance - MARGIN * size;
        let is_outer = |point: &&Vec3| faces.iter().any(|face| is_beyond(**point - center, face));
        let mut outer: Vec<Vec3> = Vec::new();
        let keep = |range: Range<usize>| outer.extend(points.get(range).unwrap_or_default().iter().filter(is_outer));
        in_slices(points.len(), turns, keep).await;
        outer.shrink_to_fit();
        *points = outer;
    }
}

/// The unit normals of the faces of the convex hull of `corners`, outwards, and how far the faces are from the origin
/// along them.
fn faces(corners: &[Vec3; DIRECTIONS.len()], margin: f32) -> Vec<(Vec3, f32)> {
    let mut faces: Vec<(Vec3, f32)> = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        for (j, b) in corners.iter().enumerate().skip(i + 1) {
            for c in &corners[j + 1..] {
                let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
                for normal in [normal, -normal] {
                    let distance = normal.dot(*a);
                    let is_known = |(known, at): &(Vec3, f32)| known.dot(normal) > 0.999_999 && at - distance < margin;
                    let is_outermost = corners.iter().all(|corner| corner.dot(normal) <= distance + margin);
                    if is_outermost && !faces.iter().any(is_known) {
                        faces.push((normal, distance));
                    }
                }
            }
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points all over a shape, more than are kept as they are.
    fn many(shape: impl Fn(f32, f32, f32) -> Vec3) -> Vec<Vec3> {
        let place = |index: u32| {
            let [x, y, z] = [0.754_877_7, 0.569_840_3, 0.362_881_5].map(|step: f64| (f64::from(index) * step).fract());
            shape(x as f32, y as f32, z as f32)
        };
        (0..MANY as u32 + 1000).map(place).collect()
    }

    #[test]
    fn the_farthest_in_every_direction_stays() {
        let on_sphere =
            |x: f32, y: f32, z: f32| (Vec3::new(x, y, z) - 0.5).normalize_or_zero() * (0.2 + 0.8 * z) + 40.0;
        let far = Vec3::new(1e5, 10.0, 2e5);
        let shapes: [(&str, Vec<Vec3>, bool); 6] = [
            ("a block", many(|x, y, z| Vec3::new(x, 3.0 * y, 0.1 * z) - 7.0), true),
            ("a ball", many(on_sphere), true),
            ("a block far away", many(|x, y, z| 10.0 * Vec3::new(x, y, z) + far), true),
            ("a ball far away", many(|x, y, z| 10.0 * (on_sphere(x, y, z) - 40.0) + far), true),
            ("a plane", many(|x, y, _| Vec3::new(x, y, x - y)), false),
            ("one point", many(|_, _, _| Vec3::splat(3.0)), false),
        ];
        for (name, points, gets_fewer) in shapes {
            let mut outer = points.clone();
            let center = crate::Aabb::from_points(points.iter().copied()).center();
            crate::turns::at_once(drop_inner(&mut outer, center, &mut || None));
            assert_eq!(4 * outer.len() < 3 * points.len(), gets_fewer, "{name}: {} of {}", outer.len(), points.len());
            for turn in 0..500 {
                let (turn, height) = (f32::from(turn as u16), f32::from(turn as u16) / 250.0 - 1.0);
                let around = (1.0 - height * height).max(0.0).sqrt();
                let direction = Vec3::new(turn.cos() * around, height, turn.sin() * around);
                let reach = |point: &Vec3| (*point - center).dot(direction);
                let most = |points: &[Vec3]| points.iter().map(reach).fold(f32::MIN, f32::max);
                assert_eq!(most(&outer), most(&points), "{name} along {direction}");
            }
        }
    }
}
