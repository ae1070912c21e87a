//! The volumes that enclose what lights reach: which are in view, and in which order they are drawn.

use super::reach::{Cone, Reach};
use super::reaches::RADIUS_SLACK;
use super::{LightListInputs, LightTable};
use crate::constants::{CASTING_POINTS, CASTING_SPOTS, QUIET_POINTS, QUIET_SPOTS};
use glam::{Vec2, Vec3, Vec4};
use std::ops::Range;

/// The shape of a volume. Their meshes are made by `record/volumes.rs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum VolumeShape {
    /// A sphere.
    Ball,
    /// What a cone cuts out of a sphere.
    Cone,
}

/// What is done with the pixels of volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VolumeStep {
    /// Those are shaded whose surface lies before the volume's back.
    Shade,
    /// Those whose surface lies inside of the volume are marked in their stencil.
    Mark,
    /// Those that are marked are shaded, and are so no longer.
    ShadeMarked,
}

/// One draw call.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeDraw {
    /// The mesh.
    pub shape: VolumeShape,
    /// What is done.
    pub step: VolumeStep,
    /// Of which classes the lights are, as shaders have them.
    pub classes: u32,
    /// Which volumes of the table.
    pub instances: Range<u32>,
}

/// So many sides a cone's mesh has.
pub const CONE_SIDES: u32 = 10;
/// A polygon of so many sides around a circle of radius 1 has its corners at this distance.
pub const CONE_CORNER: f32 = 1.051_462_2;
/// The corners of the mesh around a ball of radius 1 are at most so far away: those of an icosahedron whose faces are
/// cut in four (`record/volumes.rs`, whose test compares).
pub const BALL_CORNER: f32 = 1.072;

/// Cells of the picture, across and down, in which volumes are kept apart.
const CELLS: u32 = 64;

/// A volume in view.
pub struct Volume {
    light: u32,
    /// The class of the light.
    class: u32,
    shape: VolumeShape,
    /// In world space.
    reach: Reach,
    /// A part of it lies beyond the plane at which depth ends, where it would be cut open.
    is_cut: bool,
    /// The cells that it may cover: first and end, across and down.
    cells: [Range<u32>; 2],
}

impl Volume {
    /// Centre and radius, or tip and range; axis and tangent of the half angle; the light, and 1 if it is cut open.
    pub fn texels(&self) -> [[f32; 4]; 3] {
        let flags = [self.light as f32, if self.is_cut { 1.0 } else { 0.0 }, 0.0, 0.0];
        match self.reach.cone {
            Some(Cone { tip, axis, range_m, tangent }) => {
                [tip.extend(range_m * RADIUS_SLACK).to_array(), axis.extend(tangent).to_array(), flags]
            }
            None => [self.reach.center.extend(self.reach.radius_m * RADIUS_SLACK).to_array(), [0.0; 4], flags],
        }
    }
}

/// A sphere around the mesh of a volume.
fn bounds(reach: &Reach) -> (Vec3, f32) {
    let Some(Cone { tip, axis, range_m, tangent }) = reach.cone else {
        return (reach.center, reach.radius_m * RADIUS_SLACK * BALL_CORNER);
    };
    let cos = (1.0 + tangent * tangent).sqrt().recip();
    let half_tangent = tangent * cos / (1.0 + cos);
    // The corners of `volumes.wgsl`, seen from the middle of the axis.
    let corners = [Vec2::new(cos, tangent * cos * CONE_CORNER), Vec2::new(1.0, half_tangent * CONE_CORNER), Vec2::ZERO];
    let radius = corners.iter().map(|corner| (*corner - Vec2::new(0.5, 0.0)).length()).fold(0.0, f32::max);
    (tip + axis * (0.5 * range_m), radius * range_m * 1.01)
}

/// The volumes of the lights with a range that may reach what the view shows.
pub fn visible(table: &LightTable, of: &LightListInputs) -> Vec<Volume> {
    let view_from_world = of.view.world_from_view.inverse();
    let size_px = Vec2::new(of.target.size.0 as f32, of.target.size.1 as f32);
    // A sample lies within its pixel, so that half a pixel more is seen than the picture shows; a whole one is room.
    // What a lens shifts is seen beyond that.
    let half_extent = of.view.half_extent(of.target.aspect) * (1.0 + 2.0 / size_px + of.target.shift_ndc.abs());
    let seen = ViewExtent { half_extent, is_orthographic: of.view.is_orthographic() };
    let volumes = (table.global_count()..).zip(&table.reaches).filter_map(|(light, reach)| {
        let (center_world, radius_m) = bounds(reach);
        let cells = seen.cells(view_from_world.transform_point3(center_world), radius_m)?;
        let shape = if reach.cone.is_some() { VolumeShape::Cone } else { VolumeShape::Ball };
        let row = of.depth_row;
        let nearest_end = row.truncate().dot(center_world) + row.w - row.truncate().length() * radius_m;
        let is_cut = row != Vec4::ZERO && nearest_end < 1e-6;
        Some(Volume { light, class: table.class_of(light), shape, reach: *reach, is_cut, cells })
    });
    volumes.collect()
}

/// What a camera sees: half the extent of its picture, at 1 m if its rays are not parallel.
struct ViewExtent {
    half_extent: Vec2,
    is_orthographic: bool,
}

impl ViewExtent {
    /// The cells that a sphere in view space may cover; none if it is out of view.
    fn cells(&self, center: Vec3, radius_m: f32) -> Option<[Range<u32>; 2]> {
        let distance_m = -center.z;
        if distance_m + radius_m <= 0.0 {
            return None;
        }
        if !self.is_orthographic {
            // Outside of a plane through the eye and a side of the picture.
            let outside =
                |along: f32, half: f32| along.abs() - half * distance_m > radius_m * (1.0 + half * half).sqrt();
            if outside(center.x, self.half_extent.x) || outside(center.y, self.half_extent.y) {
                return None;
            }
        }
        let [near, far] = if self.is_orthographic {
            [1.0; 2]
        } else {
            [(distance_m - radius_m).max(1e-6), distance_m + radius_m].map(f32::recip)
        };
        let range = |middle: f32, half: f32| {
            let (low, high) = (middle - radius_m, middle + radius_m);
            // As seen from the eye an edge lies farthest out where it is nearest, or on the other side where it is
            // farthest.
            let low = low * if low < 0.0 { near } else { far };
            let high = high * if high > 0.0 { near } else { far };
            let cell = |plane: f32| (0.5 + 0.5 * plane / half) * CELLS as f32;
            // Conversion to integers cuts off what is negative or too large.
            let (first, end) = ((cell(low) as u32).min(CELLS), ((cell(high) + 1.0) as u32).min(CELLS));
            (first < end).then_some(first..end)
        };
        Some([range(center.x, self.half_extent.x)?, range(-center.y, self.half_extent.y)?])
    }
}

/// The texels of the table, and draws: of each shape one for every class of lights, which has a shader of its own.
pub fn all(volumes: &[Volume]) -> (Vec<[f32; 4]>, Vec<VolumeDraw>) {
    let mut writer = Writer::default();
    let volumes: Vec<&Volume> = volumes.iter().collect();
    writer.write(&volumes, &[VolumeStep::Shade]);
    (writer.texels, writer.draws)
}

/// The texels of the table, and draws by groups: no two volumes of one group cover the same cell, so that a group is
/// marked and shaded together, with one bit of the stencil. (A bit for each of eight groups would save no draw, but
/// take eight times as many pipelines.) What is cut open cannot be marked, and is shaded without.
pub fn grouped(volumes: &[Volume]) -> (Vec<[f32; 4]>, Vec<VolumeDraw>) {
    let mut groups: Vec<Group<'_>> = Vec::new();
    let (cut, whole): (Vec<&Volume>, Vec<&Volume>) = volumes.iter().partition(|volume| volume.is_cut);
    for volume in whole {
        match groups.iter_mut().find(|group| group.has_room(volume)) {
            Some(group) => group.add(volume),
            None => {
                let mut group = Group { taken: [0; CELLS as usize], volumes: Vec::new() };
                group.add(volume);
                groups.push(group);
            }
        }
    }
    let mut writer = Writer::default();
    writer.write(&cut, &[VolumeStep::Shade]);
    for group in &groups {
        writer.write(&group.volumes, &[VolumeStep::Mark, VolumeStep::ShadeMarked]);
    }
    (writer.texels, writer.draws)
}

/// The same draws where no light casts a shadow: classes that differ in that alone are drawn together.
pub fn without_shadows(draws: &[VolumeDraw]) -> Vec<VolumeDraw> {
    let mut merged: Vec<VolumeDraw> = Vec::with_capacity(draws.len());
    for draw in draws {
        let alike = [QUIET_POINTS | CASTING_POINTS, CASTING_SPOTS | QUIET_SPOTS];
        let classes = alike.into_iter().filter(|alike| alike & draw.classes != 0).sum();
        let draw = VolumeDraw { classes, ..draw.clone() };
        match merged.last_mut() {
            Some(last) if (last.shape, last.step, last.classes) == (draw.shape, draw.step, classes) => {
                last.instances.end = draw.instances.end;
            }
            _ => merged.push(draw),
        }
    }
    merged
}

/// Volumes that cover no cell twice: a bit for every cell, a number for every row.
struct Group<'v> {
    taken: [u64; CELLS as usize],
    volumes: Vec<&'v Volume>,
}

impl<'v> Group<'v> {
    fn mask(cells: &Range<u32>) -> u64 {
        (u64::MAX >> (CELLS - (cells.end - cells.start))) << cells.start
    }

    fn has_room(&self, volume: &Volume) -> bool {
        let [across, down] = &volume.cells;
        let mask = Self::mask(across);
        self.taken[down.start as usize..down.end as usize].iter().all(|row| row & mask == 0)
    }

    fn add(&mut self, volume: &'v Volume) {
        let [across, down] = &volume.cells;
        let mask = Self::mask(across);
        self.taken[down.start as usize..down.end as usize].iter_mut().for_each(|row| *row |= mask);
        self.volumes.push(volume);
    }
}

#[derive(Default)]
struct Writer {
    texels: Vec<[f32; 4]>,
    draws: Vec<VolumeDraw>,
}

impl Writer {
    /// Appends `volumes`, shape by shape and in each by class, and draws of them for one step after the other. What is
    /// marked is the same for all classes.
    fn write(&mut self, volumes: &[&Volume], steps: &[VolumeStep]) {
        let first = self.texels.len() as u32 / 3;
        let mut sorted = volumes.to_vec();
        sorted.sort_by_key(|volume| (volume.shape, volume.class));
        self.texels.extend(sorted.iter().flat_map(|volume| volume.texels()));
        for step in steps {
            let is_one_draw =
                |a: &&Volume, b: &&Volume| a.shape == b.shape && (a.class == b.class || *step == VolumeStep::Mark);
            let mut end = first;
            for part in sorted.chunk_by(is_one_draw) {
                let instances = end..end + part.len() as u32;
                end = instances.end;
                let classes = part.iter().fold(0, |classes, volume| classes | volume.class);
                let Some(shape) = part.first().map(|volume| volume.shape) else { continue };
                self.draws.push(VolumeDraw { shape, step: *step, classes, instances });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn every_class_has_a_draw_and_those_without_shadows_fewer() {
        let reach = Reach::of_light(manypass_scene::LightKind::Point, Vec3::ZERO, Vec3::NEG_Z, 1.0);
        let of = |(light, class, shape)| Volume { light, class, shape, reach, is_cut: false, cells: [0..1, 0..1] };
        let (ball, cone) = (VolumeShape::Ball, VolumeShape::Cone);
        let volumes = [
            (0, QUIET_POINTS, ball),
            (1, CASTING_POINTS, ball),
            (2, CASTING_SPOTS, ball),
            (3, CASTING_SPOTS, cone),
            (4, QUIET_SPOTS, ball),
            (5, QUIET_SPOTS, cone),
        ]
        .map(of);
        let (texels, draws) = all(&volumes);
        let drawn: Vec<f32> = texels.chunks_exact(3).map(|volume| volume[2][0]).collect();
        assert_eq!(drawn, [0.0, 1.0, 2.0, 4.0, 3.0, 5.0]);
        let of_draws = |draws: &[VolumeDraw]| -> Vec<(u32, Range<u32>)> {
            draws.iter().map(|draw| (draw.classes, draw.instances.clone())).collect()
        };
        let classes = [QUIET_POINTS, CASTING_POINTS, CASTING_SPOTS, QUIET_SPOTS, CASTING_SPOTS, QUIET_SPOTS];
        assert_eq!(of_draws(&draws), classes.into_iter().zip((0..6).map(|i| i..i + 1)).collect::<Vec<_>>());
        let (points, spots) = (QUIET_POINTS | CASTING_POINTS, QUIET_SPOTS | CASTING_SPOTS);
        assert_eq!(of_draws(&without_shadows(&draws)), [(points, 0..2), (spots, 2..4), (spots, 4..6)]);
        // Each covers the others' cell, so that each is marked and shaded for itself.
        let steps: Vec<VolumeStep> = grouped(&volumes).1.iter().map(|draw| draw.step).collect();
        assert_eq!(steps, [VolumeStep::Mark, VolumeStep::ShadeMarked].repeat(6));
    }

    #[test]
    fn a_polygon_around_a_circle_has_its_corners_there() {
        assert!((CONE_CORNER * (PI / CONE_SIDES as f32).cos() - 1.0).abs() < 1e-6);
    }
}
