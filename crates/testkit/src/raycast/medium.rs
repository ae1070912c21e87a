//! Fog that fills all space, and what light does in it once.

use super::random::Random;
use super::{Emission, Light};
use glam::DVec3;
use std::f64::consts::PI;

/// Fog: density_per_m · exp(−(y − base_height_m) / scale_height_m) is the part of light that a metre takes away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// The part of light that is lost in a metre, at `base_height_m` (extinction, 1/m).
    pub density_per_m: f64,
    /// The part of that which is scattered, by colour; the rest is absorbed.
    pub albedo: DVec3,
    /// The height at which density is as stated, in metres.
    pub base_height_m: f64,
    /// Every so many metres upwards density falls to 1/e; infinite for uniform fog.
    pub scale_height_m: f64,
    /// The mean cosine by which light is turned (Henyey & Greenstein): 0 scatters evenly, towards 1 forwards.
    pub anisotropy: f64,
    /// How far fog is looked into where no surface is, in metres.
    pub far_m: f64,
    /// Whether light loses strength on its way from a source to a surface, or to the place that scatters it. Light from
    /// infinitely far away in uniform fog is nothing then.
    pub dims_light: bool,
}

impl Default for Medium {
    /// Uniform fog through which 100 m let 37 % of light pass, which scatters all of it evenly and dims no light.
    fn default() -> Self {
        Self {
            density_per_m: 0.01,
            albedo: DVec3::ONE,
            base_height_m: 0.0,
            scale_height_m: f64::INFINITY,
            anisotropy: 0.0,
            far_m: 1000.0,
            dims_light: false,
        }
    }
}

/// The fog along a ray: density at its origin, and how fast it falls with distance, 1/m.
#[derive(Clone, Copy, Debug)]
struct FogRay {
    density_per_m: f64,
    fall_per_m: f64,
}

impl FogRay {
    /// ∫₀ᵗ density = density · (1 − exp(−k t)) / k.
    fn optical_depth(&self, distance_m: f64) -> f64 {
        let exponent = self.fall_per_m * distance_m;
        if exponent == 0.0 || (exponent.abs() < 1e-9 && distance_m.is_finite()) {
            self.density_per_m * distance_m
        } else {
            self.density_per_m * -(-exponent).exp_m1() / self.fall_per_m
        }
    }

    /// The distance at which the optical depth is as given; infinite where it never is.
    fn distance_at(&self, optical_depth: f64) -> f64 {
        let lost = self.fall_per_m * optical_depth / self.density_per_m;
        if lost.abs() < 1e-9 {
            optical_depth / self.density_per_m
        } else if lost >= 1.0 {
            f64::INFINITY
        } else {
            -(-lost).ln_1p() / self.fall_per_m
        }
    }

    fn density_at(&self, distance_m: f64) -> f64 {
        self.density_per_m * (-self.fall_per_m * distance_m).exp()
    }
}

/// A place on a ray that scatters light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    pub distance_m: f64,
    /// Metres of the ray that it stands for.
    pub length_m: f64,
}

impl Medium {
    fn along(&self, origin_world: DVec3, direction_world: DVec3) -> FogRay {
        let height = (origin_world.y - self.base_height_m) / self.scale_height_m;
        FogRay {
            density_per_m: self.density_per_m * (-height).exp(),
            fall_per_m: direction_world.y / self.scale_height_m,
        }
    }

    /// The share of light that is left after `distance_m`.
    pub fn transmittance(&self, origin_world: DVec3, direction_world: DVec3, distance_m: f64) -> f64 {
        (-self.along(origin_world, direction_world).optical_depth(distance_m)).exp()
    }

    /// What is left of a light's strength after its way.
    pub(super) fn dimming(&self, origin_world: DVec3, to_light: DVec3, distance_m: f64) -> f64 {
        if self.dims_light { self.transmittance(origin_world, to_light, distance_m) } else { 1.0 }
    }

    /// Scattered from one direction into another, sr⁻¹, where `cos` is that of the angle between the two ways that
    /// light goes (Henyey & Greenstein, "Diffuse radiation in the galaxy", 1941).
    pub fn phase(&self, cos: f64) -> f64 {
        let g = self.anisotropy;
        (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5))
    }

    /// Light scattered per metre of the ray at a place: coefficient of scattering by colour, 1/m.
    pub(super) fn scattering(&self, position_world: DVec3) -> DVec3 {
        self.albedo * self.along(position_world, DVec3::ZERO).density_per_m
    }

    /// Where to look for the light of `light` along a ray of `length_m`: one place in each of `steps` parts, which are
    /// equal by transmittance for parallel light and by angle for light from a place (Kulla & Fajardo, "Importance
    /// Sampling Techniques for Path Tracing in Participating Media", 2012).
    pub(super) fn events(
        &self,
        light: &Light,
        (origin_world, direction_world, length_m): (DVec3, DVec3, f64),
        steps: u32,
        mut random: Random,
    ) -> Vec<Event> {
        let steps_f64 = f64::from(steps);
        let mut places = (0..steps).map(|step| (f64::from(step) + random.next_unit()) / steps_f64);
        if light.emission == Emission::Directional {
            let along = self.along(origin_world, direction_world);
            let lost = -(-along.optical_depth(length_m)).exp_m1();
            let event = |place: f64| {
                let left = 1.0 - place * lost;
                let distance_m = along.distance_at(-left.ln()).min(length_m);
                Event { distance_m, length_m: lost / (left * along.density_at(distance_m) * steps_f64) }
            };
            return places.map(event).collect();
        }
        let nearest_m = (light.position_world - origin_world).dot(direction_world);
        let aside = origin_world + nearest_m * direction_world - light.position_world;
        // Through the light itself angles jump; a nanometre is near enough.
        let aside_m = aside.length().max(1e-9);
        let half_chord_m = match light.range_m {
            Some(range_m) if range_m <= aside_m => return Vec::new(),
            Some(range_m) => (range_m * range_m - aside_m * aside_m).sqrt(),
            None => f64::INFINITY,
        };
        let (start_m, end_m) = ((nearest_m - half_chord_m).max(0.0), (nearest_m + half_chord_m).min(length_m));
        if start_m >= end_m {
            return Vec::new();
        }
        let angles = [start_m, end_m].map(|end| ((end - nearest_m) / aside_m).atan());
        places
            .by_ref()
            .map(|place| {
                let tan = (angles[0] + (angles[1] - angles[0]) * place).tan();
                let length_m = (angles[1] - angles[0]) * aside_m * (1.0 + tan * tan) / steps_f64;
                Event { distance_m: (nearest_m + aside_m * tan).clamp(start_m, end_m), length_m }
            })
            .collect()
    }
}
