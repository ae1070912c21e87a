//! Where light comes from: the scene's lights, surfaces that shine, and what is around the scene.

use crate::sampling::{balance, cosine_density, even_direction};
use crate::surfaces::{Spot, Surfaces, moving};
use crate::tracing::{Tracer, beside};
use glam::{Vec2, Vec3};
use manypass_scene::{EnvironmentLight, LightKind, LightMode, Scene};
use std::f32::consts::{PI, TAU};
use std::hash::Hasher;
use std::ops::{AddAssign, Div};

/// Radiance from around a scene, by direction, where nothing of the scene is.
pub trait DistantLight: Sync {
    /// The radiance that comes from a unit direction.
    fn radiance(&self, direction: Vec3) -> Vec3;

    /// A number that is another one where other light comes from it, for [`crate::Baker::key`], which also looks at radiance
    /// in some directions.
    fn key(&self) -> u64 {
        0
    }

    /// A light that belongs to it and is not in its radiance; as a light that is mixed, it is not in maps.
    fn light(&self) -> Option<EnvironmentLight> {
        None
    }
}

/// The same radiance from everywhere.
impl DistantLight for Vec3 {
    fn radiance(&self, _: Vec3) -> Vec3 {
        *self
    }
}

/// How light counts.
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Irradiance, and where it comes from.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ArrivingLight {
    pub irradiance: Vec3,
    /// The sum of unit directions towards where it comes from, each times the luminance of its irradiance: divided by
    /// the luminance of all of it, their mean.
    pub moment: Vec3,
}

impl ArrivingLight {
    /// Irradiance from a unit direction.
    pub fn from(direction: Vec3, irradiance: Vec3) -> Self {
        Self { irradiance, moment: direction * luminance(irradiance) }
    }
}

impl AddAssign for ArrivingLight {
    fn add_assign(&mut self, other: Self) {
        self.irradiance += other.irradiance;
        self.moment += other.moment;
    }
}

impl Div<f32> for ArrivingLight {
    type Output = Self;

    fn div(self, by: f32) -> Self {
        Self { irradiance: self.irradiance / by, moment: self.moment / by }
    }
}

/// A light of the scene where its node is.
#[derive(Clone, Debug)]
struct Lamp {
    position: Vec3,
    /// Where it shines.
    axis: Vec3,
    /// Candela or lux.
    intensity: Vec3,
    kind: LightKind,
    range_m: Option<f32>,
    radius_m: f32,
    casts_shadows: bool,
    /// Whether maps hold what comes straight from it.
    is_held: bool,
}

/// A surface as its light is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    pub position: Vec3,
    pub facet: Vec3,
    pub normal: Vec3,
}

impl Receiver {
    /// Where rays begin.
    pub fn start(&self) -> Vec3 {
        beside(self.position, self.facet)
    }

    /// Whether light from a direction reaches the side that is lit.
    fn faces(&self, direction: Vec3) -> bool {
        self.facet.dot(direction) > 0.0 && self.normal.dot(direction) > 0.0
    }
}

/// Light from a direction that was chosen by chance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSample {
    pub direction: Vec3,
    pub radiance: Vec3,
    /// How dense such directions are.
    pub density: f32,
}

impl LightSample {
    /// Its radiance divided by its density, as one of two samples, of which the other one has a density for its direction.
    pub fn share(&self, other: f32) -> Vec3 {
        self.radiance * (balance(self.density, other) / self.density)
    }
}

/// The share of a sum up to each of many parts, for choosing them by chance.
#[derive(Clone, Debug, Default)]
struct Choice {
    sums: Vec<f32>,
}

impl Choice {
    fn new(weights: impl Iterator<Item = f32>) -> Self {
        let mut sum = 0.0f64;
        let mut sums: Vec<f64> = Vec::new();
        for weight in weights {
            sum += f64::from(if weight.is_finite() { weight.max(0.0) } else { 0.0 });
            sums.push(sum);
        }
        if sum <= 0.0 {
            return Self::default();
        }
        Self { sums: sums.into_iter().map(|part| (part / sum) as f32).collect() }
    }

    /// The part of a number from 0 to 1, and a number from 0 to 1 within it.
    fn part(&self, place: f32) -> (usize, f32) {
        let index = self.sums.partition_point(|sum| *sum <= place).min(self.sums.len().saturating_sub(1));
        let (before, share) = (self.before(index), self.share(index));
        (index, ((place - before) / share.max(1e-20)).clamp(0.0, 0.999_999_94))
    }

    fn before(&self, index: usize) -> f32 {
        if index == 0 { 0.0 } else { self.sums[index - 1] }
    }

    fn share(&self, index: usize) -> f32 {
        self.sums.get(index).map_or(0.0, |sum| sum - self.before(index))
    }
}

/// What is around the scene, in texels of a map of all directions.
struct Surround<'a> {
    around: &'a dyn DistantLight,
    /// Rows by what all their texels give, and the texels of each: so points of the unit square that are spread evenly come to
    /// directions that are.
    rows: Choice,
    columns: Vec<Choice>,
}

/// Rows and columns of directions by which those that are bright are chosen.
const ROWS: usize = 256;
const COLUMNS: usize = 2 * ROWS;

/// Places along the side of a cell at which it is looked at.
const PLACES: usize = 6;

impl Surround<'_> {
    /// The middle of a cell when `within` is the middle.
    fn direction(cell: usize, within: Vec2) -> Vec3 {
        let (row, column) = (cell / COLUMNS, cell % COLUMNS);
        let (bottom, top) = (Self::height(row), Self::height(row + 1));
        let y = bottom + (top - bottom) * within.y;
        let (sin, cos) = ((column as f32 + within.x) / COLUMNS as f32 * TAU).sin_cos();
        let radius = (1.0 - y * y).max(0.0).sqrt();
        Vec3::new(radius * cos, y, radius * sin)
    }

    /// Rows are as high as their solid angle, so that all cells are as large.
    fn height(row: usize) -> f32 {
        1.0 - 2.0 * row as f32 / ROWS as f32
    }

    fn cell(direction: Vec3) -> usize {
        let row = ((1.0 - direction.y) * 0.5 * ROWS as f32) as usize;
        let turn = direction.z.atan2(direction.x) / TAU;
        let column = ((turn - turn.floor()) * COLUMNS as f32) as usize;
        row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)
    }

    /// How likely [`Emitters::sample_around`] takes a direction, by solid angle.
    fn density(&self, direction: Vec3) -> f32 {
        let cell = Self::cell(direction);
        let (row, column) = (cell / COLUMNS, cell % COLUMNS);
        self.rows.share(row) * self.columns[row].share(column) * (ROWS * COLUMNS) as f32 / (4.0 * PI)
    }
}

/// All that gives light.
pub(crate) struct Emitters<'a> {
    surfaces: &'a Surfaces,
    lamps: Vec<Lamp>,
    /// Triangles that shine, in ascending order, with the area of each.
    shining: Vec<(u32, f32)>,
    by_power: Choice,
    surround: Option<Surround<'a>>,
}

impl<'a> Emitters<'a> {
    /// Those of a scene with `surfaces`, and what is around it.
    pub fn new(scene: &Scene, surfaces: &'a Surfaces, around: Option<&'a dyn DistantLight>) -> Self {
        let moves = moving(scene);
        let lamps = scene.visible_nodes().into_iter().filter_map(|id| {
            let node = scene.node(id);
            // What moves is dynamic.
            if moves[id.0 as usize] {
                return None;
            }
            let light = scene.lights.get(node.light?).filter(|light| light.mode != LightMode::Dynamic)?;
            let matrix = node.world_from_object;
            let intensity = light.color_linear * light.intensity;
            let axis = matrix.transform_vector3(Vec3::NEG_Z).normalize_or(Vec3::NEG_Z);
            let lamp = Lamp {
                position: matrix.w_axis.truncate(),
                axis,
                intensity,
                kind: light.kind,
                range_m: light.range_m,
                radius_m: light.radius_m,
                casts_shadows: light.casts_shadows,
                is_held: light.mode == LightMode::Baked,
            };
            (intensity.is_finite() && intensity.max_element() > 0.0 && matrix.is_finite()).then_some(lamp)
        });
        let of_around = around.and_then(DistantLight::light).map(|light| Lamp {
            position: Vec3::ZERO,
            axis: -light.direction,
            intensity: light.irradiance,
            kind: LightKind::Directional,
            range_m: None,
            radius_m: light.half_angle_tan,
            casts_shadows: true,
            is_held: false,
        });
        let lamps = lamps.chain(of_around);
        let (shining, powers) = shining(surfaces);
        let surround = around.map(|around| {
            // A sun may be smaller than a cell.
            let place = |at: usize| Vec2::new((at % PLACES) as f32 + 0.5, (at / PLACES) as f32 + 0.5) / PLACES as f32;
            let of_cell = |cell: usize| {
                let places = (0..PLACES * PLACES).map(|at| Surround::direction(cell, place(at)));
                places.map(|direction| luminance(around.radiance(direction))).sum::<f32>()
            };
            let cells: Vec<f32> = (0..ROWS * COLUMNS).map(of_cell).collect();
            let rows = Choice::new(cells.chunks_exact(COLUMNS).map(|row| row.iter().sum()));
            let columns = cells.chunks_exact(COLUMNS).map(|row| Choice::new(row.iter().copied())).collect();
            Surround { around, rows, columns }
        });
        Self { surfaces, lamps: lamps.collect(), shining, by_power: Choice::new(powers.into_iter()), surround }
    }

    /// Irradiance from the scene's lights: of those that maps hold, and of the others. `point` is where on a light that
    /// has a size.
    pub fn of_lamps(&self, tracer: &Tracer, receiver: &Receiver, point: Vec2) -> [ArrivingLight; 2] {
        let start = receiver.start();
        let mut sums = [ArrivingLight::default(); 2];
        for lamp in &self.lamps {
            let (to_light, distance_m, intensity) = lamp.towards(receiver.position);
            let cosine = receiver.normal.dot(to_light);
            if intensity.max_element() <= 0.0 || !receiver.faces(to_light) {
                continue;
            }
            let to_edge = lamp.spot_towards(start, to_light, distance_m, point);
            let is_lit = !lamp.casts_shadows || tracer.is_free(start, to_edge.0, to_edge.1);
            if is_lit {
                sums[usize::from(!lamp.is_held)] += ArrivingLight::from(to_light, intensity * cosine);
            }
        }
        sums
    }

    /// Irradiance across its direction of each lamp that maps hold, where a place without a surface is; of a lamp that is
    /// nearer than `least_m` as if it were so far away.
    pub fn held_lamps_at(
        &self,
        tracer: &Tracer,
        (position, least_m): (Vec3, f32),
        point: Vec2,
        mut found: impl FnMut(Vec3, Vec3),
    ) {
        for lamp in self.lamps.iter().filter(|lamp| lamp.is_held) {
            let (to_light, distance_m, intensity) = lamp.towards(position);
            if intensity.max_element() <= 0.0 {
                continue;
            }
            let (direction, free_m) = lamp.spot_towards(position, to_light, distance_m, point);
            if !lamp.casts_shadows || tracer.is_free(position, direction, free_m) {
                let nearness = (distance_m / least_m).min(1.0);
                found(to_light, intensity * (nearness * nearness));
            }
        }
    }

    /// The light of one place of what shines that is chosen by chance, if it is seen from `start` and comes from a direction
    /// that `accepts` takes.
    pub fn choose_shining(
        &self,
        tracer: &Tracer,
        start: Vec3,
        accepts: impl Fn(Vec3) -> bool,
        point: Vec2,
    ) -> Option<LightSample> {
        if self.by_power.sums.is_empty() {
            return None;
        }
        let (index, within) = self.by_power.part(point.x);
        let (triangle, area) = self.shining[index];
        // Even over a triangle (Osada et al. 2002).
        let root = within.sqrt();
        let spot = Spot { triangle, shares: Vec2::new(root * (1.0 - point.y), root * point.y) };
        let (position, facet, _) = self.surfaces.geometry(spot);
        // Beside the other surface, so that rays end before it.
        let facing = if facet.dot(start - position) < 0.0 && self.is_two_sided(triangle) { -facet } else { facet };
        let to = beside(position, facing) - start;
        let distance_m = to.length();
        let direction = to / distance_m.max(1e-20);
        let leaving = -facing.dot(direction);
        let is_seen = leaving > 0.0 && accepts(direction) && self.surfaces.is_there(spot);
        if !is_seen || !tracer.is_clear(start, direction, distance_m) {
            return None;
        }
        let density = self.by_power.share(index) / area * distance_m * distance_m / leaving;
        Some(LightSample { direction, radiance: self.surfaces.shade(spot).emission, density })
    }

    /// The same of what is around the scene.
    pub fn choose_around(
        &self,
        tracer: &Tracer,
        start: Vec3,
        accepts: impl Fn(Vec3) -> bool,
        point: Vec2,
    ) -> Option<LightSample> {
        let surround = self.surround.as_ref().filter(|surround| !surround.rows.sums.is_empty())?;
        let (row, down) = surround.rows.part(point.x);
        let (column, across) = surround.columns[row].part(point.y);
        let direction = Surround::direction(row * COLUMNS + column, Vec2::new(across, down));
        if !accepts(direction) || !tracer.is_clear(start, direction, f32::MAX) {
            return None;
        }
        let density = surround.density(direction).max(1e-20);
        Some(LightSample { direction, radiance: surround.around.radiance(direction), density })
    }

    /// Irradiance from a place of what shines and from a direction of what is around the scene, each chosen by chance, as one
    /// of two samples: the other one is a ray as dense as its cosine, of which [`Self::met`] and [`Self::missed`] say what it
    /// brings.
    pub fn of_chosen(&self, tracer: &Tracer, receiver: &Receiver, points: [Vec2; 2]) -> ArrivingLight {
        let (start, accepts) = (receiver.start(), |direction| receiver.faces(direction));
        let [of_shining, of_around] = points;
        let of_shining = self.choose_shining(tracer, start, accepts, of_shining);
        let mut sum = ArrivingLight::default();
        for chosen in of_shining.into_iter().chain(self.choose_around(tracer, start, accepts, of_around)) {
            let cosine = receiver.normal.dot(chosen.direction);
            sum += ArrivingLight::from(chosen.direction, chosen.share(cosine_density(cosine)) * cosine);
        }
        sum
    }

    /// The radiance that a ray brings from what shines where it ends, as one of two samples, of which the other one is chosen
    /// by [`Self::choose_shining`]; `density` is that of the ray.
    pub fn met(&self, spot: Spot, emission: Vec3, distance_m: f32, leaving: f32, density: f32) -> Vec3 {
        let Ok(index) = self.shining.binary_search_by_key(&spot.triangle, |(triangle, _)| *triangle) else {
            return emission;
        };
        let other = self.by_power.share(index) / self.shining[index].1 * distance_m * distance_m / leaving.max(1e-6);
        emission * balance(density, other)
    }

    /// The same of a ray that meets nothing.
    pub fn missed(&self, direction: Vec3, density: f32) -> Vec3 {
        let Some(surround) = &self.surround else { return Vec3::ZERO };
        surround.around.radiance(direction) * balance(density, surround.density(direction))
    }

    /// The radiance of what is around the scene.
    pub fn radiance_around(&self, direction: Vec3) -> Vec3 {
        self.surround.as_ref().map_or(Vec3::ZERO, |surround| surround.around.radiance(direction))
    }

    /// Hashes all that light depends on, beside surfaces.
    pub fn hash_into(&self, hasher: &mut impl Hasher) {
        hasher.write(format!("{:?}", self.lamps).as_bytes());
        if let Some(surround) = &self.surround {
            hasher.write_u64(surround.around.key());
            for cell in 0..ROWS * COLUMNS {
                let radiance = surround.around.radiance(Surround::direction(cell, Vec2::splat(0.5)));
                hasher.write(bytemuck::bytes_of(&radiance));
            }
        }
    }

    /// Whether maps hold what comes straight from a lamp.
    pub fn holds_lamps(&self) -> bool {
        self.lamps.iter().any(|lamp| lamp.is_held)
    }

    /// Whether there is more than lamps.
    pub fn has_others(&self) -> bool {
        !self.shining.is_empty() || self.surround.is_some()
    }

    fn is_two_sided(&self, triangle: u32) -> bool {
        let (placed, _) = self.surfaces.triangle(triangle);
        self.surfaces.surfacing.surface(placed.material).double_sided
    }
}

impl Lamp {
    /// The direction and distance of its light, and its illuminance across that, as the frame has it
    /// (`KHR_lights_punctual`).
    fn towards(&self, position: Vec3) -> (Vec3, f32, Vec3) {
        if self.kind == LightKind::Directional {
            return (-self.axis, f32::MAX, self.intensity);
        }
        let to = self.position - position;
        let distance_m = to.length();
        let to_light = to / distance_m.max(1e-20);
        let window = self.range_m.map_or(1.0, |range| (1.0 - (distance_m / range).powi(4)).max(0.0));
        let mut intensity = self.intensity * (window / (distance_m * distance_m).max(1e-6));
        if let LightKind::Spot { inner_cone_rad, outer_cone_rad } = self.kind {
            let (inner, outer) = (inner_cone_rad.cos(), outer_cone_rad.cos());
            let along = -self.axis.dot(to_light);
            let cone = ((along - outer) / (inner - outer).max(1e-4)).clamp(0.0, 1.0);
            intensity *= cone * cone;
        }
        (to_light, distance_m, intensity)
    }

    /// The direction and distance of a place on it, for its shadow.
    fn spot_towards(&self, from: Vec3, to_light: Vec3, distance_m: f32, point: Vec2) -> (Vec3, f32) {
        let offset = even_direction(point) * self.radius_m;
        if self.kind == LightKind::Directional {
            return ((to_light + offset).normalize_or(to_light), f32::MAX);
        }
        let to = self.position + offset - from;
        // Short of the light, so that a bulb around it casts no shadow.
        let length = to.length();
        (to / length.max(1e-20), (length - self.radius_m).max(0.5 * distance_m))
    }
}

/// Triangles that shine with their areas, and how much light each gives.
fn shining(surfaces: &Surfaces) -> (Vec<(u32, f32)>, Vec<f32>) {
    // Places on a triangle whose mean stands for all of it.
    const SHARES: [Vec2; 7] = [
        Vec2::new(0.333, 0.333),
        Vec2::new(0.8, 0.1),
        Vec2::new(0.1, 0.8),
        Vec2::new(0.1, 0.1),
        Vec2::new(0.45, 0.1),
        Vec2::new(0.1, 0.45),
        Vec2::new(0.45, 0.45),
    ];
    // What the brightest place counts beside the mean: a small bright spot between those places is found, too.
    const BRIGHT_SHARE: f32 = 0.05;
    let (mut shining, mut powers) = (Vec::new(), Vec::new());
    for placed in &surfaces.placed {
        let surface = surfaces.surfacing.surface(placed.material);
        if !surface.shines {
            continue;
        }
        let count = placed.indices.len() as u32 / 3;
        for triangle in placed.first_triangle..placed.first_triangle + count {
            let [a, b, c] = surfaces.corners(triangle);
            let area = 0.5 * (b - a).cross(c - a).length();
            let emission = SHARES.map(|shares| {
                let spot = Spot { triangle, shares };
                if surfaces.is_there(spot) { surfaces.shade(spot).emission } else { Vec3::ZERO }
            });
            let [most, sum] =
                [emission.iter().fold(Vec3::ZERO, |most, of| most.max(*of)), emission.iter().sum::<Vec3>()];
            // Of what has dark and bright places the bright ones count, too.
            let power = area * (luminance(sum) / SHARES.len() as f32 + BRIGHT_SHARE * luminance(most));
            if power > 0.0 && power.is_finite() {
                shining.push((triangle, area));
                powers.push(power);
            }
        }
    }
    (shining, powers)
}
