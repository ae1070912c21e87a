//! Which lights touch which clusters.

use super::{ClusterSettings, LightTable};
use crate::view::{DepthRange, View};
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

/// The uniform `ClusterGrid` of `lights.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ClusterUniform {
    /// Tiles across, tiles down, slices, side of a tile in pixels.
    pub size: [u32; 4],
    /// Slice = log2(distance) · x + y.
    pub slice_from_log_distance: [f32; 2],
    /// The number of directional lights.
    pub directional_count: u32,
    /// The number of lights that are in no list.
    pub global_count: u32,
}

/// The lists of one view.
#[derive(Clone, Debug)]
pub struct ClusterLists {
    /// Shape of the grid.
    pub uniform: ClusterUniform,
    /// Offset and length of the list of every cluster.
    pub table: Vec<[u32; 2]>,
    /// Indices of lights, list after list.
    pub lights: Vec<u16>,
}

/// The tiles `first..end` of one row and slice that a light touches.
#[derive(Clone, Copy)]
struct Span {
    light: u16,
    row_of_clusters: u32,
    first: u16,
    end: u16,
}

/// The picture of the grid in view space.
struct Grid {
    tiles: [u32; 2],
    slices: u32,
    near_m: f32,
    log_step: f32,
    /// Tile coordinates = plane · scale + offset, where plane is x or −y in view space (at 1 m for perspective).
    tile_scale: Vec2,
    tile_offset: Vec2,
    orthographic: bool,
}

impl ClusterLists {
    /// One cluster with every light.
    pub fn everything(table: &LightTable, size: (u32, u32)) -> Self {
        let lights: Vec<u16> = (table.global_count..table.len()).map(|light| light as u16).collect();
        Self {
            uniform: ClusterUniform {
                size: [1, 1, 1, size.0.max(size.1)],
                slice_from_log_distance: [0.0; 2],
                directional_count: table.directional_count,
                global_count: table.global_count,
            },
            table: vec![[0, lights.len() as u32]],
            lights,
        }
    }

    /// Lists for tiles and slices fitted to `range`.
    pub fn build(
        table: &LightTable,
        view: &View,
        range: DepthRange,
        size: (u32, u32),
        settings: &ClusterSettings,
    ) -> Self {
        let grid = Grid::new(view, range, size, settings);
        let view_from_world = view.world_from_view.inverse();
        let mut spans = Vec::with_capacity(table.spheres.len() * 8);
        for (index, (position, radius)) in table.spheres.iter().enumerate() {
            let center = view_from_world.transform_point3(*position);
            grid.spans(center, *radius, (table.global_count as usize + index) as u16, &mut spans);
        }
        let row_len = grid.tiles[0] as usize;
        let cluster_count = row_len * grid.tiles[1] as usize * grid.slices as usize;
        let mut lists = vec![[0u32; 2]; cluster_count];
        for span in &spans {
            let row = span.row_of_clusters as usize * row_len;
            for cluster in &mut lists[row + span.first as usize..row + span.end as usize] {
                cluster[1] += 1;
            }
        }
        let mut offset = 0;
        for cluster in &mut lists {
            cluster[0] = offset;
            offset += cluster[1];
        }
        let mut lights = vec![0u16; offset as usize];
        for span in &spans {
            let row = span.row_of_clusters as usize * row_len;
            for cluster in &mut lists[row + span.first as usize..row + span.end as usize] {
                lights[cluster[0] as usize] = span.light;
                cluster[0] += 1;
            }
        }
        // The offsets were moved to the ends while filling.
        for cluster in &mut lists {
            cluster[0] -= cluster[1];
        }
        Self {
            uniform: ClusterUniform {
                size: [grid.tiles[0], grid.tiles[1], grid.slices, settings.tile_px],
                slice_from_log_distance: [1.0 / grid.log_step, -range.near_m.log2() / grid.log_step],
                directional_count: table.directional_count,
                global_count: table.global_count,
            },
            table: lists,
            lights,
        }
    }
}

impl Grid {
    fn new(view: &View, range: DepthRange, size: (u32, u32), settings: &ClusterSettings) -> Self {
        let size_px = Vec2::new(size.0 as f32, size.1 as f32);
        let tile_px = settings.tile_px as f32;
        let half_extent = view.half_extent(size_px.x / size_px.y);
        Self {
            tiles: [size.0.div_ceil(settings.tile_px), size.1.div_ceil(settings.tile_px)],
            slices: settings.slices,
            near_m: range.near_m,
            log_step: (range.far_m / range.near_m).log2().max(1e-4) / settings.slices as f32,
            tile_scale: 0.5 * size_px / (half_extent * tile_px),
            tile_offset: 0.5 * size_px / tile_px,
            orthographic: view.is_orthographic(),
        }
    }

    fn distance_of_slice(&self, slice: u32) -> f32 {
        self.near_m * (self.log_step * slice as f32).exp2()
    }

    /// Appends the spans of a sphere, `center` in view space.
    fn spans(&self, center: Vec3, radius: f32, light: u16, spans: &mut Vec<Span>) {
        // A hair more, because shader and CPU round differently, and jitter moves pixels by half a pixel.
        let radius = radius * 1.001;
        let distance = -center.z;
        if distance + radius <= 0.0 {
            return;
        }
        let slice_of = |d: f32| ((d / self.near_m).log2() / self.log_step).floor();
        let last_slice = self.slices as f32 - 1.0;
        let first = slice_of((distance - radius).max(self.near_m * 0.5)).clamp(0.0, last_slice) as u32;
        let last = slice_of((distance + radius).max(self.near_m * 0.5)).clamp(0.0, last_slice) as u32;
        for slice in first..=last {
            // The outermost slices take what lies beyond them.
            let d0 = if slice == 0 { 0.0 } else { self.distance_of_slice(slice) };
            let d1 = if slice + 1 == self.slices { f32::INFINITY } else { self.distance_of_slice(slice + 1) };
            self.slice_spans(center, radius, (d0, d1), slice, light, spans);
        }
    }

    fn slice_spans(
        &self,
        center: Vec3,
        radius: f32,
        (d0, d1): (f32, f32),
        slice: u32,
        light: u16,
        spans: &mut Vec<Span>,
    ) {
        let distance = -center.z;
        // The widest cross-section of the sphere within the slice, and the distances at which it lies.
        let nearest = distance.clamp(d0, d1) - distance;
        let disc = (radius * radius - nearest * nearest).max(0.0).sqrt();
        let (z0, z1) = ((distance - radius).max(d0), (distance + radius).min(d1));
        let (y0, y1) = self.tile_range(-center.y, disc, z0, z1, 1);
        for tile_y in y0..y1 {
            // The chord at the row's edge that is nearest to the middle of the disc.
            let gap = self.row_gap(tile_y, -center.y, z0, z1);
            if gap > disc {
                continue;
            }
            let chord = (disc * disc - gap * gap).max(0.0).sqrt();
            let (x0, x1) = self.tile_range(center.x, chord, z0, z1, 0);
            if x0 < x1 {
                spans.push(Span {
                    light,
                    row_of_clusters: slice * self.tiles[1] + tile_y,
                    first: x0 as u16,
                    end: x1 as u16,
                });
            }
        }
    }

    /// The tiles that the interval `middle` ± `half` covers between the distances `z0` and `z1`.
    fn tile_range(&self, middle: f32, half: f32, z0: f32, z1: f32, axis: usize) -> (u32, u32) {
        let (low, high) = (middle - half, middle + half);
        let (low, high) = if self.orthographic {
            (low, high)
        } else {
            // Seen from the eye an edge lies farthest out where it is nearest, or, if it lies on the other side of the
            // axis, where it is farthest.
            let near = z0.max(1e-6);
            (low / if low < 0.0 { near } else { z1 }, high / if high > 0.0 { near } else { z1 })
        };
        let tile = |plane: f32| plane * self.tile_scale[axis] + self.tile_offset[axis];
        // A twentieth of a tile covers the jitter of half a pixel and rounding.
        let first = (tile(low) - 0.08).floor().clamp(0.0, self.tiles[axis] as f32);
        let end = ((tile(high) + 0.08).floor() + 1.0).clamp(0.0, self.tiles[axis] as f32);
        (first as u32, end as u32)
    }

    /// The smallest distance in y between a row of tiles and `middle`, between the distances `z0` and `z1`.
    fn row_gap(&self, tile_y: u32, middle: f32, z0: f32, z1: f32) -> f32 {
        let plane = |tile: f32| (tile - self.tile_offset.y) / self.tile_scale.y;
        let (top, bottom) = (plane(tile_y as f32 - 0.08), plane(tile_y as f32 + 1.08));
        let (low, high) =
            if self.orthographic { (top, bottom) } else { ((top * z0).min(top * z1), (bottom * z0).max(bottom * z1)) };
        (low - middle).max(middle - high).max(0.0)
    }
}
