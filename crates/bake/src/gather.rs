//! What a texel sees.

use crate::emitters::{ArrivingLight, Emitters, Receiver, luminance};
use crate::fill::Light;
use crate::sampling::{cosine_density, cosine_direction, hash2, point};
use crate::surfaces::Surfaces;
use crate::texels::Texels;
use crate::tracing::Tracer;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Places within a texel at which the lights of the scene are looked at.
const LAMP_SAMPLES: u32 = 16;

/// Rays by which texels are found that lie inside something, and the share of them that sees the backs of surfaces then.
const INSIDE_SAMPLES: u32 = 16;
const INSIDE_SHARE: f32 = 0.5;

/// Each round has other points.
const OF_INSIDE: u32 = 0;
const OF_LAMPS: u32 = 1;
const OF_SHINING: u32 = 2;
const OF_OCCLUSION: u32 = 3;
const OF_REFLECTANCE: u32 = 4;
const OF_BOUNCES: u32 = 8;

/// The scene as a texel asks for it.
pub(crate) struct Gather<'a> {
    pub surfaces: &'a Surfaces,
    pub tracer: &'a Tracer<'a>,
    pub emitters: &'a Emitters<'a>,
    pub texels: &'a Texels<'a>,
    /// Rays from a texel in each round.
    pub samples: u32,
}

/// The mean of samples, and the variance of its luminance as its two halves show it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mean {
    pub value: Vec3,
    pub variance: f32,
    /// Where light comes from, see [`ArrivingLight::moment`].
    pub moment: Vec3,
}

/// Sums of samples that are even and of those that are odd: points of both are spread as evenly as all of them.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    halves: [Vec3; 2],
    moment: Vec3,
}

impl Sums {
    fn add(&mut self, sample: u32, value: Vec3) {
        self.halves[(sample & 1) as usize] += value;
    }

    fn add_arriving(&mut self, sample: u32, arriving: ArrivingLight) {
        self.add(sample, arriving.irradiance);
        self.moment += arriving.moment;
    }

    fn mean(self, count: u32) -> Mean {
        let [even, odd] = self.halves;
        let sum = even + odd;
        if !sum.is_finite() {
            return Mean::default();
        }
        let moment = if self.moment.is_finite() { self.moment } else { Vec3::ZERO };
        let apart = luminance(even - odd) / count as f32;
        let variance = if count > 1 { apart * apart } else { 0.0 };
        Mean { value: sum / count as f32, variance, moment: moment / count as f32 }
    }
}

impl Gather<'_> {
    /// A receiver within a texel for each of `count` samples, and the seed of their points.
    fn receivers(&self, index: usize, count: u32, round: u32) -> impl Iterator<Item = (u32, Receiver, u32)> + '_ {
        let seed = hash2(index as u32, round);
        let count = if self.texels.triangle(index).is_some() { count } else { 0 };
        (0..count).filter_map(move |sample| {
            let spot = self.texels.spot(index, point(sample, hash2(seed, 0)))?;
            let (position, facet, normal) = self.surfaces.geometry(spot);
            Some((sample, Receiver { position, facet, normal }, seed))
        })
    }

    /// Whether a texel lies inside something.
    pub fn is_inside(&self, index: usize) -> bool {
        let mut behind = 0;
        for (sample, receiver, seed) in self.receivers(index, INSIDE_SAMPLES, OF_INSIDE) {
            let direction = cosine_direction(receiver.normal, point(sample, hash2(seed, 1)));
            let hit = self.tracer.first(receiver.start(), direction);
            behind += u32::from(hit.is_some_and(|hit| self.tracer.is_black(&hit)));
        }
        behind as f32 >= INSIDE_SHARE * INSIDE_SAMPLES as f32
    }

    /// Irradiance of the scene's lights, of those that maps hold and of the others.
    pub fn of_lamps(&self, index: usize) -> [ArrivingLight; 2] {
        let mut sums = [ArrivingLight::default(); 2];
        for (sample, receiver, seed) in self.receivers(index, LAMP_SAMPLES, OF_LAMPS) {
            let found = self.emitters.of_lamps(self.tracer, &receiver, point(sample, hash2(seed, 1)));
            sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found / LAMP_SAMPLES as f32);
        }
        sums
    }

    /// The share of light that a texel sends back.
    pub fn reflectance(&self, index: usize) -> Vec3 {
        let spots = (0..LAMP_SAMPLES)
            .filter_map(|sample| self.texels.spot(index, point(sample, hash2(index as u32, OF_REFLECTANCE))));
        let (sum, count) = spots.fold((Vec3::ZERO, 0.0f32), |(sum, count), spot| {
            (sum + self.surfaces.shade(spot).reflectance, count + 1.0)
        });
        sum / count.max(1.0)
    }

    /// Irradiance of what shines and of what is around the scene.
    pub fn of_others(&self, index: usize) -> Mean {
        let mut sums = Sums::default();
        if !self.emitters.has_others() {
            return Mean::default();
        }
        for (sample, receiver, seed) in self.receivers(index, self.samples, OF_SHINING) {
            let place = |which: u32| point(sample, hash2(seed, which));
            let mut arriving = self.emitters.of_chosen(self.tracer, &receiver, [place(1), place(2)]);
            let (direction, radiance) = self.emission_met(&receiver, place(3));
            arriving += ArrivingLight::from(direction, PI * radiance);
            sums.add_arriving(sample, arriving);
        }
        sums.mean(self.samples)
    }

    /// The direction of a ray that is as dense as its cosine, and the radiance of what shines along it, see
    /// [`Emitters::met`].
    fn emission_met(&self, receiver: &Receiver, place: Vec2) -> (Vec3, Vec3) {
        let direction = cosine_direction(receiver.normal, place);
        let cosine = receiver.normal.dot(direction);
        let Some(hit) = self.tracer.first(receiver.start(), direction) else {
            return (direction, self.emitters.missed(direction, cosine_density(cosine)));
        };
        let (placed, _) = self.surfaces.triangle(hit.spot.triangle);
        if !self.surfaces.surfacing.surface(placed.material).shines || self.tracer.is_black(&hit) {
            return (direction, Vec3::ZERO);
        }
        let (_, facet, _) = self.surfaces.geometry(hit.spot);
        let emission = self.surfaces.shade(hit.spot).emission;
        let (leaving, density) = (facet.dot(direction).abs(), cosine_density(cosine));
        (direction, self.emitters.met(hit.spot, emission, hit.distance_m, leaving, density))
    }

    /// The irradiance that surfaces send back of `source`, which is the irradiance of all texels divided by π.
    pub fn bounced(&self, index: usize, round: u32, source: &[impl Light]) -> Mean {
        let mut sums = Sums::default();
        for (sample, receiver, seed) in self.receivers(index, self.samples, OF_BOUNCES + round) {
            let direction = cosine_direction(receiver.normal, point(sample, hash2(seed, 1)));
            let Some(hit) = self.tracer.first(receiver.start(), direction).filter(|hit| !self.tracer.is_black(hit))
            else {
                continue;
            };
            let Some(light) = self.texels.look_up(source, hit.spot) else { continue };
            let irradiance = self.surfaces.shade(hit.spot).reflectance * light * PI;
            sums.add_arriving(sample, ArrivingLight::from(direction, irradiance));
        }
        sums.mean(self.samples)
    }

    /// The share of even light from everywhere that reaches a texel, where what is near counts, and what is farther counts
    /// less, down to nothing at a distance.
    pub fn openness(&self, index: usize, distance_m: f32) -> Mean {
        let mut sums = Sums::default();
        for (sample, receiver, seed) in self.receivers(index, self.samples, OF_OCCLUSION) {
            let direction = cosine_direction(receiver.normal, point(sample, hash2(seed, 1)));
            let hit = self.tracer.first(receiver.start(), direction);
            sums.add(sample, Vec3::splat(hit.map_or(1.0, |hit| (hit.distance_m / distance_m).min(1.0))));
        }
        sums.mean(self.samples)
    }
}
