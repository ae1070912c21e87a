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

/// The largest coefficient is so large in the texture, whose half floats end at 65,504.
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

/// Whether the light of grids has small sources apart, as [`PROBE_SOURCES`] says it.
pub(crate) fn have_sources(grids: &[&ProbeGrid]) -> bool {
    let has_source = |probe: &Probe| probe.light.source().irradiance != Vec3::ZERO;
    let has_sources = |grid: &&ProbeGrid| {
        let is_known = || grid.probes.iter().any(|probes| probes.iter().any(has_source));
        grid.basis == ProbeBasis::Harmonics && (grid.live.is_some() || is_known())
    };
    grids.iter().any(has_sources)
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

/// Irradiance of a probe divided by pi, but for its small source, as the square form of (x, y, z, 1) by the signs of a normal's
/// x, y and z, of which a bit each says that it is below 0: the number in a row and a column. With the signs in the form it is
/// one of the normal's absolute values (Ramamoorthi & Hanrahan 2001, section 3.2).
fn form(light: &ProbeLight, signs: usize, row: usize, column: usize) -> Vec3 {
    let sign = |axis: usize| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
    match light {
        ProbeLight::AmbientCube(cube) if row == column && row < 3 => cube.0[2 * row + (signs >> row & 1)],
        ProbeLight::AmbientCube(_) => Vec3::ZERO,
        ProbeLight::Harmonics(light, _) => {
            let [one, y, z, x, xy, yz, zz, xz, difference] = light.irradiance_polynomial();
            let unsigned = match (row.min(column), row.max(column)) {
                (0, 0) => difference,
                (1, 1) => -difference,
                (2, 2) => 3.0 * zz,
                (0, 1) => 0.5 * xy,
                (1, 2) => 0.5 * yz,
                (0, 2) => 0.5 * xz,
                (0, _) => 0.5 * x,
                (1, _) => 0.5 * y,
                (2, _) => 0.5 * z,
                _ => one - zz,
            };
            unsigned * sign(row) * sign(column)
        }
    }
}

/// By what the light of a grid is divided in the texture.
fn scale_of(probes: &[Probe]) -> f32 {
    let largest = |probe: &Probe| {
        let texels = (0..PROBE_HEIGHT - 1).flat_map(|y| (0..PROBE_WIDTH).map(move |x| (x, y)));
        texels.fold(0f32, |most, (x, y)| most.max(light_texel(probe, x, y).abs().max_element()))
    };
    let most = probes.iter().filter(|probe| probe.is_on).map(largest).fold(0f32, f32::max);
    if most > 0.0 && most.is_finite() { (most / LARGEST).max(f32::MIN_POSITIVE) } else { 1.0 }
}

/// Of blocks of 2 x 2 texels, seven beside each other: which rows and columns of [`form`] each has, and by which signs. Four
/// are of x and y by their signs, two of z and 1, and eight of both.
fn block_of(x: u32, y: u32) -> (usize, usize, usize) {
    let (block, row, column) = (x / 2 + PROBE_WIDTH / 2 * (y / 2), y % 2, x % 2);
    let (signs, row, column) = match block {
        0..4 => (block, row, column),
        4..6 => ((block - 4) << 2, 2 + row, 2 + column),
        _ => (block - 6, row, 2 + column),
    };
    (signs as usize, row as usize, column as usize)
}

/// A texel of a probe's light by its column and row, but for those of the last row; its small source's in the fourth component.
fn light_texel(probe: &Probe, x: u32, y: u32) -> Vec4 {
    let (signs, row, column) = block_of(x, y);
    let source = probe.light.source().irradiance / PI;
    let of_source = match (row < 2, column < 2) {
        (true, true) => source.x,
        (false, false) => source.y,
        _ => source.z,
    };
    form(&probe.light, signs, row, column).extend(of_source)
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
        for line in 0..PROBE_HEIGHT {
            let first = ((row * PROBE_HEIGHT + line) * width + column * PROBE_WIDTH) as usize;
            for (x, texel) in (0..PROBE_WIDTH).zip(&mut light[first..]) {
                *texel = half(match probe.is_on {
                    _ if line == PROBE_HEIGHT - 1 => place_texel(probe, x),
                    true => light_texel(probe, x, line) / scale,
                    false => Vec4::ZERO,
                });
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
        let PlacedGrid { place, scale, light } = *placed;
        let spacing_m = grid.spacing_m();
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
            inverse: spacing_m.recip().extend((2.0 * SIDE_SHARE * spacing_m.min_element()).recip()),
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
            [first, spacing, counts, corners, center, half_m, inverse]
        );
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
        let (width, height) = ProbeLayout::new(&[&grids[0]]).size;
        assert!(width.max(height) <= 1216, "{width} {height}");
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
