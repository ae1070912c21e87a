//! Lights, and the places from which their light comes.

use super::random::Random;
use glam::DVec3;
use std::f64::consts::TAU;

/// The shape of a light's emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emission {
    /// Parallel light in lux.
    Directional,
    /// From a point, in candela.
    Point,
    /// A cone from a point, in candela.
    Spot {
        /// Full strength within this angle from the axis, in radians.
        inner_cone_rad: f64,
        /// Nothing beyond this angle from the axis, in radians.
        outer_cone_rad: f64,
    },
}

/// A light (`KHR_lights_punctual`, with a size).
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The shape of its emission.
    pub emission: Emission,
    /// Where it is, in world space; of no meaning for directional light.
    pub position_world: DVec3,
    /// Whither it shines, a unit vector; of no meaning for point lights.
    pub direction_world: DVec3,
    /// Linear colour times candela or lux.
    pub intensity: DVec3,
    /// Nothing arrives beyond this distance in metres; none means only the inverse square.
    pub range_m: Option<f64>,
    /// The radius of the sphere that gives the light; of directional light the tangent of half the angle that its
    /// source takes in the sky. It widens shadows and nothing else.
    pub radius_m: f64,
    /// Whether anything keeps its light off.
    pub casts_shadows: bool,
    /// Indices of parts of [`super::Meshes`] that do not keep its light off, because they glow around it.
    pub glows_around: Vec<usize>,
}

impl Default for Light {
    /// A white point of one candela at the origin.
    fn default() -> Self {
        Self {
            emission: Emission::Point,
            position_world: DVec3::ZERO,
            direction_world: DVec3::NEG_Y,
            intensity: DVec3::ONE,
            range_m: None,
            radius_m: 0.0,
            casts_shadows: true,
            glows_around: Vec::new(),
        }
    }
}

impl Light {
    /// The direction to the light, the distance to it (infinite for directional light) and the irradiance on a surface
    /// that faces it, in lux. The fall-off and the cone are those that `KHR_lights_punctual` recommends.
    pub fn arriving_at(&self, position_world: DVec3) -> (DVec3, f64, DVec3) {
        if self.emission == Emission::Directional {
            return (-self.direction_world, f64::INFINITY, self.intensity);
        }
        let offset = self.position_world - position_world;
        let distance_m = offset.length();
        let to_light = offset / distance_m;
        let window = self.range_m.map_or(1.0, |range_m| (1.0 - (distance_m / range_m).powi(4)).clamp(0.0, 1.0));
        let cone = match self.emission {
            Emission::Spot { inner_cone_rad, outer_cone_rad } => {
                let scale = 1.0 / (inner_cone_rad.cos() - outer_cone_rad.cos()).max(0.001);
                let offset = -outer_cone_rad.cos() * scale;
                ((-to_light).dot(self.direction_world) * scale + offset).clamp(0.0, 1.0).powi(2)
            }
            Emission::Directional | Emission::Point => 1.0,
        };
        (to_light, distance_m, self.intensity * (window * cone / (distance_m * distance_m)))
    }

    /// Whether a place is so far away that nothing arrives.
    pub(super) fn is_out_of_range(&self, position_world: DVec3) -> bool {
        self.emission != Emission::Directional
            && self
                .range_m
                .is_some_and(|range_m| self.position_world.distance_squared(position_world) >= range_m * range_m)
    }

    /// Whether its light comes from more than one direction.
    pub(super) fn has_size(&self) -> bool {
        self.radius_m > 0.0
    }

    /// A direction in which the light's source is seen from a place, and how far away; the middle of it for `place` =
    /// none, else evenly by solid angle (a sphere is seen as a cap; PBRT, "Sampling Spheres"), with 0 ≤ `place` < 1.
    pub(super) fn source_seen_from(&self, position_world: DVec3, place: Option<[f64; 2]>) -> (DVec3, f64) {
        let (to_light, distance_m, _) = self.arriving_at(position_world);
        let is_directional = self.emission == Emission::Directional;
        let Some([u, v]) = place.filter(|_| self.has_size() && (is_directional || distance_m > self.radius_m)) else {
            return (to_light, distance_m);
        };
        let sin_squared = match is_directional {
            true => self.radius_m.powi(2) / (1.0 + self.radius_m.powi(2)),
            false => (self.radius_m / distance_m).powi(2),
        };
        // 1 − cos, without cancellation for small angles.
        let lost_cos = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
        let cos = 1.0 - u * lost_cos;
        let sin = (u * lost_cos * (1.0 + cos)).sqrt();
        let (across, along) = to_light.any_orthonormal_pair();
        let (sin_turn, cos_turn) = (TAU * v).sin_cos();
        let direction = (to_light * cos + (across * cos_turn + along * sin_turn) * sin).normalize();
        if is_directional {
            return (direction, f64::INFINITY);
        }
        // The nearer of the two places where the ray meets the sphere.
        let half_chord_m = (self.radius_m.powi(2) - (sin * distance_m).powi(2)).max(0.0).sqrt();
        (direction, cos * distance_m - half_chord_m)
    }
}

/// Places in the unit square: one in each of `count_per_axis²` cells.
pub(super) fn stratified(count_per_axis: u32, mut random: Random) -> impl Iterator<Item = [f64; 2]> {
    let count = f64::from(count_per_axis);
    (0..count_per_axis * count_per_axis).map(move |cell| {
        let corner = [f64::from(cell % count_per_axis), f64::from(cell / count_per_axis)];
        corner.map(|corner| (corner + random.next_unit()) / count)
    })
}
