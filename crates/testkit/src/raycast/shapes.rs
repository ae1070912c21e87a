//! Exact shapes, which need no mesh.

use super::Surface;
use glam::DVec3;

/// A shape to hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A sphere, hit from outside.
    Sphere {
        /// The centre in world space.
        center_world: DVec3,
        /// The radius in metres.
        radius_m: f64,
    },
    /// A finite rectangle, hit from both sides; its normal is turned to the viewer.
    Quad {
        /// The centre in world space.
        center_world: DVec3,
        /// From the centre to the middle of one edge.
        half_u_world: DVec3,
        /// From the centre to the middle of a neighbouring edge, at a right angle to `half_u_world`.
        half_v_world: DVec3,
    },
}

/// A shape with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Where it is.
    pub shape: Shape,
    /// What it is made of.
    pub surface: Surface,
}

impl Shape {
    /// The distance to the shape in metres and its normal on the side of the ray's origin.
    pub(super) fn intersect(&self, origin_world: DVec3, direction_world: DVec3) -> Option<(f64, DVec3)> {
        match *self {
            Shape::Sphere { center_world, radius_m } => {
                let offset = origin_world - center_world;
                let half_b = offset.dot(direction_world);
                // The closest approach rather than b² − 4ac, which cancels for small, distant spheres.
                let closest = offset - half_b * direction_world;
                let discriminant = radius_m * radius_m - closest.length_squared();
                if discriminant < 0.0 {
                    return None;
                }
                let distance_m = -half_b - discriminant.sqrt();
                let normal = (offset + distance_m * direction_world) / radius_m;
                (distance_m > 0.0).then_some((distance_m, normal))
            }
            Shape::Quad { center_world, half_u_world, half_v_world } => {
                let normal = half_u_world.cross(half_v_world).normalize();
                let cos = normal.dot(direction_world);
                let distance_m = normal.dot(center_world - origin_world) / cos;
                if !distance_m.is_finite() || distance_m <= 0.0 {
                    return None;
                }
                let offset = origin_world + distance_m * direction_world - center_world;
                let u = offset.dot(half_u_world) / half_u_world.length_squared();
                let v = offset.dot(half_v_world) / half_v_world.length_squared();
                (u.abs() <= 1.0 && v.abs() <= 1.0).then_some((distance_m, if cos > 0.0 { -normal } else { normal }))
            }
        }
    }
}
