//! Which decals touch which clusters of a view.

use super::clusters::{ListLimits, lists_of_spans};
use super::grid::{Grid, Target};
use super::record::ListRecord;
use super::settings::ClusterSettings;
use crate::decals::{DecalTable, corners_of_box};
use crate::view::{DepthRange, View};
use glam::{Mat4, Vec3};
use std::sync::Arc;

/// The shape of the grid of clusters, as `ClusterGrid` of `light_table.wgsl` has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DecalGrid {
    /// Tiles across, tiles down, slices, side of a tile in pixels.
    pub size: [u32; 4],
    /// Slice = log2(distance) · x + y; 0, 0.
    pub slices: [f32; 4],
}

/// The lists of one view.
#[derive(Clone, Debug, Default)]
pub(crate) struct DecalLists {
    /// The shape of the grid.
    pub grid: DecalGrid,
    /// A record of the list of every cluster.
    pub records: Vec<ListRecord>,
    /// What they are of.
    pub table: Arc<DecalTable>,
    /// How many numbers of decals all lists have.
    pub entry_count: u64,
}

impl DecalLists {
    /// Lists for tiles and slices fitted to `range`, which become larger where there would be more than `limits` has room
    /// for; and numbers of decals, list after list, in the order in which they lie over each other. These begin behind
    /// the `first` of others.
    pub fn build(
        table: &Arc<DecalTable>,
        view: &View,
        range: DepthRange,
        target: &Target,
        (settings, limits, first): (&ClusterSettings, ListLimits, usize),
    ) -> (Self, Vec<u16>) {
        if table.boxes.is_empty() {
            return (Self::default(), Vec::new());
        }
        let view_from_world = view.world_from_view.inverse();
        let in_view = |matrix: &Mat4| {
            let view_from_box = view_from_world * *matrix;
            corners_of_box().map(|corner| view_from_box.transform_point3(corner))
        };
        let corners: Vec<[Vec3; 8]> = table.boxes.iter().map(in_view).collect();
        let mut settings = settings.clone();
        loop {
            let grid = Grid::new(view, range, target, &settings);
            let clusters = grid.row_count() * grid.tiles[0] as usize;
            let is_one = clusters == 1;
            let mut spans = Vec::new();
            for (decal, corners) in (0..).zip(&corners) {
                grid.spans_of_box(corners, decal, &mut spans);
            }
            let entries: usize = spans.iter().map(|span| usize::from(span.end - span.first)).sum();
            if !is_one && (clusters > limits.clusters || entries > limits.entries) {
                settings.tile_px *= 2;
                settings.slices = (settings.slices / 2).max(1);
                continue;
            }
            let (records, entries) = lists_of_spans(&grid, &[spans], first);
            let [slice_scale, slice_offset] = grid.slice_from_log_distance();
            let grid = DecalGrid {
                size: [grid.tiles[0], grid.tiles[1], grid.slices(), grid.tile_px],
                slices: [slice_scale, slice_offset, 0.0, 0.0],
            };
            let lists = Self { grid, records, table: table.clone(), entry_count: entries.len() as u64 };
            return (lists, entries);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec2};
    use manypass_scene::Projection;

    /// 0 ≤ x < 1: the finaliser of MurmurHash3.
    fn unit(seed: u32) -> f32 {
        let hash = (seed ^ (seed >> 16)).wrapping_mul(0x85eb_ca6b);
        let hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
        ((hash ^ (hash >> 16)) >> 8) as f32 / (1u32 << 24) as f32
    }

    fn boxes(count: u32) -> Vec<Mat4> {
        let of = |i: u32| {
            let at = |k: u32| unit(i * 16 + k + 1);
            let axis = Vec3::new(at(0) - 0.5, at(1) - 0.5, at(2) - 0.5).normalize_or(Vec3::X);
            let size = Vec3::new(0.1 + 2.0 * at(3), 0.1 + at(4), 0.05 + 0.4 * at(5));
            let place = Vec3::new(18.0 * at(6) - 9.0, 10.0 * at(7) - 5.0, 2.0 - 26.0 * at(8));
            Mat4::from_scale_rotation_translation(size, Quat::from_axis_angle(axis, 6.0 * at(9)), place)
        };
        (0..count).map(of).collect()
    }

    #[test]
    fn no_pixel_misses_a_decal_that_holds_its_surface() {
        let projections = [
            Projection::Perspective { fov_y_rad: 0.9, near_m: 0.1, far_m: None },
            Projection::Orthographic { height_m: 8.0, near_m: 0.1, far_m: 40.0 },
        ];
        let target = Target { size: (331, 177), aspect: 331.0 / 177.0, shift_ndc: Vec2::new(0.1, -0.05) };
        let range = DepthRange { near_m: 0.4, far_m: 24.0 };
        let limits = ListLimits { entries: 1 << 20, clusters: 1 << 20 };
        let table = Arc::new(DecalTable { boxes: boxes(300), ..DecalTable::default() });
        let boxes_from_world: Vec<Mat4> = table.boxes.iter().map(Mat4::inverse).collect();
        for projection in projections {
            let view = View { world_from_view: Mat4::from_rotation_y(0.2), projection };
            let settings = ClusterSettings::default();
            let (lists, entries) = DecalLists::build(&table, &view, range, &target, (&settings, limits, 0));
            let [across, down, slices, tile_px] = lists.grid.size;
            let (mut inside, mut listed) = (0, 0);
            for i in 0..40_000u32 {
                let at = |k: u32| unit(0x8000_0000 + i * 8 + k);
                let distance_m = 0.2 + 27.0 * at(2);
                let ndc = Vec2::new(2.0 * at(0) - 1.0, 1.0 - 2.0 * at(1));
                let extent = view.half_extent(target.aspect);
                let plane = (ndc - target.shift_ndc) * extent;
                let depth = if view.is_orthographic() { 1.0 } else { distance_m };
                let place = (plane * depth).extend(-distance_m);
                let world = view.world_from_view.transform_point3(place);
                let pixel = [at(0) * 331.0, at(1) * 177.0].map(|px| px as u32 / tile_px);
                let slice = distance_m.log2() * lists.grid.slices[0] + lists.grid.slices[1];
                let slice = slice.clamp(0.0, slices as f32 - 1.0) as u32;
                let record = lists.records[((slice * down + pixel[1]) * across + pixel[0]) as usize];
                let list = &entries[record.entries()];
                assert!(list.is_sorted(), "decals lie over each other in their order");
                listed += list.len();
                for (decal, matrix) in boxes_from_world.iter().enumerate() {
                    let local = matrix.transform_point3(world).abs();
                    if local.max_element() <= 0.5 {
                        inside += 1;
                        assert!(list.contains(&(decal as u16)), "{decal} is not at {ndc}, {distance_m} m");
                    }
                }
            }
            assert!(inside > 250, "{inside}");
            println!("{listed} looked at for {inside} inside");
            assert!(listed < 80 * inside, "{listed} for {inside}");
        }
    }
}
