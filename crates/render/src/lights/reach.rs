//! What a light reaches: a ball, or the cone that a spot cuts out of it.

use glam::{Mat4, Vec3};
use manypass_scene::LightKind;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// All that a light with a range reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// The middle of a sphere around it.
    pub center: Vec3,
    /// The radius of that sphere in metres.
    pub radius_m: f32,
    /// The cone, of spots that are not so wide that the sphere is as good.
    pub cone: Option<Cone>,
}

/// A cone with its tip at the light. At a distance t from the tip, up to the range, it is a disc of radius t · tangent;
/// the round cap is taken to be flat and a little wider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    pub(super) tip: Vec3,
    /// Of length 1.
    pub(super) axis: Vec3,
    pub(super) range_m: f32,
    pub(super) tangent: f32,
}

/// The part of a cone between two distances from its tip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frustum {
    cone: Cone,
    first_m: f32,
    last_m: f32,
}

/// From this half angle on, in radians, a cone is no better than its sphere.
const CONE_MAX_RAD: f32 = 1.2;
/// Room for rounding, which differs between the shader and the CPU, as a share of the range.
const CONE_SLACK: f32 = 0.001;

impl Reach {
    /// Of a point light.
    pub fn ball(center: Vec3, radius_m: f32) -> Self {
        Self { center, radius_m, cone: None }
    }

    /// Of a light at `position` that shines along `direction`, of length 1, as far as `range_m`.
    pub fn of_light(kind: LightKind, position: Vec3, direction: Vec3, range_m: f32) -> Self {
        let LightKind::Spot { outer_cone_rad, .. } = kind else { return Self::ball(position, range_m) };
        if !(0.0..FRAC_PI_2).contains(&outer_cone_rad) {
            return Self::ball(position, range_m);
        }
        let (sin, cos) = outer_cone_rad.sin_cos();
        // The smallest sphere goes through the rim; and through the tip, unless that lies inside.
        let (along, radius_m) = if outer_cone_rad < FRAC_PI_4 {
            (0.5 * range_m / cos, 0.5 * range_m / cos)
        } else {
            (range_m * cos, range_m * sin)
        };
        let cone = Cone { tip: position, axis: direction, range_m, tangent: sin / cos };
        let cone = (outer_cone_rad < CONE_MAX_RAD).then_some(cone);
        Self { center: position + direction * along, radius_m, cone }
    }

    /// The same in another space, of the same scale.
    pub fn transformed(&self, matrix: &Mat4) -> Self {
        let cone = self.cone.map(|cone| Cone {
            tip: matrix.transform_point3(cone.tip),
            axis: matrix.transform_vector3(cone.axis),
            ..cone
        });
        Self { center: matrix.transform_point3(self.center), radius_m: self.radius_m, cone }
    }

    /// The least and the greatest value of `normal · p` of all that is reached, for a `normal` of length 1; the radius
    /// of the sphere is multiplied by `radius_slack`.
    pub(super) fn extent(&self, normal: Vec3, radius_slack: f32) -> [f32; 2] {
        let (middle, radius_m) = (normal.dot(self.center), self.radius_m * radius_slack);
        let of_sphere = [middle - radius_m, middle + radius_m];
        let Some(cone) = self.cone else { return of_sphere };
        let [low, high] = cone.whole().extent(normal);
        [low.max(of_sphere[0]), high.min(of_sphere[1])]
    }
}

impl Cone {
    /// All of it.
    pub(super) fn whole(self) -> Frustum {
        Frustum { cone: self, first_m: 0.0, last_m: self.range_m }
    }
}

impl Frustum {
    /// What is left where `normal · p ≥ offset` for some point p of a disc; none if nothing is. `normal` may have any
    /// length.
    pub(super) fn clipped(self, normal: Vec3, offset: f32) -> Option<Self> {
        let Cone { tip, axis, range_m, tangent } = self.cone;
        let along = normal.dot(axis);
        let length_squared = normal.length_squared();
        // The disc's point that lies farthest along the normal: linear in the distance t from the tip.
        let slack = CONE_SLACK * range_m * length_squared.sqrt();
        let at_tip = normal.dot(tip) - offset + slack;
        let slope = along + tangent * (length_squared - along * along).max(0.0).sqrt();
        let mut part = self;
        if slope > 0.0 {
            part.first_m = part.first_m.max(-at_tip / slope);
        } else if slope < 0.0 {
            part.last_m = part.last_m.min(-at_tip / slope);
        } else if at_tip < 0.0 {
            return None;
        }
        (part.first_m <= part.last_m).then_some(part)
    }

    /// The least and the greatest value of `normal · p`, for a `normal` of length 1.
    pub(super) fn extent(&self, normal: Vec3) -> [f32; 2] {
        let Cone { tip, axis, range_m, tangent } = self.cone;
        let along = normal.dot(axis);
        let across = tangent * (1.0 - along * along).max(0.0).sqrt();
        let (middle, slack) = (normal.dot(tip), CONE_SLACK * range_m);
        let low = [self.first_m, self.last_m].map(|t| middle + t * (along - across));
        let high = [self.first_m, self.last_m].map(|t| middle + t * (along + across));
        [low[0].min(low[1]) - slack, high[0].max(high[1]) + slack]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_are_around_all_that_a_spot_reaches() {
        let (position, range_m) = (Vec3::new(1.0, 2.0, 3.0), 4.0);
        let axis = Vec3::new(0.3, -0.8, 0.2).normalize();
        let across = axis.any_orthonormal_vector();
        for angle_deg in [0.0f32, 5.0, 30.0, 44.9, 45.1, 60.0, 89.0, 90.0, 120.0] {
            let outer_cone_rad = angle_deg.to_radians();
            let kind = LightKind::Spot { inner_cone_rad: 0.0, outer_cone_rad };
            let reach = Reach::of_light(kind, position, axis, range_m);
            assert!(reach.radius_m <= range_m);
            for share in 0..=20u8 {
                let angle_rad = outer_cone_rad * f32::from(share) / 20.0;
                for length_m in [0.0, 0.5 * range_m, range_m] {
                    let offset = axis * (length_m * angle_rad.cos()) + across * (length_m * angle_rad.sin());
                    let distance_m = (position + offset).distance(reach.center);
                    assert!(distance_m <= reach.radius_m * 1.00001, "{angle_deg}: {distance_m} {}", reach.radius_m);
                    let Some(cone) = reach.cone else { continue };
                    for normal in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.0, -1.0, 0.7)] {
                        let value = normal.dot(position + offset);
                        assert!(cone.whole().clipped(normal, value).is_some(), "{angle_deg}: {normal} {value}");
                        let [low, high] = cone.whole().extent(normal.normalize());
                        assert!((low..=high).contains(&(value / normal.length())), "{angle_deg}: {normal} {value}");
                    }
                }
            }
        }
    }
}
