//! The two tables of Hillaire 2020: how much light comes through the air, and how much light that was scattered more
//! than once is everywhere in it.

use super::air::{Air, GROUND_KM, Medium, Ray, TOP_KM};
use glam::DVec3;
use std::f64::consts::PI;

/// Columns and rows: angle and height.
const DEPTH_SIZE: [usize; 2] = [256, 64];
const DEPTH_STEPS: u32 = 80;
const MULTIPLE_SIZE: [usize; 2] = [32, 24];
const MULTIPLE_STEPS: u32 = 20;
/// Directions by height and, on one side of the plane of the sun, around.
const DIRECTIONS: [u32; 2] = [16, 4];

/// Values between which others lie.
#[derive(Debug)]
struct Table {
    size: [usize; 2],
    values: Vec<DVec3>,
}

impl Table {
    /// Of what `value` gives for places from 0 to 1, both ends included.
    fn new(size: [usize; 2], value: impl Fn([f64; 2]) -> DVec3) -> Self {
        let share = |at: usize, count: usize| at as f64 / (count - 1) as f64;
        let place = |i: usize| [share(i % size[0], size[0]), share(i / size[0], size[1])];
        Self { size, values: (0..size[0] * size[1]).map(|i| value(place(i))).collect() }
    }

    fn at(&self, place: [f64; 2]) -> DVec3 {
        let [x, y] = [0, 1].map(|axis| place[axis].clamp(0.0, 1.0) * (self.size[axis] - 1) as f64);
        let (column, row) = ((x as usize).min(self.size[0] - 2), (y as usize).min(self.size[1] - 2));
        let [right, down] = [x - column as f64, y - row as f64];
        let first = row * self.size[0] + column;
        let along = |first: usize| self.values[first].lerp(self.values[first + 1], right);
        along(first).lerp(along(first + self.size[0]), down)
    }
}

/// Both tables of an atmosphere, for sunlight of 1.
#[derive(Debug)]
pub(super) struct Tables {
    pub air: Air,
    /// Optical depths, which differ less from place to place than what comes through.
    depth: Table,
    multiple: Table,
}

/// From a horizontal ray on the ground to the end of the air.
fn horizon_km() -> f64 {
    (TOP_KM * TOP_KM - GROUND_KM * GROUND_KM).sqrt()
}

/// The ways by which rays are told apart at a distance from the middle of the Earth (Bruneton & Neyret 2008): straight
/// up, and along the ground; with the height as a share.
fn ways_km(radius_km: f64) -> ([f64; 2], f64) {
    let along_ground = (radius_km * radius_km - GROUND_KM * GROUND_KM).max(0.0).sqrt();
    ([TOP_KM - radius_km, along_ground + horizon_km()], along_ground / horizon_km())
}

impl Tables {
    /// Of `air` above ground that reflects the share `ground_albedo` of light.
    pub fn new(air: Air, ground_albedo: DVec3) -> Self {
        let depth = Table::new(DEPTH_SIZE, |[way, height]| {
            let along_ground = height * horizon_km();
            let radius_km = (along_ground * along_ground + GROUND_KM * GROUND_KM).sqrt();
            let ([least, most], _) = ways_km(radius_km);
            let way_km = least + way * (most - least);
            let rise = TOP_KM * TOP_KM - radius_km * radius_km - way_km * way_km;
            let cosine = if way_km > 0.0 { (rise / (2.0 * radius_km * way_km)).clamp(-1.0, 1.0) } else { 1.0 };
            let ray = Ray { radius_km, cosine };
            let steps = Steps::new(way_km, DEPTH_STEPS);
            steps.map(|(at, step)| air.at(ray.radius_at(at) - GROUND_KM).extinction * step).sum()
        });
        let mut tables = Self { air, depth, multiple: Table { size: [2, 2], values: vec![DVec3::ZERO; 4] } };
        tables.multiple = Table::new(MULTIPLE_SIZE, |place| tables.multiply_scattered(place, ground_albedo));
        tables
    }

    /// The share of sunlight that arrives at a distance from the middle of the Earth, where the sun stands at an angle
    /// with the cosine `sun_cosine` from straight up.
    pub fn sunlight(&self, radius_km: f64, sun_cosine: f64) -> DVec3 {
        let ray = Ray { radius_km, cosine: sun_cosine };
        if ray.meets_ground() {
            return DVec3::ZERO;
        }
        let ([least, most], height) = ways_km(radius_km);
        (-self.depth.at([(ray.to_top_km() - least) / (most - least), height])).exp()
    }

    /// The light from all directions that was scattered more than once, divided by the solid angle of all directions.
    pub fn multiple(&self, radius_km: f64, sun_cosine: f64) -> DVec3 {
        let height = ((radius_km - GROUND_KM) / (TOP_KM - GROUND_KM)).max(0.0);
        self.multiple.at([0.5 + 0.5 * sun_cosine.signum() * sun_cosine.abs().sqrt(), height.sqrt()])
    }

    /// Equations 5 to 10 of the paper at a place of the table.
    fn multiply_scattered(&self, [sun, height]: [f64; 2], ground_albedo: DVec3) -> DVec3 {
        let radius_km = GROUND_KM + (height * height * (TOP_KM - GROUND_KM)).max(1e-3);
        // Columns are close where the sun rises, rows near the ground.
        let place = 2.0 * sun - 1.0;
        let sun_cosine = place * place.abs();
        let sun_sine = (1.0 - sun_cosine * sun_cosine).max(0.0).sqrt();
        let (mut second, mut again) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..DIRECTIONS[0] * DIRECTIONS[1] {
            let cosine = 2.0 * (f64::from(i / DIRECTIONS[1]) + 0.5) / f64::from(DIRECTIONS[0]) - 1.0;
            let around = PI * (f64::from(i % DIRECTIONS[1]) + 0.5) / f64::from(DIRECTIONS[1]);
            let ray = Ray { radius_km, cosine };
            let to_sun = cosine * sun_cosine + (1.0 - cosine * cosine).sqrt() * sun_sine * around.cos();
            let mut through = DVec3::ONE;
            for (at, step) in Steps::new(ray.length_km(), MULTIPLE_STEPS) {
                let here_km = ray.radius_at(at);
                let here_sun = (radius_km * sun_cosine + at * to_sun) / here_km;
                let medium = self.air.at(here_km - GROUND_KM);
                let (share, rest) = absorbed(&medium, step);
                let scattered = through * medium.scattering() * share;
                second += scattered * self.sunlight(here_km, here_sun) / (4.0 * PI);
                again += scattered;
                through *= rest;
            }
            if ray.meets_ground() {
                let at = ray.length_km();
                let ground_sun = ((radius_km * sun_cosine + at * to_sun) / GROUND_KM).max(0.0);
                second += through * self.sunlight(GROUND_KM, ground_sun) * ground_sun * ground_albedo / PI;
            }
        }
        let count = f64::from(DIRECTIONS[0] * DIRECTIONS[1]);
        second / count / (1.0 - again / count)
    }
}

/// What light is scattered on its way in a direction, apart by what scatters it, for sunlight of 1; phases are left
/// out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InScattering {
    pub rayleigh: DVec3,
    pub mie: DVec3,
    pub multiple: DVec3,
    /// The share of light from the end of the way that arrives.
    pub transmittance: DVec3,
}

impl InScattering {
    pub fn lerp(&self, other: &Self, share: f64) -> Self {
        Self {
            rayleigh: self.rayleigh.lerp(other.rayleigh, share),
            mie: self.mie.lerp(other.mie, share),
            multiple: self.multiple.lerp(other.multiple, share),
            transmittance: self.transmittance.lerp(other.transmittance, share),
        }
    }
}

impl Tables {
    /// Along `ray`, whose angle to the sun has the cosine `to_sun`, where the sun stands at an angle with the cosine
    /// `sun_cosine` from straight up.
    pub fn scattered(&self, ray: Ray, sun_cosine: f64, to_sun: f64, steps: u32) -> InScattering {
        let mut sum = InScattering { transmittance: DVec3::ONE, ..InScattering::default() };
        for (at, step) in Steps::new(ray.length_km(), steps) {
            let here_km = ray.radius_at(at);
            let here_sun = (ray.radius_km * sun_cosine + at * to_sun) / here_km;
            let medium = self.air.at(here_km - GROUND_KM);
            let (share, rest) = absorbed(&medium, step);
            let arriving = sum.transmittance * share;
            let sunlight = self.sunlight(here_km, here_sun) * arriving;
            sum.rayleigh += sunlight * medium.rayleigh;
            sum.mie += sunlight * medium.mie;
            sum.multiple += arriving * medium.scattering() * self.multiple(here_km, here_sun);
            sum.transmittance *= rest;
        }
        sum
    }
}

/// The integral of transmittance over a step, and what of light comes through it.
fn absorbed(medium: &Medium, step: f64) -> (DVec3, DVec3) {
    let rest = (-medium.extinction * step).exp();
    ((1.0 - rest) / medium.extinction.max(DVec3::splat(1e-12)), rest)
}

/// Steps along a way, which grow with the distance: their middles and lengths.
struct Steps {
    way_km: f64,
    count: u32,
    next: u32,
}

impl Steps {
    fn new(way_km: f64, count: u32) -> Self {
        Self { way_km, count, next: 0 }
    }
}

impl Iterator for Steps {
    type Item = (f64, f64);

    fn next(&mut self) -> Option<(f64, f64)> {
        let edge = |at: u32| self.way_km * (f64::from(at) / f64::from(self.count)).powi(2);
        let [begin, end] = [edge(self.next), edge(self.next + 1)];
        self.next += 1;
        (self.next <= self.count).then_some((0.5 * (begin + end), end - begin))
    }
}
