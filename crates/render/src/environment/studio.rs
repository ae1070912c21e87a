//! The built-in studio: what surrounds a scene that brings neither lights nor a picture of its surroundings.
//!
//! It is a picture of all directions in grey, made of a room (a dark floor, a wall that is brightest at the horizon, a
//! ceiling) and of soft boxes: a key from above on the left, a wide fill on the right, two strips behind for long
//! highlights along edges, and one overhead. A white sphere reads about 0.65 on average. What surfaces of some
//! roughness reflect of it has a closed form while lobes are narrow, because they weigh the plane of their tangents as
//! form factors do: a straight edge that is blurred by one is x / √(x² + a²), and rectangles have a form factor. Of wide
//! lobes the light is that of sums over all directions, and the closed form has the edges between them. So it takes some
//! tens of milliseconds, of which a cache spares later processes most, no file and no pass of its own, and is the same on
//! every backend.

use super::lobe::{Lobe, roughness_of_level};
use super::stored;
use crate::constants::ENVIRONMENT_LEVEL_LAST;
use crate::environment_tiles::{Tile, TileSides, texture_size};
use glam::{Mat3, Vec3};
use half::f16;
use manypass_scene::{Cache, EnvironmentLight};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The sides of its tiles, whose texels are at most two thirds as wide as a blurred edge is soft: what is between them
/// would show as teeth along edges.
pub(crate) const SIDES: TileSides = TileSides { mirror: 512, fine: 256, medium: 128, coarse: 32 };

/// In tiles larger than coarse ones the closed form and sums are taken at every so many texels, and where the studio is
/// uneven the closed form at all: 128 / 4 places are as many as a coarse tile has.
const STRIDE: usize = 4;

/// A third of the texels are the mirror's, which one thread draws: more threads than this would wait for it.
const THREADS_MAX: usize = 4;

/// What a soft box adds is left out where it is less than this: a thousandth of the room.
const DIM_RADIANCE: f32 = 1e-4;

/// What is between texels is taken from them where the middle differs by less than this share of what is there.
const TOLERANCE: f32 = 0.003;

/// The share of the key that is a light with shadows, and not in the tiles.
const KEY_LIGHT_SHARE: f32 = 0.7;

/// What the studio without that light is multiplied by so that it gives as much light on average: where it is a fill.
pub(crate) const WITHOUT_KEY_LIGHT: f32 = 1.3;

/// Up to this level lobes are narrow: the tangents of their half widths are far from 1. Of its last the closed form is
/// within 2 %.
const LEVEL_NARROW_LAST: u32 = 7;

/// The sides of the faces of a cube whose texels are all directions, of the first level after [`LEVEL_NARROW_LAST`] and
/// from each of [`SPHERE_LEVELS`] on.
const SPHERE_SIDES: [u32; 4] = [32, 24, 16, 12];
/// See [`SPHERE_SIDES`].
const SPHERE_LEVELS: [u32; 3] = [9, 11, 15];

/// A rectangle that shines, seen from the middle of the room.
#[derive(Clone, Copy, Debug)]
struct SoftBox {
    /// Where its middle is; of any length.
    axis: Vec3,
    /// Half its width and height as tangents.
    half_extent: [f32; 2],
    /// How soft its edges are, in the same measure.
    edge: f32,
    radiance: f32,
}

const KEY: SoftBox =
    SoftBox { axis: Vec3::new(-0.60, 0.64, 0.48), half_extent: [0.22, 0.22], edge: 0.02, radiance: 14.5 };

const BOXES: [SoftBox; 4] = [
    // A fill on the right.
    SoftBox { axis: Vec3::new(0.88, 0.30, 0.36), half_extent: [0.36, 0.62], edge: 0.03, radiance: 1.2 },
    // Strips behind, on the left and on the right.
    SoftBox { axis: Vec3::new(-0.72, 0.22, -0.66), half_extent: [0.14, 0.75], edge: 0.02, radiance: 2.1 },
    SoftBox { axis: Vec3::new(0.55, 0.30, -0.78), half_extent: [0.16, 0.70], edge: 0.02, radiance: 2.3 },
    // Overhead.
    SoftBox { axis: Vec3::new(0.05, 1.0, -0.1), half_extent: [0.75, 0.45], edge: 0.05, radiance: 0.6 },
];

/// From 0 to 1 around x = 0: a step that is blurred by the marginal of a lobe of GGX.
fn step(x: f32, width: f32) -> f32 {
    0.5 + 0.5 * x / (x * x + width * width).sqrt()
}

/// The angle of a tangent in radians, within 0.000 02 (Abramowitz & Stegun 1964, "Handbook of Mathematical Functions",
/// 4.4.49).
fn angle(tangent: f32) -> f32 {
    let magnitude = tangent.abs();
    let is_steep = magnitude > 1.0;
    let t = if is_steep { 1.0 / magnitude } else { magnitude };
    let square = t * t;
    let of_odd =
        0.999_866 + square * (-0.330_299_5 + square * (0.180_141 + square * (-0.085_133 + square * 0.020_835_1)));
    let angle = if is_steep { FRAC_PI_2 - t * of_odd } else { t * of_odd };
    angle.copysign(tangent)
}

/// What a lobe of GGX has of the rectangles from the origin to each (`x`, `y`), from −¼ to ¼: on the plane of tangents
/// the lobe weighs as the form factor does of a point at the height `width` below it (Baum et al. 1989, "Improving
/// Radiosity Solutions Through the Use of Analytically Determined Form-Factors").
fn corners(x: [f32; 4], y: [f32; 4], width: f32) -> [f32; 4] {
    // Four at a time, so that compilers find vectors.
    std::array::from_fn(|at| {
        let (x, y) = (x[at], y[at]);
        let (near_x, near_y) = (1.0 / (x * x + width * width).sqrt(), 1.0 / (y * y + width * width).sqrt());
        (x * near_x * angle(y * near_x) + y * near_y * angle(x * near_y)) / TAU
    })
}

/// A soft box with its axes.
#[derive(Clone, Copy, Debug)]
struct OrientedBox {
    of: SoftBox,
    axes: Mat3,
}

impl OrientedBox {
    fn new(of: SoftBox) -> Self {
        let forward = of.axis.normalize();
        let up = if forward.y.abs() < 0.9 { Vec3::Y } else { Vec3::NEG_Z };
        let right = up.cross(forward).normalize();
        Self { of, axes: Mat3::from_cols(right, forward.cross(right), forward) }
    }

    /// Radiance in a direction, blurred by lobes whose tangent of the half width is `blur`.
    fn at(&self, direction: Vec3, blur: f32) -> f32 {
        let forward = self.axes.z_axis.dot(direction);
        if forward <= 0.05 {
            return 0.0;
        }
        // An edge that is soft by one such lobe and blurred by another is as one blurred by this: a fit to integrals.
        let width = 0.5 * (self.of.edge.hypot(blur) + self.of.edge + blur);
        let [half_width, half_height] = self.of.half_extent;
        let [x, y] = [self.axes.x_axis, self.axes.y_axis].map(|axis| axis.dot(direction) / forward);
        // Far away the lobe is nearly even over the box.
        let [beside, above] = [x.abs() - half_width, y.abs() - half_height].map(|by| by.max(0.0));
        let lobe = beside * beside + above * above + width * width;
        let area = 4.0 * half_width * half_height;
        if width * width * area * self.of.radiance < DIM_RADIANCE * PI * lobe * lobe {
            return 0.0;
        }
        let ([left, right], [lower, upper]) = ([x - half_width, x + half_width], [y - half_height, y + half_height]);
        let [a, b, c, d] = corners([left, right, left, right], [lower, lower, upper, upper], width);
        self.of.radiance * (a - b - c + d)
    }

    /// Irradiance of a plane that faces it.
    fn irradiance(&self) -> f32 {
        const STEPS: u16 = 64;
        let place = |at: u16, half: f32| (2.0 * (f32::from(at) + 0.5) / f32::from(STEPS) - 1.0) * (half + 0.3);
        let [width, height] = self.of.half_extent.map(|half| half + 0.3);
        let texel = 4.0 * width * height / f32::from(STEPS * STEPS);
        let places = (0..STEPS * STEPS).map(|i| {
            let [x, y] = [place(i % STEPS, self.of.half_extent[0]), place(i / STEPS, self.of.half_extent[1])];
            let towards = self.axes * Vec3::new(x, y, 1.0);
            // A texel at the distance d takes 1 / d³, and the plane sees its cosine.
            self.at(towards.normalize(), 0.0) / towards.length_squared().powi(2)
        });
        places.sum::<f32>() * texel
    }
}

/// The room, by the sine of the elevation.
fn room(sine: f32, blur: f32) -> f32 {
    let floor_to_wall = 0.14 * step(sine + 0.02, 0.03 + blur);
    let up_the_wall = -0.08 * step(sine - 0.3, 0.2 + blur);
    let ceiling = 0.05 * step(sine - 0.85, 0.2 + blur);
    0.15 + floor_to_wall + up_the_wall + ceiling
}

/// The studio with a share of its key.
struct Studio {
    key: OrientedBox,
    key_share: f32,
    boxes: [OrientedBox; BOXES.len()],
}

impl Studio {
    fn new(key_share: f32) -> Self {
        Self { key: OrientedBox::new(KEY), key_share, boxes: BOXES.map(OrientedBox::new) }
    }

    /// Radiance in a direction of length 1, blurred by lobes whose tangent of the half width is `blur`.
    fn at(&self, direction: Vec3, blur: f32) -> f32 {
        let boxes: f32 = self.boxes.iter().map(|placed| placed.at(direction, blur)).sum();
        room(direction.y, blur) + self.key_share * self.key.at(direction, blur) + boxes
    }
}

/// The radiance of a direction of length 1, without that of [`key_light`].
pub(crate) fn radiance(direction: Vec3) -> f32 {
    static STUDIO: OnceLock<Studio> = OnceLock::new();
    STUDIO.get_or_init(|| Studio::new(1.0 - KEY_LIGHT_SHARE)).at(direction, 0.0)
}

/// The light that stands for a share of the key.
pub(crate) fn key_light() -> EnvironmentLight {
    static LIGHT: OnceLock<EnvironmentLight> = OnceLock::new();
    *LIGHT.get_or_init(|| EnvironmentLight {
        direction: KEY.axis.normalize(),
        irradiance: Vec3::splat(OrientedBox::new(KEY).irradiance() * KEY_LIGHT_SHARE),
        half_angle_tan: KEY.half_extent[0],
    })
}

/// The key of the studio where that is a fill: part of its light from everywhere, and no light of surfaces. The ground
/// has its shadow.
pub(crate) fn key_of_fill() -> EnvironmentLight {
    let light = key_light();
    // The fill is brighter by what makes up for the key.
    EnvironmentLight { irradiance: light.irradiance / WITHOUT_KEY_LIGHT, ..light }
}

static TEXELS: OnceLock<Vec<[f16; 4]>> = OnceLock::new();

/// Takes the texels from `cache`, or computes them, on one thread of its own, so that they are there when they are asked
/// for; where there can be no thread, nothing happens.
pub(crate) fn begin(cache: Option<Arc<dyn Cache>>) {
    let begin = move || {
        let count = texture_size(SIDES).0 as usize * texture_size(SIDES).1 as usize;
        let name = stored::name_of_studio();
        let mut computed = false;
        let texels = TEXELS.get_or_init(|| {
            let entry = cache.as_ref().and_then(|cache| cache.get(&name));
            entry.and_then(|entry| stored::greys_of(&entry, count)).unwrap_or_else(|| {
                computed = true;
                texels_of(&Studio::new(1.0 - KEY_LIGHT_SHARE), 1)
            })
        });
        if let Some(cache) = cache.filter(|_| computed) {
            cache.put(&name, &stored::entry_of_greys(texels));
        }
    };
    drop(std::thread::Builder::new().spawn(begin));
}

/// The texels of its tiles, without the key light, in the texture of [`SIDES`]: rows from the top.
pub(crate) fn texels() -> &'static [[f16; 4]] {
    TEXELS.get_or_init(|| texels_of(&Studio::new(1.0 - KEY_LIGHT_SHARE), THREADS_MAX))
}

fn texels_of(studio: &Studio, threads_max: usize) -> Vec<[f16; 4]> {
    let (width, height) = texture_size(SIDES);
    let texels = Mutex::new(vec![[f16::ZERO; 4]; (width * height) as usize]);
    let spheres = SPHERE_SIDES.map(|side| Sphere::new(studio, side));
    let next = AtomicU32::new(0);
    let draw = || {
        loop {
            let level = next.fetch_add(1, Ordering::Relaxed);
            if level > ENVIRONMENT_LEVEL_LAST as u32 {
                break;
            }
            let sphere = &spheres[SPHERE_LEVELS.iter().filter(|first| level >= **first).count()];
            let of_level = Level {
                studio,
                sphere: Some(sphere).filter(|_| level > LEVEL_NARROW_LAST),
                tile: Tile::of_level(level, SIDES),
                alpha: roughness_of_level(level as f32).powi(2),
            };
            let drawn = of_level.drawn();
            let [left, top, across, _] = of_level.tile.rectangle().map(|part| part as usize);
            let mut texels = texels.lock().unwrap_or_else(PoisonError::into_inner);
            for (row, of_tile) in drawn.chunks_exact(across).enumerate() {
                texels[(top + row) * width as usize + left..][..across].copy_from_slice(of_tile);
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(threads_max);
    std::thread::scope(|scope| {
        // Where no further thread can be had, this one does its work.
        (1..threads).for_each(|_| drop(std::thread::Builder::new().spawn_scoped(scope, draw)));
        draw();
    });
    texels.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// What draws the tile of a level.
struct Level<'a> {
    studio: &'a Studio,
    /// If the lobe is wide.
    sphere: Option<&'a Sphere>,
    tile: Tile,
    alpha: f32,
}

impl Level<'_> {
    /// The closed form, which of wide lobes has the edges, but not quite the light.
    fn closed(&self, x: usize, y: usize) -> f32 {
        // Half vectors turn by half the angle that what they reflect does.
        self.studio.at(self.tile.direction([x as u32, y as u32]), 2.0 * self.alpha)
    }

    /// By how much the closed form at a texel is to be multiplied.
    fn factor(&self, x: usize, y: usize, closed: f32) -> f32 {
        let sum = |sphere: &Sphere| sphere.reflected(self.tile.direction([x as u32, y as u32]), self.alpha) / closed;
        self.sphere.map_or(1.0, sum)
    }

    /// The tile with its border, row by row. The closed form is found at every texel near edges, and at every fourth, as
    /// are sums, where it hardly bends.
    fn drawn(&self) -> Vec<[f16; 4]> {
        let side = self.tile.rectangle()[2] as usize;
        let mut texels = vec![[f16::ZERO; 4]; side * side];
        let stride = if self.tile.side > SIDES.coarse { STRIDE } else { 1 };
        let place = |node: usize| (node * stride).min(side - 1);
        let nodes = (side - 1).div_ceil(stride) + 1;
        let row_of = |row: usize| -> Vec<[f32; 2]> {
            let node = |column| {
                let closed = self.closed(place(column), place(row));
                [closed, self.factor(place(column), place(row), closed)]
            };
            (0..nodes).map(node).collect()
        };
        let mut above = row_of(0);
        for row in 1..nodes {
            let below = row_of(row);
            for column in 1..nodes {
                let at_corners = [above[column - 1], above[column], below[column - 1], below[column]];
                let block = [place(column - 1), place(row - 1), place(column), place(row)];
                self.fill(block, at_corners, |x, y, radiance| {
                    let grey = f16::from_f32(radiance);
                    texels[y * side + x] = [grey, grey, grey, f16::ONE];
                });
            }
            above = below;
        }
        texels
    }

    /// Puts radiance at the texels of a block from what is known of its corners: closed form and factor. Texels of its
    /// left and upper edge are those of the blocks before, but for the first.
    fn fill(
        &self,
        [left, top, right, bottom]: [usize; 4],
        at_corners: [[f32; 2]; 4],
        mut put: impl FnMut(usize, usize, f32),
    ) {
        let between = |part: usize, x: usize, y: usize| {
            let [share_x, share_y] =
                [(x - left) as f32 / (right - left) as f32, (y - top) as f32 / (bottom - top) as f32];
            let [a, b, c, d] = at_corners.map(|corner| corner[part]);
            let (upper, lower) = (a + (b - a) * share_x, c + (d - c) * share_x);
            upper + (lower - upper) * share_y
        };
        let (x, y) = ((left + right) / 2, (top + bottom) / 2);
        let is_even = right == left + 1 && bottom == top + 1
            || (self.closed(x, y) / between(0, x, y).max(1e-6) - 1.0).abs() < TOLERANCE;
        let [first_x, first_y] = [left, top].map(|edge| if edge == 0 { 0 } else { edge + 1 });
        for (y, x) in (first_y..=bottom).flat_map(|y| (first_x..=right).map(move |x| (y, x))) {
            let closed = if is_even { between(0, x, y) } else { self.closed(x, y) };
            put(x, y, closed * between(1, x, y));
        }
    }
}

/// Numbers side by side, so that compilers find vectors in loops over them.
const LANES: usize = 8;

/// The studio in all directions.
struct Sphere {
    /// X, y, z, solid angle, radiance of so many directions at a time.
    parts: Vec<[[f32; LANES]; 5]>,
}

impl Sphere {
    fn new(studio: &Studio, side: u32) -> Self {
        let samples = Lobe::of_sphere(1.0, side, side).samples;
        // About as much as the texel of a face takes.
        let blur = 0.5 / side as f32;
        let part = |samples: &[[f32; 4]]| {
            let mut part = [[0.0; LANES]; 5];
            for (lane, [x, y, z, solid_angle]) in samples.iter().copied().enumerate() {
                let radiance = studio.at(Vec3::new(x, y, z), blur);
                [x, y, z, solid_angle, radiance].iter().zip(&mut part).for_each(|(value, of)| of[lane] = *value);
            }
            part
        };
        Self { parts: samples.chunks(LANES).map(part).collect() }
    }

    /// What a surface reflects, seen along its normal.
    fn reflected(&self, normal: Vec3, alpha: f32) -> f32 {
        let narrow = 1.0 - alpha * alpha;
        let (mut sums, mut weights) = ([0.0f32; LANES], [0.0f32; LANES]);
        for [x, y, z, solid_angle, radiance] in &self.parts {
            for lane in 0..LANES {
                let n_dot_l = (normal.x * x[lane] + normal.y * y[lane] + normal.z * z[lane]).max(0.0);
                // The square of the half vector's cosine is (1 + n·l) / 2.
                let d = 1.0 - 0.5 * (1.0 + n_dot_l) * narrow;
                let weight = solid_angle[lane] * n_dot_l / (d * d);
                sums[lane] += weight * radiance[lane];
                weights[lane] += weight;
            }
        }
        sums.iter().sum::<f32>() / weights.iter().sum::<f32>().max(1e-12)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions spread evenly.
    fn directions(count: u32) -> impl Iterator<Item = Vec3> {
        (0..count).map(move |i| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
            let (sin, cos) = (i as f32 * 2.399_963_2).sin_cos();
            let across = (1.0 - y * y).sqrt();
            Vec3::new(across * cos, y, across * sin)
        })
    }

    fn mean(studio: &Studio) -> f32 {
        directions(40_000).map(|direction| studio.at(direction, 0.0)).sum::<f32>() / 40_000.0
    }

    #[test]
    fn angles_are_those_of_their_tangents() {
        for tangent in (-400..=400).map(|i| i as f32 * 0.01).chain([-1e9, -50.0, 50.0, 1e9]) {
            assert!((angle(tangent) - tangent.atan()).abs() < 2e-5, "{tangent}");
        }
    }

    #[test]
    fn a_white_sphere_reads_two_thirds() {
        let whole = mean(&Studio::new(1.0));
        assert!((0.61..0.68).contains(&whole), "{whole}");
        let ratio = whole / mean(&Studio::new(1.0 - KEY_LIGHT_SHARE));
        assert!((ratio / WITHOUT_KEY_LIGHT - 1.0).abs() < 0.01, "{ratio}");
    }

    #[test]
    fn the_key_light_is_what_the_tiles_lack() {
        let [whole, without] = [1.0, 1.0 - KEY_LIGHT_SHARE].map(Studio::new);
        let light = key_light();
        let cosine = |direction: Vec3| light.direction.dot(direction).max(0.0);
        let lacks = |direction: Vec3| (whole.at(direction, 0.0) - without.at(direction, 0.0)) * cosine(direction);
        let irradiance = directions(200_000).map(lacks).sum::<f32>() * 4.0 * PI / 200_000.0;
        assert!((irradiance / light.irradiance.x - 1.0).abs() < 0.02, "{irradiance} {}", light.irradiance);
    }

    /// The integral over the lobe of GGX, by importance, of the mirror's picture.
    fn integral(studio: &Studio, normal: Vec3, alpha: f32) -> f32 {
        const COUNT: u16 = 4_000;
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in 0..COUNT {
            let u = (f32::from(i) + 0.5) / f32::from(COUNT);
            let cos_squared = (1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u);
            let (cos, sin) = (cos_squared.sqrt(), (1.0 - cos_squared).max(0.0).sqrt());
            let (y, x) = (f32::from(i) * 2.399_963_2).sin_cos();
            let n_dot_l = 2.0 * cos_squared - 1.0;
            if n_dot_l > 0.0 {
                let light = (tangent * x + bitangent * y) * (2.0 * cos * sin) + normal * n_dot_l;
                sum += studio.at(light, 0.0) * n_dot_l;
                weights += n_dot_l;
            }
        }
        sum / weights
    }

    #[test]
    fn every_level_is_the_integral_over_its_lobe() {
        let studio = Studio::new(1.0 - KEY_LIGHT_SHARE);
        let texels = texels_of(&studio, THREADS_MAX);
        let (width, _) = texture_size(SIDES);
        let mut worst = 0.0f32;
        for level in 1..=ENVIRONMENT_LEVEL_LAST as u32 {
            let tile = Tile::of_level(level, SIDES);
            let alpha = roughness_of_level(level as f32).powi(2);
            let (mut error, mut sum) = (0.0f32, 0.0f32);
            for (x, y) in (1..=16).flat_map(|y| (1..=16).map(move |x| (x * tile.side / 17, y * tile.side / 17))) {
                let [left, top, ..] = tile.rectangle();
                let found = texels[((top + 1 + y) * width + left + 1 + x) as usize][0].to_f32();
                let truth = integral(&studio, tile.direction([x + 1, y + 1]), alpha);
                error += (found - truth).abs();
                sum += truth;
            }
            println!("level {level}: mean error {:.4}", error / sum);
            worst = worst.max(error / sum);
        }
        assert!(worst < 0.02, "{worst}");
    }
}
