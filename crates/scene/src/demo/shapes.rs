//! Shapes that demos are built of, where [`crate::primitives`] has none such.

use crate::{Aabb, Primitive};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Half a circle from the lower to the upper pole, as (radius, y).
pub(super) fn arc(radius_m: f32, segments: u8) -> Vec<Vec2> {
    let angle = |i: u8| PI * f32::from(i) / f32::from(segments);
    (0..=segments).map(|i| Vec2::new(angle(i).sin().max(0.0), -angle(i).cos()) * radius_m).collect()
}

/// Turns `profile`, a line of (radius, y) with its outside to the right, about Y through `turn_rad`, from X towards Z.
pub(super) fn lathe(profile: &[Vec2], segments: u8, smooth: bool, turn_rad: f32) -> Primitive {
    let mut primitive = Primitive::default();
    let last = profile.len() - 1;
    let closed = profile[0].distance(profile[last]) < 1e-4;
    let outside = |i: usize| (profile[i + 1] - profile[i]).normalize();
    let tangent = |i: usize| match (i, closed) {
        (0, true) => outside(0) + outside(last - 1),
        (0, false) => {
            if profile[0].x < 1e-4 {
                Vec2::X
            } else {
                outside(0)
            }
        }
        (i, true) if i == last => outside(0) + outside(last - 1),
        (i, false) if i == last => {
            if profile[last].x < 1e-4 {
                Vec2::NEG_X
            } else {
                outside(last - 1)
            }
        }
        (i, _) => outside(i) + outside(i - 1),
    };
    for i in 0..last {
        let first = primitive.positions.len() as u32;
        for end in [i, i + 1] {
            let along = if smooth { tangent(end).normalize() } else { outside(i) };
            for j in 0..=segments {
                let (sin, cos) = (turn_rad * f32::from(j) / f32::from(segments)).sin_cos();
                let (point, normal) = (profile[end], Vec2::new(along.y, -along.x));
                primitive.positions.push([point.x * cos, point.y, point.x * sin]);
                primitive.normals.push([normal.x * cos, normal.y, normal.x * sin]);
                primitive.uv0.push([f32::from(j) / f32::from(segments), 1.0 - end as f32 / last as f32]);
            }
        }
        for j in 0..u32::from(segments) {
            let a = first + j;
            let (b, c) = (a + u32::from(segments) + 1, a + 1);
            primitive.indices.extend([a, b, c, c, b, b + 1]);
        }
    }
    primitive.bounds = Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from));
    primitive
}

/// A cube of 1 m around the origin.
pub(super) fn cube() -> Primitive {
    let mut primitive = Primitive::default();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
        let u = Vec3::new(axis.y, axis.z, axis.x);
        let v = axis.cross(u);
        let first = primitive.positions.len() as u32;
        for (s, t) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
            primitive.positions.push((0.5 * axis + s * u + t * v).to_array());
            primitive.normals.push(axis.to_array());
            primitive.uv0.push([s + 0.5, 0.5 - t]);
        }
        primitive.indices.extend([0, 1, 2, 2, 3, 0].map(|index| first + index));
    }
    primitive.bounds = Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from));
    primitive
}
