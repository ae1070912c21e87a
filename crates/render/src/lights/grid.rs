//! The grid of clusters in view space, and which of its tiles a light touches.

use super::reach::{Cone, Frustum, Reach};
use super::settings::ClusterSettings;
use crate::view::{DepthRange, View};
use glam::{Vec2, Vec3};

/// What the lists are for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Width by height of what is seen; that of `size`, but for the rounding of sizes.
    pub aspect: f32,
    /// How far the picture is moved, of all samples alike or of one through a point of a lens; jitter is none of it.
    pub shift_ndc: Vec2,
}

/// The tiles `first..end` of one row of clusters that a light touches. A row of clusters is a row of tiles in one
/// slice.
#[derive(Clone, Copy, Default)]
pub(crate) struct Span {
    /// The row of clusters.
    pub row: u32,
    pub light: u16,
    pub first: u16,
    pub end: u16,
}

/// The picture of the grid in view space.
pub(crate) struct Grid {
    /// Across and down.
    pub tiles: [u32; 2],
    /// The side of a tile.
    pub tile_px: u32,
    /// The distances at which slices begin, and the end of the last. The outermost take what lies beyond them.
    slice_edges_m: Vec<f32>,
    log2_near: f32,
    log_step: f32,
    /// Tile coordinates = plane · scale + offset, where plane is x or −y in view space (at 1 m for perspective).
    tile_scale: Vec2,
    tile_offset: Vec2,
    /// The planes above and below every row of tiles.
    row_planes: Vec<[f32; 2]>,
    orthographic: bool,
}

/// The part of a sphere that lies in one slice.
struct Section {
    /// The nearest and the farthest distance along the view axis, and what turns view space into planes there.
    z: [f32; 2],
    plane_scale: [f32; 2],
}

/// Room for rounding, which differs between the shader and the CPU: in tiles, and as a factor on radii.
const TILE_SLACK: f32 = 0.004;
const RADIUS_SLACK: f32 = 1.001;

impl Grid {
    /// Tiles and slices that `settings` ask for, fitted to `range`.
    pub fn new(view: &View, range: DepthRange, target: &Target, settings: &ClusterSettings) -> Self {
        let size_px = Vec2::new(target.size.0 as f32, target.size.1 as f32);
        // A camera may begin at its own eye; powers need a nearest distance above 0, and slice 0 takes what is nearer.
        let near_m = range.near_m.max(range.far_m * 1e-4).max(f32::MIN_POSITIVE);
        let (tile, slices) = (settings.tile_px.clamp(4, 16384), settings.slices.clamp(1, 256));
        let tile_px = tile as f32;
        let half_extent = view.half_extent(target.aspect);
        let log_step = (range.far_m / near_m).log2().max(1e-4) / slices as f32;
        let mut slice_edges_m: Vec<f32> = (0..=slices).map(|slice| near_m * (log_step * slice as f32).exp2()).collect();
        let tile_scale = 0.5 * size_px / (half_extent * tile_px);
        // Jitter moves a sample within its pixel, and a tile is whole pixels: one grid holds the lights of all samples.
        let tile_offset = 0.5 * size_px * (1.0 + target.shift_ndc * Vec2::new(1.0, -1.0)) / tile_px;
        let plane = |tile: f32| (tile - tile_offset.y) / tile_scale.y;
        let rows = target.size.1.div_ceil(tile);
        let row_planes =
            (0..rows).map(|row| [plane(row as f32 - TILE_SLACK), plane(row as f32 + 1.0 + TILE_SLACK)]).collect();
        slice_edges_m[0] = 0.0;
        slice_edges_m[slices as usize] = f32::INFINITY;
        Self {
            tiles: [target.size.0.div_ceil(tile), rows],
            tile_px: tile,
            slice_edges_m,
            log2_near: near_m.log2(),
            log_step,
            tile_scale,
            tile_offset,
            row_planes,
            orthographic: view.is_orthographic(),
        }
    }

    /// The number of slices.
    pub fn slices(&self) -> u32 {
        self.slice_edges_m.len() as u32 - 1
    }

    /// Slice = log2(distance) · x + y.
    pub fn slice_from_log_distance(&self) -> [f32; 2] {
        [1.0 / self.log_step, -self.log2_near / self.log_step]
    }

    /// The number of rows of clusters.
    pub fn row_count(&self) -> usize {
        self.tiles[1] as usize * self.slices() as usize
    }

    /// Appends the spans of a light, whose reach is in view space.
    pub fn spans(&self, reach: &Reach, light: u16, spans: &mut Vec<Span>) {
        let (center, radius) = (reach.center, reach.radius_m * RADIUS_SLACK);
        let distance = -center.z;
        if distance + radius <= 0.0 {
            return;
        }
        for slice in self.slice_of(distance - radius)..=self.slice_of(distance + radius) {
            let edges = (self.slice_edges_m[slice as usize], self.slice_edges_m[slice as usize + 1]);
            let frustum = match reach.cone {
                None => None,
                Some(cone) => match Self::in_slice(cone, edges) {
                    None => continue,
                    frustum => frustum,
                },
            };
            self.slice_spans(center, radius, frustum, (slice, edges), light, spans);
        }
    }

    /// Appends the spans of a box, of which the corners are in view space: bit by bit their numbers say on which side of
    /// each axis they lie.
    pub fn spans_of_box(&self, corners: &[Vec3; 8], number: u16, spans: &mut Vec<Span>) {
        let distances = corners.map(|corner| -corner.z);
        let [nearest, farthest] = [f32::min, f32::max].map(|pick| distances.into_iter().reduce(pick).unwrap_or(0.0));
        // NaN is no distance.
        if !(farthest > 0.0 && nearest.is_finite() && farthest.is_finite()) {
            return;
        }
        for slice in self.slice_of(nearest * (2.0 - RADIUS_SLACK))..=self.slice_of(farthest * RADIUS_SLACK) {
            let [low, high] = self.box_in_slice(corners, slice);
            if low.x > high.x {
                continue;
            }
            let tile = |plane: f32, axis: usize| plane * self.tile_scale[axis] + self.tile_offset[axis];
            let tiles = |axis: usize| {
                let first = ((tile(low[axis], axis) - TILE_SLACK) as u32).min(self.tiles[axis]);
                let end = ((tile(high[axis], axis) + TILE_SLACK + 1.0) as u32).min(self.tiles[axis]);
                (first, end)
            };
            let ((x0, x1), (y0, y1)) = (tiles(0), tiles(1));
            if x0 < x1 {
                let row = |tile_y| slice * self.tiles[1] + tile_y;
                let span = |tile_y| Span { row: row(tile_y), light: number, first: x0 as u16, end: x1 as u16 };
                spans.extend((y0..y1).map(span));
            }
        }
    }

    /// The least and the greatest x and −y, at 1 m for perspective, of the part of a box that lies in a slice.
    fn box_in_slice(&self, corners: &[Vec3; 8], slice: u32) -> [Vec2; 2] {
        let begin = self.slice_edges_m[slice as usize] * (2.0 - RADIUS_SLACK);
        let end = self.slice_edges_m[slice as usize + 1] * RADIUS_SLACK;
        let mut extent = [Vec2::INFINITY, Vec2::NEG_INFINITY];
        let mut add = |point: Vec3| {
            // What lies beside the eye may be anywhere in the picture.
            let scale = if self.orthographic { 1.0 } else { (-point.z).max(1e-6).recip() };
            let plane = Vec2::new(point.x, -point.y) * scale;
            extent = [extent[0].min(plane), extent[1].max(plane)];
        };
        for (at, corner) in corners.iter().enumerate() {
            if (begin..=end).contains(&-corner.z) {
                add(*corner);
            }
            for other in [1, 2, 4].map(|bit| at | bit).into_iter().filter(|other| *other != at) {
                let (from, to) = (*corner, corners[other]);
                for edge in [begin, end] {
                    let share = (edge + from.z) / (from.z - to.z);
                    if (0.0..=1.0).contains(&share) && edge.is_finite() {
                        add(from.lerp(to, share).with_z(-edge));
                    }
                }
            }
        }
        extent
    }

    /// The slice in which a distance lies.
    fn slice_of(&self, distance: f32) -> u32 {
        let slice = (distance.max(f32::MIN_POSITIVE).log2() - self.log2_near) / self.log_step;
        slice.floor().clamp(0.0, self.slices() as f32 - 1.0) as u32
    }

    fn slice_spans(
        &self,
        center: Vec3,
        radius: f32,
        frustum: Option<Frustum>,
        (slice, (d0, d1)): (u32, (f32, f32)),
        light: u16,
        spans: &mut Vec<Span>,
    ) {
        let distance = -center.z;
        // The widest cross-section of the sphere within the slice, and the distances at which it lies.
        let nearest = distance.clamp(d0, d1) - distance;
        let disc_m = (radius * radius - nearest * nearest).max(0.0).sqrt();
        let z = [(distance - radius).max(d0), (distance + radius).min(d1)];
        let plane_scale = if self.orthographic { [1.0; 2] } else { [z[0].max(1e-6).recip(), z[1].recip()] };
        let section = Section { z, plane_scale };
        let (y0, y1) = self.tile_range(-center.y, disc_m, &section, 1);
        for tile_y in y0..y1 {
            // The chord at the row's edge that is nearest to the middle of the disc.
            let gap = self.row_gap(tile_y, -center.y, &section);
            let chord_squared = disc_m * disc_m - gap * gap;
            if chord_squared < 0.0 {
                continue;
            }
            let (mut x0, mut x1) = self.tile_range(center.x, chord_squared.sqrt(), &section, 0);
            if let Some(frustum) = frustum {
                let (first, end) = self.in_row(frustum, tile_y, &section);
                (x0, x1) = (x0.max(first), x1.min(end));
            }
            if x0 < x1 {
                spans.push(Span { row: slice * self.tiles[1] + tile_y, light, first: x0 as u16, end: x1 as u16 });
            }
        }
    }

    /// The part of a cone that lies in a slice; none if nothing does.
    fn in_slice(cone: Cone, (d0, d1): (f32, f32)) -> Option<Frustum> {
        let part = cone.whole().clipped(Vec3::NEG_Z, d0)?;
        if d1.is_finite() { part.clipped(Vec3::Z, -d1) } else { Some(part) }
    }

    /// The tiles of a row that a part of a cone touches.
    fn in_row(&self, frustum: Frustum, tile_y: u32, section: &Section) -> (u32, u32) {
        let [top, bottom] = self.row_planes[tile_y as usize];
        // Between the planes −y = top and −y = bottom; with perspective they go through the eye: −y = top · −z.
        let part = if self.orthographic {
            frustum.clipped(Vec3::NEG_Y, top).and_then(|part| part.clipped(Vec3::Y, -bottom))
        } else {
            let part = frustum.clipped(Vec3::new(0.0, -1.0, top), 0.0);
            part.and_then(|part| part.clipped(Vec3::new(0.0, 1.0, -bottom), 0.0))
        };
        let Some(part) = part else { return (0, 0) };
        let [low, high] = part.extent(Vec3::X);
        self.tile_range(0.5 * (low + high), 0.5 * (high - low), section, 0)
    }

    /// The tiles that the interval `middle` ± `half` covers in the section.
    fn tile_range(&self, middle: f32, half: f32, section: &Section, axis: usize) -> (u32, u32) {
        let (low, high) = (middle - half, middle + half);
        // Seen from the eye an edge lies farthest out where it is nearest, or, if it lies on the other side of the
        // axis, where it is farthest.
        let [near, far] = section.plane_scale;
        let low = low * if low < 0.0 { near } else { far };
        let high = high * if high > 0.0 { near } else { far };
        let tile = |plane: f32| plane * self.tile_scale[axis] + self.tile_offset[axis];
        // Conversion to integers cuts off fractions, and what is negative or too large.
        let first = ((tile(low) - TILE_SLACK) as u32).min(self.tiles[axis]);
        let end = ((tile(high) + TILE_SLACK + 1.0) as u32).min(self.tiles[axis]);
        (first, end)
    }

    /// The smallest distance in y between a row of tiles and `middle` in the section.
    fn row_gap(&self, tile_y: u32, middle: f32, section: &Section) -> f32 {
        let [top, bottom] = self.row_planes[tile_y as usize];
        let [z0, z1] = section.z;
        let (low, high) =
            if self.orthographic { (top, bottom) } else { ((top * z0).min(top * z1), (bottom * z0).max(bottom * z1)) };
        (low - middle).max(middle - high).max(0.0)
    }
}
