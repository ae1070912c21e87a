//! The sky against integrals of its paper's equations that share nothing with it: no tables, no steps that grow, no
//! phases apart. And against light that is followed by chance, scattering by scattering, with the phases of each.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use glam::{DVec3, Vec3};
use manypass_scene::environment::equirectangular_direction;
use manypass_scene::sky::SKY_UNIT_NIT;
use manypass_scene::{EnvironmentMap, Sky};
use std::f64::consts::PI;

const GROUND: f64 = 6360.0;
const TOP: f64 = 6460.0;
const EYE: f64 = GROUND + 0.002;

/// The air of Hillaire 2020, table 1, with haze as dense as a turbidity asks for; per km.
struct Air {
    haze: f64,
    albedo: f64,
}

impl Air {
    fn of(sky: &Sky) -> Self {
        let of_air = 13.558e-3 * 8.0;
        Self { haze: (f64::from(sky.turbidity) - 1.0) * of_air / (4.44e-3 * 1.2), albedo: sky.ground_albedo.into() }
    }

    /// What air scatters, what haze scatters, and all that is lost.
    fn at(&self, place: DVec3) -> (DVec3, f64, DVec3) {
        let h = place.length() - GROUND;
        let air = DVec3::new(5.802e-3, 13.558e-3, 33.1e-3) * (-h / 8.0).exp();
        let haze = self.haze * (-h / 1.2).exp();
        let ozone = DVec3::new(0.650e-3, 1.881e-3, 0.085e-3) * (1.0 - (h - 25.0).abs() / 15.0).max(0.0);
        (air, 3.996e-3 * haze, air + 4.44e-3 * haze + ozone)
    }

    /// The share of light that comes along a way, by Simpson's rule.
    fn through(&self, from: DVec3, to: DVec3, steps: u32) -> DVec3 {
        let lost = |at: f64| self.at(from.lerp(to, at)).2;
        let step = 1.0 / f64::from(steps);
        let sum: DVec3 = (0..steps)
            .map(|i| {
                let at = f64::from(i) * step;
                (lost(at) + 4.0 * lost(at + 0.5 * step) + lost(at + step)) * (step / 6.0)
            })
            .sum();
        (-sum * from.distance(to)).exp()
    }

    fn sunlight(&self, place: DVec3, sun: DVec3) -> DVec3 {
        match way(place, sun) {
            (to_top, None) => self.through(place, place + sun * to_top, 40),
            _ => DVec3::ZERO,
        }
    }
}

/// The way to the end of the air, and to the ground if that is met.
fn way(place: DVec3, direction: DVec3) -> (f64, Option<f64>) {
    let b = place.dot(direction);
    let root = |radius: f64| b * b - place.length_squared() + radius * radius;
    let ground = root(GROUND);
    let meets = ground >= 0.0 && b < 0.0;
    (-b + root(TOP).max(0.0).sqrt(), meets.then(|| (-b - ground.sqrt()).max(0.0)))
}

fn rayleigh(cosine: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cosine * cosine)
}

fn mie(cosine: f64) -> f64 {
    let g = 0.8f64;
    3.0 * (1.0 - g * g) * (1.0 + cosine * cosine)
        / (8.0 * PI * (2.0 + g * g) * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
}

/// Numbers from 0 to 1.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        let (y, around) = (2.0 * self.next() - 1.0, 2.0 * PI * self.next());
        let across = (1.0 - y * y).sqrt();
        DVec3::new(across * around.cos(), y, across * around.sin())
    }
}

/// Radiance for sunlight of 1, by the paper's equations: single scattering, and all others as if they were alike from
/// everywhere.
fn by_equations(air: &Air, sun: DVec3, to: DVec3) -> DVec3 {
    let eye = DVec3::Y * EYE;
    let (to_top, to_ground) = way(eye, to);
    let length = to_ground.unwrap_or(to_top);
    let cosine = to.dot(sun);
    // Dense near the eye, where most of the air is.
    let count = 160;
    let mut sum = DVec3::ZERO;
    let (mut through, mut around) = (DVec3::ONE, DVec3::ZERO);
    let mut chance = Chance(7);
    for i in 0..count {
        let edge = |i: u32| length * (f64::from(i) / f64::from(count)).powi(3);
        let (begin, end) = (edge(i), edge(i + 1));
        let place = eye + to * (0.5 * (begin + end));
        let (of_air, of_haze, lost) = air.at(place);
        let rest = (-lost * (end - begin)).exp();
        let share = through * (1.0 - rest) / lost.max(DVec3::splat(1e-12));
        sum += share * air.sunlight(place, sun) * (of_air * rayleigh(cosine) + of_haze * mie(cosine));
        // Few of them, because they cost as much as all others; what they give is smooth along the way.
        if i % 8 == 0 {
            around = multiple(air, eye + to * edge(i + 4), sun, &mut chance);
        }
        sum += share * (of_air + of_haze) * around;
        through *= rest;
    }
    sum
}

/// Equations 5 to 10.
fn multiple(air: &Air, place: DVec3, sun: DVec3, chance: &mut Chance) -> DVec3 {
    let (mut second, mut again) = (DVec3::ZERO, DVec3::ZERO);
    let directions = 120;
    for _ in 0..directions {
        let to = chance.direction();
        let (to_top, to_ground) = way(place, to);
        let length = to_ground.unwrap_or(to_top);
        let mut through = DVec3::ONE;
        for i in 0..24 {
            let edge = |i: u32| length * (f64::from(i) / 24.0).powi(2);
            let (begin, end) = (edge(i), edge(i + 1));
            let here = place + to * (begin + (end - begin) * chance.next());
            let (of_air, of_haze, lost) = air.at(here);
            let rest = (-lost * (end - begin)).exp();
            let scattered = through * (of_air + of_haze) * (1.0 - rest) / lost.max(DVec3::splat(1e-12));
            second += scattered * air.sunlight(here, sun) / (4.0 * PI);
            again += scattered;
            through *= rest;
        }
        if let Some(way) = to_ground {
            let ground = place + to * way;
            let up = ground.normalize();
            second += through * air.sunlight(ground + up * 1e-6, sun) * up.dot(sun).max(0.0) * air.albedo / PI;
        }
    }
    let count = f64::from(directions);
    second / count / (1.0 - again / count)
}

/// Radiance for sunlight of 1 by following light backwards, one colour at a time, with the phases of every scattering.
fn by_chance(air: &Air, sun: DVec3, to: DVec3, channel: usize, paths: u32, chance: &mut Chance) -> f64 {
    let most = air.at(DVec3::Y * GROUND).2[channel];
    let mut sum = 0.0;
    for _ in 0..paths {
        let (mut place, mut direction, mut weight) = (DVec3::Y * EYE, to, 1.0);
        for _ in 0..60 {
            let (to_top, to_ground) = way(place, direction);
            let length = to_ground.unwrap_or(to_top);
            // Woodcock 1965: steps as long as in the densest air, of which some meet nothing.
            let mut at = 0.0;
            let met = loop {
                at -= (1.0 - chance.next()).ln() / most;
                if at >= length {
                    break None;
                }
                let here = place + direction * at;
                if chance.next() * most < air.at(here).2[channel] {
                    break Some(here);
                }
            };
            let Some(here) = met else {
                let Some(way) = to_ground else { break };
                let ground = place + direction * way;
                let up = ground.normalize();
                weight *= air.albedo;
                place = ground + up * 1e-6;
                sum += weight * air.sunlight(place, sun)[channel] * up.dot(sun).max(0.0) / PI;
                direction = (up + chance.direction()).normalize();
                continue;
            };
            let (of_air, of_haze, lost) = air.at(here);
            let (of_air, lost) = (of_air[channel], lost[channel]);
            weight *= (of_air + of_haze) / lost;
            let is_haze = chance.next() * (of_air + of_haze) < of_haze;
            let to_sun = direction.dot(sun);
            let phase = (of_air * rayleigh(to_sun) + of_haze * mie(to_sun)) / (of_air + of_haze);
            sum += weight * air.sunlight(here, sun)[channel] * phase;
            // Directions by what is nearly the phase, and a weight for the rest.
            let (next, density) =
                if is_haze { henyey_greenstein(direction, chance) } else { (chance.direction(), 0.25 / PI) };
            let cosine = direction.dot(next);
            weight *= if is_haze { mie(cosine) } else { rayleigh(cosine) } / density;
            (place, direction) = (here, next);
            if weight < 1e-3 {
                break;
            }
        }
    }
    sum / f64::from(paths)
}

fn henyey_greenstein(forward: DVec3, chance: &mut Chance) -> (DVec3, f64) {
    let g = 0.8f64;
    let part = (1.0 - g * g) / (1.0 - g + 2.0 * g * chance.next());
    let cosine = ((1.0 + g * g - part * part) / (2.0 * g)).clamp(-1.0, 1.0);
    let (sine, around) = ((1.0 - cosine * cosine).sqrt(), 2.0 * PI * chance.next());
    let right = forward.any_orthonormal_vector();
    let up = forward.cross(right);
    let density = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
    (forward * cosine + (right * around.cos() + up * around.sin()) * sine, density)
}

/// The radiance of a map in the texel at a direction, for sunlight of 1, and that texel's own direction.
fn found(map: &EnvironmentMap, to: DVec3) -> (DVec3, DVec3) {
    let u = 0.5 + to.z.atan2(to.x) / (2.0 * PI);
    let v = to.y.clamp(-1.0, 1.0).acos() / PI;
    let x = ((u * f64::from(map.width)) as u32).min(map.width - 1);
    let y = ((v * f64::from(map.height)) as u32).min(map.height - 1);
    let [r, g, b, _] = map.texels[(y * map.width + x) as usize].map(f64::from);
    let unit = f64::from(SKY_UNIT_NIT) / 128_000.0;
    (DVec3::new(r, g, b) * unit, equirectangular_direction((x, y), (map.width, map.height)).as_dvec3())
}

fn direction(elevation_deg: f64, azimuth_deg: f64) -> DVec3 {
    let (elevation, azimuth) = (elevation_deg.to_radians(), azimuth_deg.to_radians());
    DVec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), elevation.cos() * azimuth.cos())
}

const ALL: [(f64, f64); 7] =
    [(89.0, 0.0), (42.0, 3.0), (30.0, 90.0), (10.0, 180.0), (4.0, 20.0), (1.0, 120.0), (60.0, 150.0)];

#[test]
fn the_sky_is_that_of_its_paper() {
    let mut worst = 0.0f64;
    for (elevation, turbidity) in [(60.0f32, 1.05f32), (20.0, 2.0), (3.0, 4.0)] {
        let sky = Sky { sun_elevation_deg: elevation, sun_azimuth_deg: 0.0, turbidity, ground_albedo: 0.3 };
        let (map, air, sun) = (sky.map(), Air::of(&sky), direction(elevation.into(), 0.0));
        for (up, around) in ALL {
            let (found, to) = found(&map, direction(up, around));
            let truth = by_equations(&air, sun, to);
            let error = ((found - truth) / truth).abs().max_element();
            println!(
                "sun at {elevation}°, turbidity {turbidity}: {up}°, {around}°: {found:.4} of {truth:.4}, {error:.3}"
            );
            worst = worst.max(error);
        }
        let light = map.light.unwrap();
        let truth = air.sunlight(DVec3::Y * GROUND * (1.0 + 1e-9), sun) * (128_000.0 / f64::from(SKY_UNIT_NIT));
        let error = ((light.irradiance.as_dvec3() - truth) / truth).abs().max_element();
        println!("sun at {elevation}°, turbidity {turbidity}: its light {error:.4}");
        assert!(error < 0.01, "{error}");
        assert!(light.direction.as_dvec3().distance(sun) < 1e-5);
    }
    assert!(worst < 0.03, "{worst}");
}

/// How far the paper's sky is from one in which every scattering is followed. The bound is what was measured, noise of
/// the paths included, and a little more.
#[test]
fn the_sky_is_near_to_one_whose_light_is_followed() {
    let mut chance = Chance(11);
    let (mut sum, mut all) = (0.0, 0.0);
    for (elevation, turbidity) in [(60.0f32, 1.05f32), (20.0, 2.0)] {
        let sky = Sky { sun_elevation_deg: elevation, sun_azimuth_deg: 0.0, turbidity, ground_albedo: 0.3 };
        let (map, air, sun) = (sky.map(), Air::of(&sky), direction(elevation.into(), 0.0));
        for (up, around) in [(80.0, 0.0), (30.0, 90.0), (45.0, 180.0), (15.0, 60.0)] {
            let (found, to) = found(&map, direction(up, around));
            for channel in 0..3 {
                let truth = by_chance(&air, sun, to, channel, 3000, &mut chance);
                println!("sun at {elevation}°: {up}°, {around}°, {channel}: {:.5} of {truth:.5}", found[channel]);
                sum += (found[channel] - truth).abs();
                all += truth;
            }
        }
    }
    println!("mean deviation {}", sum / all);
    assert!(sum / all < 0.08, "{}", sum / all);
}

#[test]
fn the_sun_sets_and_what_is_asked_for_is_seen() {
    let at = |elevation: f32| Sky { sun_elevation_deg: elevation, ..Sky::default() };
    let level = |map: &EnvironmentMap| {
        let zenith = map.texels[(map.width / 2) as usize];
        f64::from(zenith[2])
    };
    let (noon, dusk, night) = (at(60.0).map(), at(-4.0).map(), at(-60.0).map());
    assert!(noon.light.is_some() && dusk.light.is_none() && night.light.is_none());
    assert!(level(&noon) > 30.0 * level(&dusk) && level(&dusk) > 0.0 && level(&night) < 1e-4 * level(&noon));
    let [red, blue] = [0, 2].map(|channel| at(1.0).map().light.unwrap().irradiance[channel]);
    assert!(red > 3.0 * blue, "a low sun is red");
    // Yaw 90 is +X.
    let east = Sky { sun_azimuth_deg: 90.0, sun_elevation_deg: 0.0, ..Sky::default() }.map().light.unwrap();
    assert!(east.direction.distance(Vec3::X) < 1e-5);
    assert!(noon.texels.iter().flatten().all(|value| value.is_finite()));
    let dark = Sky { ground_albedo: 0.0, ..at(60.0) }.map();
    let below = |map: &EnvironmentMap| f64::from(map.texels[map.texels.len() - 1][1]);
    assert!(below(&noon) > 10.0 * below(&dark));
}
