//! Grids of probes: where their texels lie, what they hold, and what shaders know of them (`probes.wgsl`).

mod read;

pub(crate) use read::read_probe;

use crate::constants::{PROBE_DISTANCE_SIDE, PROBE_HEIGHT, PROBE_WIDTH};
use crate::surroundings::fading_box;
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use half::f16;
use manypass_scene::Scene;
use manypass_scene::probes::{
    DISTANCE_SIDE, GRIDS_MAX, Harmonics, Probe, ProbeBasis, ProbeGrid, ProbeLight, SmallSource,
};
use std::f32::consts::PI;

const _: () = assert!(DISTANCE_SIDE == PROBE_DISTANCE_SIDE as usize);
const _: () = assert!(TILE_SIDE == PROBE_WIDTH);

/// The side of the map of a probe's distances with its border, in texels.
pub(crate) const TILE_SIDE: u32 = PROBE_DISTANCE_SIDE + 2;

/// The constant of pipelines that says how many grids a scene has.
pub(crate) const PROBE_GRIDS: &str = "probe_grids";
/// And the one that says that the light of some has small sources apart.
pub(crate) const PROBE_SOURCES: &str = "probe_sources";
/// And the one that says how exactly the device filters ([`crate::gpu::Capabilities::filters_exactly`]).
pub(crate) const FILTERS_EXACTLY: &str = "filters_exactly";

/// The largest number is so large in the texture, where half floats end at 65,504.
const LARGEST: f32 = 32_768.0;

/// Distances and offsets are so large at the most, in metres.
pub(crate) const DISTANCE_MAX_M: f32 = 60_000.0;

/// As `ProbeGrid` of `probes.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ProbesUniform {
    /// The place of the first probe; one divided by how many metres the box fades over.
    pub first: Vec4,
    /// How far probes are apart; what their light is multiplied by.
    pub spacing: Vec4,
    /// How many there are along each axis; layers along Z that lie beside each other in the texture.
    pub counts: Vec4,
    /// The corners of the light and of the distances in texels.
    pub corners: Vec4,
    /// The middle of the box; zero.
    pub center: Vec4,
    /// Half the box's extent; how far from a surface its light is looked up, in metres.
    pub half_m: Vec4,
    /// One divided by how far probes are apart; one divided by how far from one side of a surface's plane the other one is.
    pub inverse: Vec4,
    /// How far its probes were moved along each axis at the most; how far from a surface's plane a probe is wholly on one side.
    pub moved_m: Vec4,
}

/// As many uniforms as shaders have room for.
pub(crate) type ProbesUniforms = [ProbesUniform; GRIDS_MAX];

/// The grids of a scene that have light, or find it in frames where these may.
pub(crate) fn known(scene: &Scene, is_captured: bool) -> Vec<&ProbeGrid> {
    let has_light = |grid: &&ProbeGrid| match &grid.probes {
        Some(probes) => probes.len() == grid.count(),
        None => is_captured && grid.live.is_some(),
    };
    scene.probes.iter().filter(has_light).take(GRIDS_MAX).collect()
}

/// What a grid knows before frames have found anything: no light, and nothing nearby.
pub(crate) fn unlit(grid: &ProbeGrid) -> Vec<Probe> {
    let far_m = grid.distance_max_m();
    let distances = [Vec2::new(far_m, far_m * far_m); DISTANCE_SIDE * DISTANCE_SIDE];
    let light = ProbeLight::new(&Harmonics::default(), SmallSource::default(), grid.basis);
    vec![Probe { is_on: true, light, distances, ..Probe::default() }; grid.count()]
}

/// What is wrong with the grids of a scene.
pub(crate) fn faults(scene: &Scene) -> Vec<String> {
    let has_none = |grid: &&ProbeGrid| grid.probes.is_none() && grid.live.is_none();
    let said = |grid: &ProbeGrid| {
        format!("the probes `{}` have no light yet: `manypass bake SCENE -o OUT.glb --what probes` finds it", grid.name)
    };
    scene.probes.iter().filter(has_none).map(said).collect()
}

/// Whether the light of a grid has small sources apart, as [`PROBE_SOURCES`] says it.
pub(crate) fn has_sources(grid: &ProbeGrid) -> bool {
    let has_source = |probe: &Probe| probe.is_on && probe.light.source().irradiance != Vec3::ZERO;
    let is_known = || grid.probes.iter().any(|probes| probes.iter().any(has_source));
    grid.basis == ProbeBasis::Harmonics && (grid.live.is_some() || is_known())
}

/// How far probes of a grid that are on were moved along each axis at the most, in metres.
pub(crate) fn most_moved_m(grid: &ProbeGrid) -> Vec3 {
    let on = grid.probes.iter().flat_map(|probes| probes.iter()).filter(|probe| probe.is_on);
    on.fold(Vec3::ZERO, |most, probe| most.max(probe.offset_m.abs())).min(Vec3::splat(DISTANCE_MAX_M))
}

/// Where the texels of a grid lie within those of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GridPlace {
    /// Layers along Z that lie beside each other.
    pub columns: u32,
    /// The corners of the light, which live grids have twice, and of the distances.
    pub light: [[u32; 2]; 2],
    pub distances: [u32; 2],
}

impl GridPlace {
    /// Where the texels of a probe begin within those of all: of its light, whichever of the two, and of its distances.
    pub fn of_probe(&self, grid: &ProbeGrid, index: usize, light: usize) -> [[u32; 2]; 2] {
        let (column, row) = self.cell(grid.counts, index as u32);
        let [light, distances] = [self.light[light.min(1)], self.distances];
        [
            [light[0] + column * PROBE_WIDTH, light[1] + row * PROBE_HEIGHT],
            [distances[0] + column * TILE_SIDE, distances[1] + row * TILE_SIDE],
        ]
    }

    /// The column and row of a probe among those of its grid.
    fn cell(&self, [x, y, _]: [u32; 3], index: u32) -> (u32, u32) {
        let (at_x, at_y, at_z) = (index % x, index / x % y, index / (x * y));
        (at_x + at_z % self.columns * x, at_y + at_z / self.columns * y)
    }
}

/// Where the texels of grids lie: one below the other, of each its distances above its light.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ProbeLayout {
    /// Width and height of all.
    pub size: (u32, u32),
    pub places: Vec<GridPlace>,
}

/// Width of all, and the heights of distances and light, of a grid with so many layers beside each other.
fn extent([x, y, z]: [u32; 3], columns: u32) -> (u32, u32, u32) {
    let rows = z.div_ceil(columns);
    (x * columns * TILE_SIDE, y * rows * TILE_SIDE, y * rows * PROBE_HEIGHT)
}

impl ProbeLayout {
    /// Of grids.
    pub fn new(grids: &[&ProbeGrid]) -> Self {
        let mut layout = Self::default();
        for grid in grids {
            let lights = if grid.live.is_some() { 2 } else { 1 };
            let side = |columns: &u32| {
                let (width, of_distances, of_light) = extent(grid.counts, *columns);
                width.max(of_distances + lights * of_light)
            };
            let columns = (1..=grid.counts[2]).min_by_key(side).unwrap_or(1);
            let (width, of_distances, of_light) = extent(grid.counts, columns);
            let top = layout.size.1;
            let first = top + of_distances;
            let light = [[0, first], [0, first + (lights - 1) * of_light]];
            layout.places.push(GridPlace { columns, light, distances: [0, top] });
            layout.size = (layout.size.0.max(width), first + lights * of_light);
        }
        layout
    }
}

/// A grid of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedGrid {
    pub place: GridPlace,
    /// What its light is multiplied by.
    pub scale: f32,
    /// Which of the two lights of a live grid frames read.
    pub light: usize,
    /// See [`has_sources`].
    pub has_sources: bool,
    /// See [`most_moved_m`].
    pub moved_m: Vec3,
}

/// The texels of a grid, as rectangles of half floats.
#[derive(Debug)]
pub(crate) struct GridTexels {
    /// Of the light: width, height, texels.
    pub light: (u32, u32, Vec<[f16; 4]>),
    /// Of the distances.
    pub distances: (u32, u32, Vec<[f16; 4]>),
    /// What light is divided by.
    pub scale: f32,
}

/// Irradiance of a probe divided by pi, but for its small source, as a square form of (x, y, z, 1), where x, y and z are the
/// absolute values of a normal's and their signs are in the form (Ramamoorthi & Hanrahan 2001, section 3.2).
enum Form {
    /// Rows and columns for a normal without signs.
    Polynomial([[Vec3; 4]; 4]),
    Cube([Vec3; 6]),
}

impl Form {
    fn new(light: &ProbeLight) -> Self {
        match light {
            ProbeLight::AmbientCube(cube) => Self::Cube(cube.0),
            ProbeLight::Harmonics(light, _) => {
                let [one, y, z, x, xy, yz, zz, xz, difference] = light.irradiance_polynomial();
                let [x, y, z, xy, yz, xz] = [x, y, z, xy, yz, xz].map(|value| 0.5 * value);
                Self::Polynomial([
                    [difference, xy, xz, x],
                    [xy, -difference, yz, y],
                    [xz, yz, 3.0 * zz, z],
                    [x, y, z, one - zz],
                ])
            }
        }
    }

    /// The number in a row and a column. Of `signs` a bit each says that a normal's x, y and z are below 0.
    fn at(&self, signs: usize, row: usize, column: usize) -> Vec3 {
        let is_below = |axis: usize| signs >> axis & 1;
        match self {
            Self::Polynomial(rows) if is_below(row) != is_below(column) => -rows[row][column],
            Self::Polynomial(rows) => rows[row][column],
            Self::Cube(colors) if row == column && row < 3 => colors[2 * row + is_below(row)],
            Self::Cube(_) => Vec3::ZERO,
        }
    }
}

/// Of blocks of 2 x 2 texels: which rows and columns of a [`Form`] each has, and by which signs. Four are of x and y by their
/// signs, two of z and 1, and eight of both.
fn block_of(x: u32, y: u32) -> (usize, usize, usize) {
    let (block, row, column) = (x / 2 + PROBE_WIDTH / 2 * (y / 2), y % 2, x % 2);
    let (signs, row, column) = match block {
        0..4 => (block, row, column),
        4..6 => ((block - 4) << 2, 2 + row, 2 + column),
        _ => (block - 6, row, 2 + column),
    };
    (signs as usize, row as usize, column as usize)
}

/// The texels of a probe's light in rows, but for the last one; its small source's in the fourth component.
fn light_texels(light: &ProbeLight) -> impl Iterator<Item = Vec4> + use<> {
    let (form, source) = (Form::new(light), light.source().irradiance / PI);
    let places = (0..PROBE_HEIGHT - 1).flat_map(|y| (0..PROBE_WIDTH).map(move |x| (x, y)));
    places.map(move |(x, y)| {
        let (signs, row, column) = block_of(x, y);
        let of_source = match (row < 2, column < 2) {
            (true, true) => source.x,
            (false, false) => source.y,
            _ => source.z,
        };
        form.at(signs, row, column).extend(of_source)
    })
}

/// By what the light of a grid is divided in the texture.
fn scale_of(probes: &[Probe]) -> f32 {
    let largest =
        |probe: &Probe| light_texels(&probe.light).fold(0f32, |most, texel| most.max(texel.abs().max_element()));
    let most = probes.iter().filter(|probe| probe.is_on).map(largest).fold(0f32, f32::max);
    if most > 0.0 && most.is_finite() { (most / LARGEST).max(f32::MIN_POSITIVE) } else { 1.0 }
}

/// A texel of the last row: how far a probe was moved, and whether it is on; where its small source is, and how wide.
fn place_texel(probe: &Probe, x: u32) -> Vec4 {
    let source = probe.light.source();
    let offset_m = probe.offset_m.clamp(Vec3::splat(-DISTANCE_MAX_M), Vec3::splat(DISTANCE_MAX_M));
    match x {
        0 => offset_m.extend(if probe.is_on { 1.0 } else { 0.0 }),
        1 if source.irradiance != Vec3::ZERO => source.direction.extend(source.spread),
        _ => Vec4::ZERO,
    }
}

/// The texel of a map of distances that one of its border repeats, or itself: beyond an edge the map goes on at the other
/// end of the same edge.
fn within(mut x: i32, mut y: i32) -> usize {
    let last = PROBE_DISTANCE_SIDE as i32 - 1;
    if !(0..=last).contains(&x) {
        (x, y) = (x.clamp(0, last), last - y);
    }
    if !(0..=last).contains(&y) {
        (x, y) = (last - x, y.clamp(0, last));
    }
    (y * PROBE_DISTANCE_SIDE as i32 + x) as usize
}

/// The mean of distances and its standard deviation.
fn spread(distance: Vec2) -> [f32; 2] {
    let deviation = (distance.y - distance.x * distance.x).max(0.0).sqrt();
    [distance.x, deviation].map(|value| value.min(DISTANCE_MAX_M))
}

/// The texels of a grid that has light, divided by `scale`, or as probes need it.
pub(crate) fn grid_texels(grid: &ProbeGrid, place: &GridPlace, probes: &[Probe], scale: Option<f32>) -> GridTexels {
    let scale = scale.unwrap_or_else(|| scale_of(probes));
    let (_, of_distances, of_light) = extent(grid.counts, place.columns);
    let [x, _, z] = grid.counts;
    let across = x * place.columns.min(z);
    let width = across * TILE_SIDE;
    let mut light = vec![[f16::ZERO; 4]; (width * of_light) as usize];
    let mut distances = vec![[f16::ZERO; 4]; (width * of_distances) as usize];
    let half = |value: Vec4| value.to_array().map(f16::from_f32);
    for (index, probe) in probes.iter().enumerate() {
        let (column, row) = place.cell(grid.counts, index as u32);
        let of_light = light_texels(&probe.light).map(|texel| if probe.is_on { texel / scale } else { Vec4::ZERO });
        let mut texels = of_light.chain((0..PROBE_WIDTH).map(|x| place_texel(probe, x)));
        for line in 0..PROBE_HEIGHT {
            let first = ((row * PROBE_HEIGHT + line) * width + column * PROBE_WIDTH) as usize;
            for (texel, value) in light[first..].iter_mut().zip(texels.by_ref().take(PROBE_WIDTH as usize)) {
                *texel = half(value);
            }
        }
        for line in 0..TILE_SIDE {
            let first = ((row * TILE_SIDE + line) * width + column * TILE_SIDE) as usize;
            for (at, texel) in distances[first..].iter_mut().take(TILE_SIDE as usize).enumerate() {
                let [mean, deviation] = spread(probe.distances[within(at as i32 - 1, line as i32 - 1)]);
                *texel = half(Vec4::new(mean, deviation, 0.0, 0.0));
            }
        }
    }
    GridTexels { light: (width, of_light, light), distances: (width, of_distances, distances), scale }
}

impl ProbesUniform {
    /// Of a grid whose texels lie behind a corner of the texture.
    pub(crate) fn new(grid: &ProbeGrid, [x, y]: [u32; 2], placed: &PlacedGrid) -> Self {
        let PlacedGrid { place, scale, light, moved_m, .. } = *placed;
        let spacing_m = grid.spacing_m();
        let side_m = SIDE_SHARE * spacing_m.min_element();
        let (half_m, per_fade_m) = fading_box(&grid.region, grid.fade_m);
        let corner = |[a, b]: [u32; 2]| Vec2::new((x + a) as f32, (y + b) as f32);
        let (of_light, of_distances) = (corner(place.light[light.min(1)]), corner(place.distances));
        let counts = Vec3::from(grid.counts.map(|count| count as f32));
        Self {
            first: grid.place(0).extend(per_fade_m),
            spacing: spacing_m.extend(scale),
            counts: counts.extend(place.columns as f32),
            corners: Vec4::new(of_light.x, of_light.y, of_distances.x, of_distances.y),
            center: grid.region.center_world.extend(0.0),
            half_m: half_m.extend(BIAS_SHARE * spacing_m.min_element()),
            inverse: spacing_m.recip().extend((2.0 * side_m).recip()),
            moved_m: moved_m.extend(side_m),
        }
    }
}

/// Surfaces are seen from so far before them, as a share of the least distance between probes: light of what lies beside
/// them counts as theirs within that.
const BIAS_SHARE: f32 = 0.2;

/// So far from a surface's plane a probe is on one side of it, as a share of the least distance between probes.
const SIDE_SHARE: f32 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octahedral::direction_from_octahedral;
    use crate::shader::layout::assert_same_layout;
    use manypass_scene::probes::LiveProbes;
    use manypass_scene::surroundings::Region;
    use std::sync::Arc;

    fn grid(counts: [u32; 3]) -> ProbeGrid {
        let region = Region { center_world: Vec3::ZERO, half_m: Vec3::ONE };
        ProbeGrid::new("probes", region, counts).unwrap()
    }

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "forward",
            "ProbeGrid",
            ProbesUniform,
            [first, spacing, counts, corners, center, half_m, inverse, moved_m]
        );
    }

    #[test]
    fn the_farthest_of_those_that_are_on_says_how_far_probes_were_moved() {
        let moved = |offset_m: Vec3, is_on: bool| Probe { offset_m, is_on, ..Probe::default() };
        let mut of = grid([2, 2, 1]);
        assert_eq!(most_moved_m(&of), Vec3::ZERO);
        of.probes = Some(Arc::new(vec![
            moved(Vec3::new(0.1, -0.3, 0.0), true),
            moved(Vec3::new(-0.2, 0.1, 0.0), true),
            moved(Vec3::splat(9.0), false),
            moved(Vec3::ZERO, true),
        ]));
        assert_eq!(most_moved_m(&of), Vec3::new(0.2, 0.3, 0.0));
    }

    #[test]
    fn texels_of_all_grids_lie_apart_and_are_about_square() {
        let live = ProbeGrid { live: Some(LiveProbes::default()), ..grid([5, 3, 7]) };
        let grids = [grid([16, 16, 16]), grid([128, 1, 128]), grid([1, 128, 128]), live];
        let layout = ProbeLayout::new(&grids.each_ref());
        let mut bottom = 0;
        for (grid, place) in grids.iter().zip(&layout.places) {
            let probes = vec![Probe::default(); grid.count()];
            let texels = grid_texels(grid, place, &probes, None);
            assert_eq!(place.distances, [0, bottom]);
            assert_eq!(place.light[0], [0, bottom + texels.distances.1]);
            let lights = if grid.live.is_some() { 2 } else { 1 };
            bottom = place.light[1][1] + texels.light.1;
            assert_eq!(bottom, place.light[0][1] + lights * texels.light.1);
            for (width, height, texels) in [texels.light, texels.distances] {
                assert!(width <= layout.size.0 && width <= 2048 && height <= 2048, "{width} {height}");
                assert_eq!(texels.len(), (width * height) as usize);
            }
        }
        assert_eq!(bottom, layout.size.1);
        // As large as a grid may be, on what every device has.
        let (width, height) = ProbeLayout::new(&[&grid([25, 26, 25])]).size;
        assert!(width.max(height) <= 4096, "{width} {height}");
        let (width, height) = ProbeLayout::new(&[&grids[0]]).size;
        assert!(width.max(height) <= 1216, "{width} {height}");
    }

    /// The twin of `light_lookup` and `probe_light_at` of `probes.wgsl`.
    fn looked_up(texels: &[Vec4], direction: Vec3) -> Vec4 {
        let (v, below) = (direction.abs(), direction.to_array().map(|value| u32::from(value < 0.0)));
        let (sides, height) = (v.x + v.y, v.z + 1.0);
        let between = Vec2::new(v.y / sides.max(1e-6), height.recip());
        let quarter = below[0] + 2 * below[1];
        let within = |block: u32, across: f32, down: f32| {
            let beside = PROBE_WIDTH / 2;
            let (x, y) = (2 * (block % beside), 2 * (block / beside));
            let texel = |a: u32, b: u32| texels[((y + b) * PROBE_WIDTH + x + a) as usize];
            texel(0, 0).lerp(texel(1, 0), across).lerp(texel(0, 1).lerp(texel(1, 1), across), down)
        };
        within(quarter, between.x, between.x) * sides * sides
            + within(4 + below[2], between.y, between.y) * height * height
            + within(6 + quarter + 4 * below[2], between.y, between.x) * (2.0 * sides * height)
    }

    #[test]
    fn lookups_find_the_light_of_all_normals() {
        let mut light = Harmonics::default();
        light.add(Vec3::new(0.6, -0.48, 0.64), Vec3::new(3.0, 2.0, 1.0));
        light.add(Vec3::new(-0.36, 0.48, -0.8), Vec3::new(0.5, 1.0, 4.0));
        for basis in [ProbeBasis::Harmonics, ProbeBasis::AmbientCube] {
            let light = ProbeLight::new(&light, SmallSource::default(), basis);
            let texels: Vec<Vec4> = light_texels(&light).collect();
            for sides in 0..27 {
                let of = |axis: u32| (sides / 3i32.pow(axis) % 3 - 1) as f32 * [1.0, 0.7, 0.4][axis as usize];
                let normal = Vec3::new(of(0), of(1), of(2)).normalize_or_zero();
                if normal == Vec3::ZERO {
                    continue;
                }
                let (found, expected) =
                    (looked_up(&texels, normal).truncate().max(Vec3::ZERO), light.irradiance(normal));
                assert!((found - expected).abs().max_element() < 1e-4, "{basis:?} {normal}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn borders_repeat_what_lies_beyond() {
        let direction = |x: i32, y: i32| {
            let place = |at: i32| (2 * at + 1) as f32 / PROBE_DISTANCE_SIDE as f32 - 1.0;
            direction_from_octahedral(Vec2::new(place(x), place(y)))
        };
        let last = PROBE_DISTANCE_SIDE as i32 - 1;
        for at in 0..=last {
            for (x, y, beside) in
                [(-1, at, (0, at)), (last + 1, at, (last, at)), (at, -1, (at, 0)), (at, last + 1, (at, last))]
            {
                let found = within(x, y) as i32;
                let (found, beside) =
                    (direction(found % (last + 1), found / (last + 1)), direction(beside.0, beside.1));
                assert!(found.dot(beside) > 0.85, "{x} {y}");
            }
        }
        assert_eq!(
            (within(-1, -1), within(3, 2)),
            ((last * (last + 1) + last) as usize, (2 * (last + 1) + 3) as usize)
        );
    }
}
