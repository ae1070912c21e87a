//! Procedural geometry about the origin, counter-clockwise seen from outside, with normals, UVs and tangents.

use crate::{Aabb, Primitive};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// A square in the plane y = 0 that faces +Y; u goes along +X and v along +Z.
pub fn plane(size_m: f32) -> Primitive {
    let mut primitive = Primitive::default();
    add_quad(&mut primitive, Vec3::ZERO, Vec3::X * size_m, Vec3::Z * size_m);
    finish(primitive)
}

/// A box with its centre at the origin, every face with the whole UV square.
pub fn cube(size_m: Vec3) -> Primitive {
    let mut primitive = Primitive::default();
    for (normal, right) in [
        (Vec3::X, Vec3::NEG_Z),
        (Vec3::NEG_X, Vec3::Z),
        (Vec3::Y, Vec3::X),
        (Vec3::NEG_Y, Vec3::X),
        (Vec3::Z, Vec3::X),
        (Vec3::NEG_Z, Vec3::NEG_X),
    ] {
        let down = right.cross(normal);
        add_quad(&mut primitive, 0.5 * normal * size_m, right * size_m, down * size_m);
    }
    finish(primitive)
}

/// A sphere with its poles on the Y axis.
pub fn uv_sphere(radius_m: f32, segments: u32, rings: u32) -> Primitive {
    let rings = rings.max(2);
    let profile = (0..=rings).map(|i| {
        let angle_rad = FRAC_PI_2 - PI * i as f32 / rings as f32;
        let normal = Vec2::new(angle_rad.cos(), angle_rad.sin());
        ProfilePoint { position: normal * radius_m, normal, v: i as f32 / rings as f32 }
    });
    revolve(&profile.collect::<Vec<_>>(), segments)
}

/// A ring about the Y axis: the circle of the tube's middle has the major radius, the tube the minor one.
pub fn torus(major_radius_m: f32, minor_radius_m: f32, segments: u32, sides: u32) -> Primitive {
    let sides = sides.max(3);
    let profile = (0..=sides).map(|i| {
        let v = i as f32 / sides as f32;
        let normal = Vec2::new((PI - TAU * v).cos(), (PI - TAU * v).sin());
        ProfilePoint { position: Vec2::new(major_radius_m, 0.0) + normal * minor_radius_m, normal, v }
    });
    revolve(&profile.collect::<Vec<_>>(), segments)
}

/// A closed cylinder about the Y axis.
pub fn cylinder(radius_m: f32, height_m: f32, segments: u32) -> Primitive {
    let point = |x: f32, y: f32, normal, v| ProfilePoint { position: Vec2::new(x * radius_m, y * height_m), normal, v };
    revolve(
        &[
            point(0.0, 0.5, Vec2::Y, 0.0),
            point(1.0, 0.5, Vec2::Y, 0.25),
            point(1.0, 0.5, Vec2::X, 0.25),
            point(1.0, -0.5, Vec2::X, 0.75),
            point(1.0, -0.5, Vec2::NEG_Y, 0.75),
            point(0.0, -0.5, Vec2::NEG_Y, 1.0),
        ],
        segments,
    )
}

/// A cylinder of a height about the Y axis with a half sphere at each end.
pub fn capsule(radius_m: f32, height_m: f32, segments: u32, cap_rings: u32) -> Primitive {
    let cap_rings = cap_rings.max(1);
    let count = 2 * cap_rings + 1;
    let profile = (0..=count).map(|i| {
        let (step, centre_y_m) = if i <= cap_rings { (i, 0.5 * height_m) } else { (i - 1, -0.5 * height_m) };
        let angle_rad = FRAC_PI_2 - FRAC_PI_2 * step as f32 / cap_rings as f32;
        let normal = Vec2::new(angle_rad.cos(), angle_rad.sin());
        let position = normal * radius_m + Vec2::new(0.0, centre_y_m);
        ProfilePoint { position, normal, v: i as f32 / count as f32 }
    });
    revolve(&profile.collect::<Vec<_>>(), segments)
}

/// A point of a profile in the half plane x ≥ 0; the profile runs with the inside on its right-hand side.
struct ProfilePoint {
    position: Vec2,
    normal: Vec2,
    v: f32,
}

/// Turns a profile about the Y axis; u grows counter-clockwise seen from above.
fn revolve(profile: &[ProfilePoint], segments: u32) -> Primitive {
    let segments = segments.max(3);
    let mut primitive = Primitive::default();
    for point in profile {
        for i in 0..=segments {
            let u = i as f32 / segments as f32;
            let (sin, cos) = if i == segments { (0.0, 1.0) } else { (TAU * u).sin_cos() };
            let turn = |p: Vec2| Vec3::new(p.x * cos, p.y, -p.x * sin);
            primitive.positions.push(turn(Vec2::new(point.position.x.max(0.0), point.position.y)).to_array());
            primitive.normals.push(turn(point.normal).normalize().to_array());
            primitive.tangents.push([-sin, 0.0, -cos, 1.0]);
            primitive.uv0.push([u, point.v]);
        }
    }
    let row = segments + 1;
    for (j, pair) in profile.windows(2).enumerate() {
        let [upper, lower] = pair else { continue };
        // Two points of the profile at one place are a crease, without area.
        if upper.position == lower.position {
            continue;
        }
        for i in 0..segments {
            let a = j as u32 * row + i;
            let (b, c, d) = (a + 1, a + row, a + row + 1);
            if lower.position.x > 1e-6 * lower.position.length() {
                primitive.indices.extend([a, c, d]);
            }
            if upper.position.x > 1e-6 * upper.position.length() {
                primitive.indices.extend([a, d, b]);
            }
        }
    }
    finish(primitive)
}

/// Adds a parallelogram that faces `down × right`.
fn add_quad(primitive: &mut Primitive, center: Vec3, right: Vec3, down: Vec3) {
    let first = primitive.positions.len() as u32;
    let normal = down.cross(right).normalize();
    for [u, v] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        primitive.positions.push((center + right * (u - 0.5) + down * (v - 0.5)).to_array());
        primitive.normals.push(normal.to_array());
        primitive.tangents.push(right.normalize().extend(1.0).to_array());
        primitive.uv0.push([u, v]);
    }
    primitive.indices.extend([0, 2, 3, 0, 3, 1].map(|i| first + i));
}

fn finish(mut primitive: Primitive) -> Primitive {
    primitive.bounds = Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from));
    primitive
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]
    use super::*;

    fn check(primitive: &Primitive, half_size: Vec3, outside_of: impl Fn(Vec3) -> Vec3) {
        assert!(primitive.bounds.min.abs_diff_eq(-half_size, 1e-5), "{:?}", primitive.bounds);
        assert!(primitive.bounds.max.abs_diff_eq(half_size, 1e-5), "{:?}", primitive.bounds);
        assert!(primitive.normals.iter().all(|&n| (Vec3::from(n).length() - 1.0).abs() < 1e-5));
        for (&n, &[x, y, z, w]) in primitive.normals.iter().zip(&primitive.tangents) {
            assert!(Vec3::from(n).dot(Vec3::new(x, y, z)).abs() < 1e-5 && w == 1.0);
        }
        for triangle in primitive.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(primitive.positions[triangle[i] as usize]));
            let face = (b - a).cross(c - a);
            assert!(face.length() > 0.0, "a triangle without area");
            assert!(face.dot(outside_of((a + b + c) / 3.0)) > 0.0, "a triangle faces inwards");
            for &i in triangle {
                assert!(face.normalize().dot(Vec3::from(primitive.normals[i as usize])) > 0.5);
            }
        }
    }

    #[test]
    fn normals_are_unit_faces_point_out_and_bounds_are_right() {
        check(&plane(4.0), Vec3::new(2.0, 0.0, 2.0), |_| Vec3::Y);
        check(&cube(Vec3::new(1.0, 2.0, 3.0)), Vec3::new(0.5, 1.0, 1.5), |p| p);
        check(&uv_sphere(2.0, 32, 16), Vec3::splat(2.0), |p| p);
        check(&torus(2.0, 0.5, 32, 16), Vec3::new(2.5, 0.5, 2.5), |p| p - 2.0 * p.with_y(0.0).normalize());
        check(&cylinder(1.0, 3.0, 32), Vec3::new(1.0, 1.5, 1.0), |p| p);
        check(&capsule(0.5, 2.0, 32, 8), Vec3::new(0.5, 1.5, 0.5), |p| p);
    }
}
