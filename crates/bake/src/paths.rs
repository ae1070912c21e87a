//! Light along rays, back and forth between surfaces.

use crate::emitters::{Emitters, Receiver};
use crate::sampling::{cosine_density, cosine_direction, hash2, point};
use crate::surfaces::Surfaces;
use crate::tracing::{Hit, Tracer};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// The scene as a ray asks for it.
pub(crate) struct Paths<'a> {
    pub surfaces: &'a Surfaces,
    pub tracer: &'a Tracer<'a>,
    pub emitters: &'a Emitters<'a>,
    /// How often light is sent back.
    pub bounces: u32,
}

/// Of which path something is asked: points of the same number are spread over all paths of a seed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draw {
    pub sample: u32,
    pub seed: u32,
}

impl Draw {
    /// A point in the unit square for a purpose.
    pub fn point(self, purpose: u32) -> Vec2 {
        point(self.sample, hash2(self.seed, purpose))
    }
}

/// Points that a path needs where it meets a surface.
const POINTS: u32 = 4;

/// What a ray brings.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PathLight {
    /// The radiance that surfaces send back.
    pub sent_back: Vec3,
    /// The radiance that comes straight from where it is made, and what it is as one of two samples.
    pub made: Vec3,
    pub share: Vec3,
    /// Where it ends.
    pub hit: Option<Hit>,
}

impl Paths<'_> {
    /// What a ray brings, whose `density` weighs it as one of two samples of what shines and of what is around the scene.
    pub fn along(&self, from: Vec3, direction: Vec3, density: f32, draw: Draw) -> PathLight {
        let (mut from, mut direction, mut density) = (from, direction, density);
        let (mut brought, mut throughput) = (PathLight::default(), Vec3::ONE);
        for bounce in 0..=self.bounces {
            let Some(hit) = self.tracer.first(from, direction) else {
                let share = self.emitters.missed(direction, density);
                match bounce {
                    0 => (brought.share, brought.made) = (share, self.emitters.radiance_around(direction)),
                    _ => brought.sent_back += throughput * share,
                }
                break;
            };
            if bounce == 0 {
                brought.hit = Some(hit);
            }
            if self.tracer.is_black(&hit) {
                break;
            }
            let (position, facet, normal) = self.surfaces.geometry(hit.spot);
            let shade = self.surfaces.shade(hit.spot);
            let leaving = facet.dot(direction).abs();
            let share = self.emitters.met(hit.spot, shade.emission, hit.distance_m, leaving, density);
            match bounce {
                0 => (brought.share, brought.made) = (share, shade.emission),
                _ => brought.sent_back += throughput * share,
            }
            throughput *= shade.reflectance;
            if bounce == self.bounces || throughput.max_element() <= 0.0 {
                break;
            }
            let side = if hit.is_behind { -1.0 } else { 1.0 };
            let receiver = Receiver { position, facet: side * facet, normal: side * normal };
            let place = |purpose: u32| draw.point(1 + POINTS * bounce + purpose);
            let [held, added] = self.emitters.of_lamps(self.tracer, &receiver, place(0));
            let chosen = self.emitters.of_chosen(self.tracer, &receiver, [place(1), place(2)]);
            let irradiance = held.irradiance + added.irradiance + chosen.irradiance;
            brought.sent_back += throughput * irradiance / PI;
            // Rays as dense as their cosine bring what is sent back of them as it is.
            direction = cosine_direction(receiver.normal, place(3));
            density = cosine_density(receiver.normal.dot(direction));
            from = receiver.start();
        }
        brought
    }
}
