//! Grids of probes: the light that arrives at places, by paths.

use crate::BakeError;
use crate::emitters::{DistantLight, Emitters, luminance};
use crate::light_map::check_rays;
use crate::paths::{Draw, Paths};
use crate::progress::{Progress, Stage};
use crate::sampling::{even_direction, hash2, point};
use crate::small_source::{DirectLight, take_small_source};
use crate::surfaces::Surfaces;
use crate::tracing::Tracer;
use crate::work::{Keeper, keep_blocks};
use glam::{Vec2, Vec3};
use manypass_scene::Scene;
use manypass_scene::probes::{DISTANCE_SIDE, Harmonics, Probe, ProbeGrid, ProbeLight, SmallSource, distance_direction};
use std::f32::consts::PI;
use std::hash::{DefaultHasher, Hasher as _};
use std::sync::Arc;

/// Rises whenever the same scene and settings have other light.
const VERSION: u32 = 1;

/// The round of the first grid, as keepers number them; others are below it.
const ROUND_OF_PROBES: u32 = u32::MAX - 1;

/// Probes that a thread takes at a time.
const BLOCK: usize = 32;

/// Rays by which a probe finds what it is in, and the share of them that sees the backs of surfaces inside something.
const INSIDE_SAMPLES: u32 = 128;
const INSIDE_SHARE: f32 = 0.25;

/// A probe is moved by so much of the distance to the next one at the most, along each axis, and so often.
const OFFSET_SHARE_MAX: f32 = 0.45;
const MOVES: u32 = 4;

/// It stands so far from surfaces, as a share of the least distance between probes, if it can.
const CLEARANCE_SHARE: f32 = 0.1;

/// One that was in a wall goes so far beyond it: light of the wrong side is told from there by a coarse map of distances.
const OUT_SHARE: f32 = 0.25;

/// Of distances around the middle of a texel those count that lie within some 7 degrees: the power of their cosine
/// (Majercik et al. 2019, "Dynamic Diffuse Global Illumination with Ray-Traced Irradiance Fields").
const DISTANCE_POWER: i32 = 128;

/// Places on a lamp that its light in a probe is the mean of.
const LAMP_SAMPLES: u32 = 16;

const DISTANCES: usize = DISTANCE_SIDE * DISTANCE_SIDE;
/// Numbers of a probe: light, offset, whether it is on, small source, distances.
const NUMBERS: usize = 9 * 3 + 4 + 7 + 2 * DISTANCES;

/// What was found of a probe.
struct ProbeResult {
    light: Harmonics,
    source: SmallSource,
    offset_m: Vec3,
    is_on: bool,
    distances: [Vec2; DISTANCES],
}

/// How well the light of probes is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeSettings {
    /// Rays from a probe.
    pub samples: u32,
    /// How often light is sent back before it arrives; 0 leaves what shines and what is around the scene.
    pub bounces: u32,
}

impl Default for ProbeSettings {
    fn default() -> Self {
        Self { samples: 1024, bounces: 3 }
    }
}

/// What stays of a scene while its probes are baked.
pub struct ProbeBaker<'a> {
    settings: ProbeSettings,
    surfaces: &'a Surfaces,
    emitters: Emitters<'a>,
    grids: Vec<ProbeGrid>,
}

/// What a probe stands in.
struct Neighbourhood {
    /// The share of directions in which it sees backs of surfaces.
    behind: f32,
    /// The nearest of them, as a way there.
    to_back: Option<Vec3>,
    /// The nearest surface that it sees from before.
    to_front: Option<Vec3>,
}

impl<'a> ProbeBaker<'a> {
    /// For grids of a scene. `around` is what is seen where nothing of the scene is.
    ///
    /// # Errors
    /// Settings are out of range.
    pub fn new(
        scene: &Scene,
        surfaces: &'a Surfaces,
        around: Option<&'a dyn DistantLight>,
        grids: Vec<ProbeGrid>,
        settings: &ProbeSettings,
    ) -> Result<Self, BakeError> {
        let ProbeSettings { samples, bounces } = *settings;
        check_rays((samples, "from a probe"), bounces)?;
        Ok(Self { settings: *settings, surfaces, emitters: Emitters::new(scene, surfaces, around), grids })
    }

    /// A number that is another one for another scene, other grids or settings, or another version of this crate.
    pub fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        hasher.write(env!("CARGO_PKG_VERSION").as_bytes());
        hasher.write_u32(VERSION);
        hasher.write_usize(DISTANCE_SIDE);
        hasher.write(format!("{:?}", self.settings).as_bytes());
        for ProbeGrid { name, region, counts, fade_m, basis, .. } in &self.grids {
            hasher.write(format!("{name:?} {region:?} {counts:?} {fade_m:?} {basis:?}").as_bytes());
        }
        self.surfaces.hash_into(&mut hasher);
        self.emitters.hash_into(&mut hasher);
        hasher.finish()
    }

    /// Finds the light of all grids. What `keeper` knows is not computed again.
    ///
    /// # Errors
    /// `progress` says to stop.
    pub fn run(self, progress: &dyn Progress, keeper: &dyn Keeper) -> Result<Vec<ProbeGrid>, BakeError> {
        let tracer = Tracer::new(self.surfaces);
        let bounces = self.settings.bounces;
        let paths = Paths { surfaces: self.surfaces, tracer: &tracer, emitters: &self.emitters, bounces };
        let mut baked = Vec::new();
        let total: usize = self.grids.iter().map(ProbeGrid::count).sum();
        let mut before = 0;
        for (number, grid) in self.grids.iter().enumerate() {
            let count = grid.count();
            let mut probes = vec![Probe::default(); count];
            let blocks = probes.chunks_mut(BLOCK);
            let of_grid = Offset { progress, before, total };
            let stage = (&of_grid as &dyn Progress, Stage::Probes);
            let keeper = (keeper, ROUND_OF_PROBES - number as u32);
            let find = |index: usize| numbers(&self.probe(&paths, grid, index));
            keep_blocks(blocks, (BLOCK, count), stage, keeper, find, |probes, values| {
                for (probe, numbers) in probes.iter_mut().zip(values) {
                    *probe = of_numbers(numbers, grid);
                }
            })?;
            before += count;
            baked.push(ProbeGrid { probes: Some(Arc::new(probes)), ..grid.clone() });
        }
        Ok(baked)
    }

    fn neighbourhood(&self, paths: &Paths, place: Vec3, seed: u32) -> Neighbourhood {
        let (mut behind, mut to_back, mut to_front) = (0, None::<Vec3>, None::<Vec3>);
        for sample in 0..INSIDE_SAMPLES {
            let direction = even_direction(point(sample, seed));
            let Some(hit) = paths.tracer.first(place, direction) else { continue };
            let is_black = paths.tracer.is_black(&hit);
            behind += u32::from(is_black);
            let nearest = if is_black { &mut to_back } else { &mut to_front };
            let way = direction * hit.distance_m;
            if nearest.is_none_or(|nearest| way.length_squared() < nearest.length_squared()) {
                *nearest = Some(way);
            }
        }
        Neighbourhood { behind: behind as f32 / INSIDE_SAMPLES as f32, to_back, to_front }
    }

    /// Where a probe stands that is free, by how much it was moved, and whether it is.
    fn stand(&self, paths: &Paths, grid: &ProbeGrid, index: usize, seed: u32) -> (Vec3, bool) {
        let (place, spacing_m) = (grid.place(index), grid.spacing_m());
        let (least_m, out_m) = (CLEARANCE_SHARE * spacing_m.min_element(), OUT_SHARE * spacing_m.min_element());
        let most_m = OFFSET_SHARE_MAX * spacing_m;
        let (mut offset_m, mut best) = (Vec3::ZERO, (Vec3::ZERO, f32::MAX));
        for step in 0..=MOVES {
            let around = self.neighbourhood(paths, place + offset_m, hash2(seed, 64 + step));
            if around.behind < best.1 {
                best = (offset_m, around.behind);
            }
            let way = match (around.to_back, around.to_front) {
                // Out through the nearest wall, and a little beyond.
                (Some(back), _) if around.behind > INSIDE_SHARE => back + back.normalize_or_zero() * out_m,
                (_, Some(front)) if front.length() < 0.9 * least_m => {
                    -front.normalize_or_zero() * (least_m - front.length())
                }
                _ => {
                    best = (offset_m, around.behind);
                    break;
                }
            };
            offset_m = (offset_m + way).clamp(-most_m, most_m);
        }
        (best.0, best.1 <= INSIDE_SHARE)
    }

    fn probe(&self, paths: &Paths, grid: &ProbeGrid, index: usize) -> ProbeResult {
        let seed = hash2(index as u32, 77);
        let (offset_m, is_on) = self.stand(paths, grid, index, seed);
        let (mut light, mut sums) = (Harmonics::default(), [(Vec2::ZERO, 0.0f32); DISTANCES]);
        let mut made = Vec::new();
        let place = grid.place(index) + offset_m;
        let (count, most_m) = (self.settings.samples, grid.distance_max_m());
        let (each, even) = (1.0 / count as f32, 1.0 / (4.0 * PI));
        for sample in 0..if is_on { count } else { 0 } {
            let draw = Draw { sample, seed };
            let direction = even_direction(draw.point(0));
            let brought = paths.along(place, direction, even, draw);
            let whole = 4.0 * PI * each;
            light.add(direction, finite(brought.sent_back + brought.share) * whole);
            if brought.made != Vec3::ZERO {
                let (share, level) = (finite(brought.share) * whole, luminance(brought.made));
                made.push(DirectLight { direction, share, level });
            }
            let points = [1, 2].map(|at| draw.point(u32::MAX - at));
            let chosen = [
                self.emitters.choose_shining(paths.tracer, place, |_| true, points[0]),
                self.emitters.choose_around(paths.tracer, place, |_| true, points[1]),
            ];
            for chosen in chosen.into_iter().flatten() {
                let (direction, share) = (chosen.direction, finite(chosen.share(even)) * each);
                light.add(direction, share);
                made.push(DirectLight { direction, share, level: luminance(chosen.radiance) });
            }
            let distance_m = brought.hit.map_or(most_m, |hit| hit.distance_m.min(most_m));
            for (at, (sum, weight)) in sums.iter_mut().enumerate() {
                let share = distance_direction(at).dot(direction).max(0.0).powi(DISTANCE_POWER);
                *sum += share * Vec2::new(distance_m, distance_m * distance_m);
                *weight += share;
            }
        }
        // Nearer ones would light all that is between probes as if it were as near.
        let least_m = 0.5 * grid.spacing_m().min_element();
        for sample in 0..if is_on { LAMP_SAMPLES } else { 0 } {
            self.emitters.held_lamps_at(
                paths.tracer,
                (place, least_m),
                point(sample, hash2(seed, 3)),
                |direction, irradiance| {
                    let share = finite(irradiance) / LAMP_SAMPLES as f32;
                    light.add(direction, share);
                    made.push(DirectLight { direction, share, level: f32::INFINITY });
                },
            );
        }
        let source = take_small_source(&mut light, &made);
        let distances = sums.map(|(sum, weight)| if weight > 0.0 { sum / weight } else { Vec2::ZERO });
        ProbeResult { light, source, offset_m, is_on, distances }
    }
}

fn finite(value: Vec3) -> Vec3 {
    if value.is_finite() { value } else { Vec3::ZERO }
}

fn numbers(found: &ProbeResult) -> [f32; NUMBERS] {
    let of_light = found.light.0.iter().flat_map(|color| color.to_array());
    let of_place = found.offset_m.extend(if found.is_on { 1.0 } else { 0.0 }).to_array();
    let of_source = [found.source.direction, found.source.irradiance].map(|of| of.to_array());
    let of_distances = found.distances.iter().flat_map(|distance| distance.to_array());
    let of_source = of_source.into_iter().flatten().chain([found.source.spread]);
    let mut all = of_light.chain(of_place).chain(of_source).chain(of_distances);
    std::array::from_fn(|_| all.next().unwrap_or(0.0))
}

fn of_numbers(numbers: &[f32; NUMBERS], grid: &ProbeGrid) -> Probe {
    let vector = |at: usize| Vec3::new(numbers[at], numbers[at + 1], numbers[at + 2]);
    let light = Harmonics(std::array::from_fn(|at| vector(3 * at)));
    let source = SmallSource { direction: vector(31), irradiance: vector(34), spread: numbers[37] };
    let distances = std::array::from_fn(|at| Vec2::new(numbers[38 + 2 * at], numbers[39 + 2 * at]));
    let (offset_m, is_on) = (vector(27), numbers[30] > 0.5);
    Probe { offset_m, is_on, light: ProbeLight::new(&light, source, grid.basis), distances }
}

/// Steps of a grid among those of all.
struct Offset<'a> {
    progress: &'a dyn Progress,
    before: usize,
    total: usize,
}

impl Progress for Offset<'_> {
    fn step(&self, stage: Stage, done: u64, _: u64) -> bool {
        self.progress.step(stage, self.before as u64 + done, self.total as u64)
    }
}
