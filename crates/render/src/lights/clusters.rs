//! Which lights touch which clusters.

use super::decals::DecalLists;
use super::grid::{Grid, Span, Target};
use super::reach::Reach;
use super::record::ListRecord;
use super::{ClusterSettings, LIGHTS_MAX, LightListInputs, LightTable};
use crate::constants::{LIST_WIDTH, TABLE_WIDTH};
use crate::view::{DepthRange, View};
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// The uniform `ClusterGrid` of `light_table.wgsl`; a test compares the two layouts.
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
    /// Of shadows: how far the comparisons of a filter lie from its middle in texels, 1 if texels are seen as they are,
    /// the comparison whose turn it is, the bias in texels.
    pub shadow_filter: [f32; 4],
    /// Of rays in the picture that find more shadows: their length in metres, and 1 / how far what they pass behind
    /// goes on. Then 1 in a sample that skips converged tiles, and 0.
    pub contact: [f32; 4],
    /// Of the textures of lists and lights: one divided by the rows of the first, which holds the records of lists and
    /// then the lights; the middle of its first row of lights, as a share of all; one divided by the rows of the
    /// second; 0.
    pub table_rows: [f32; 4],
    /// Of the lists of decals: as `size`.
    pub decal_size: [u32; 4],
    /// Of these: as `slice_from_log_distance`; 0, 0.
    pub decal_slices: [f32; 4],
    /// Of the first texture: the first row of records of lists of decals, of decals, of the layers of nodes; 0.
    pub decal_rows: [f32; 4],
}

/// What the textures that hold the lists have room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListLimits {
    /// Entries of all lists together.
    pub entries: usize,
    /// Lists.
    pub clusters: usize,
}

impl ListLimits {
    /// What textures of at most `max_texture_size` rows hold, and not so much that it takes memory which the picture
    /// needs: 2²² entries take 8 MiB, half as many clusters 32 MiB.
    pub fn of(max_texture_size: u32) -> Self {
        let rows_of = |width: u32| (max_texture_size as usize * width as usize).min(1 << 22);
        // There is always room for one more list of all lights.
        let entries = rows_of(LIST_WIDTH).saturating_sub(LIGHTS_MAX as usize);
        Self { entries, clusters: rows_of(TABLE_WIDTH) / 2 }
    }
}

/// The lists of one view.
#[derive(Clone, Debug)]
pub struct ClusterLists {
    /// Shape of the grid.
    pub uniform: ClusterUniform,
    /// A record of the list of every cluster.
    pub table: Vec<ListRecord>,
    /// Indices of lights, list after list, low bytes first.
    pub lights: Vec<u16>,
    /// The lists of decals.
    pub decals: DecalLists,
}

/// A thread is worth its start from this many lights on.
const LIGHTS_PER_THREAD_MIN: usize = 256;

impl ClusterLists {
    /// One cluster with every light.
    pub fn everything(table: &LightTable, size: (u32, u32)) -> Self {
        let lights: Vec<u16> = (table.global_count()..table.len()).map(|light| light as u16).collect();
        Self {
            uniform: ClusterUniform {
                size: [1, 1, 1, size.0.max(size.1)],
                slice_from_log_distance: [0.0; 2],
                directional_count: table.directional_count(),
                global_count: table.global_count(),
                shadow_filter: [0.0; 4],
                contact: [0.0; 4],
                table_rows: [0.0; 4],
                decal_size: [0; 4],
                decal_slices: [0.0; 4],
                decal_rows: [0.0; 4],
            },
            table: vec![ListRecord::new(0, &lights, &table.class_ends)],
            lights,
            decals: DecalLists::default(),
        }
    }

    /// One cluster without lights, but for those that are in no list.
    pub fn nothing(table: &LightTable, size: (u32, u32)) -> Self {
        Self { table: vec![ListRecord::EMPTY], lights: Vec::new(), ..Self::everything(table, size) }
    }

    /// Lists for tiles and slices fitted to `range`. Where there would be more lists than `limits` has room for, or
    /// lights overlap so much that there would be more entries, tiles and slices become larger: no light is left out.
    /// Without lights that have a range there is one list, and it is empty.
    pub fn build(
        table: &LightTable,
        view: &View,
        range: DepthRange,
        target: &Target,
        settings: &ClusterSettings,
        limits: ListLimits,
    ) -> Self {
        if table.reaches.is_empty() {
            return Self::everything(table, target.size);
        }
        let mut settings = settings.clone();
        let view_from_world = view.world_from_view.inverse();
        let reaches: Vec<Reach> = table.reaches.iter().map(|reach| reach.transformed(&view_from_world)).collect();
        let (grid, spans) = loop {
            let grid = Grid::new(view, range, target, &settings);
            let fits = grid.row_count() * grid.tiles[0] as usize <= limits.clusters;
            let spans = if fits { all_spans(&grid, &reaches, table.global_count(), limits.entries) } else { None };
            match spans {
                Some(spans) => break (grid, spans),
                None if grid.row_count() == 1 && grid.tiles[0] == 1 => return Self::everything(table, target.size),
                None => {
                    settings.tile_px *= 2;
                    settings.slices = (settings.slices / 2).max(1);
                }
            }
        };
        let (lists, lights) = lists(&grid, &spans, &table.class_ends);
        Self {
            uniform: ClusterUniform {
                size: [grid.tiles[0], grid.tiles[1], grid.slices(), grid.tile_px],
                slice_from_log_distance: grid.slice_from_log_distance(),
                directional_count: table.directional_count(),
                global_count: table.global_count(),
                shadow_filter: [0.0; 4],
                contact: [0.0; 4],
                table_rows: [0.0; 4],
                decal_size: [0; 4],
                decal_slices: [0.0; 4],
                decal_rows: [0.0; 4],
            },
            table: lists,
            lights,
            decals: DecalLists::default(),
        }
    }
}

impl ClusterLists {
    /// Appends the lists of decals, as far as there is room.
    pub fn append_decals(&mut self, of: &LightListInputs) {
        let left = ListLimits {
            entries: of.limits.entries.saturating_sub(self.lights.len()),
            clusters: of.limits.clusters.saturating_sub(self.table.len()).max(1),
        };
        let first = self.lights.len();
        let (decals, entries) =
            DecalLists::build(&of.decals.0, &of.view, of.range, &of.target, (&of.settings, left, first));
        (self.uniform.decal_size, self.uniform.decal_slices) = (decals.grid.size, decals.grid.slices);
        self.lights.extend(entries);
        self.decals = decals;
    }
}

/// The spans of all lights, in the order of the lights; none if the lists would get too long.
fn all_spans(grid: &Grid, reaches: &[Reach], first_light: u32, entries_max: usize) -> Option<Vec<Vec<Span>>> {
    let collect = |part: Range<usize>| {
        let mut spans = Vec::with_capacity(part.len() * 32);
        let mut entries = 0;
        for index in part {
            let counted = spans.len();
            grid.spans(&reaches[index], (first_light as usize + index) as u16, &mut spans);
            entries += spans[counted..].iter().map(|span| usize::from(span.end - span.first)).sum::<usize>();
            if entries > entries_max {
                return None;
            }
        }
        Some((spans, entries))
    };
    let results: Option<Vec<_>> =
        in_parallel(parts(reaches.len(), LIGHTS_PER_THREAD_MIN), collect).into_iter().collect();
    let results = results?;
    let total: usize = results.iter().map(|(_, entries)| entries).sum();
    (total <= entries_max).then(|| results.into_iter().map(|(spans, _)| spans).collect())
}

/// A record of every list, and the lists, of what has no classes. Entries begin behind the `first` of others.
pub(crate) fn lists_of_spans(grid: &Grid, parts_of_spans: &[Vec<Span>], first: usize) -> (Vec<ListRecord>, Vec<u16>) {
    let (records, entries) = lists(grid, parts_of_spans, &[0, 0, 0, 0, 0, u32::MAX]);
    (records.into_iter().map(|record| record.behind(first)).collect(), entries)
}

/// A record of every list, and the lists. Rows of clusters are filled one after the other, so that what
/// is written stays in the cache.
fn lists(grid: &Grid, parts_of_spans: &[Vec<Span>], class_ends: &[u32; 6]) -> (Vec<ListRecord>, Vec<u16>) {
    let row_len = grid.tiles[0] as usize;
    // Where the spans and the entries of a row begin.
    let mut begins = vec![[0usize; 2]; grid.row_count() + 1];
    for span in parts_of_spans.iter().flatten() {
        let [count, entries] = &mut begins[span.row as usize + 1];
        *count += 1;
        *entries += usize::from(span.end - span.first);
    }
    for row in 1..begins.len() {
        begins[row][0] += begins[row - 1][0];
        begins[row][1] += begins[row - 1][1];
    }
    let span_count = begins.last().map_or(0, |begin| begin[0]);
    let mut sorted = vec![Span::default(); span_count];
    let mut next: Vec<u32> = begins.iter().map(|begin| begin[0] as u32).collect();
    for span in parts_of_spans.iter().flatten() {
        let place = &mut next[span.row as usize];
        sorted[*place as usize] = *span;
        *place += 1;
    }
    let mut table = vec![ListRecord::EMPTY; grid.row_count() * row_len];
    let mut lights = vec![0u16; begins.last().map_or(0, |begin| begin[1])];
    let mut parts_with_output = Vec::new();
    let (mut table_rest, mut lights_rest) = (table.as_mut_slice(), lights.as_mut_slice());
    for rows in parts(grid.row_count(), if span_count < 4096 { usize::MAX } else { 1 }) {
        let (table_part, rest) = table_rest.split_at_mut(rows.len() * row_len);
        table_rest = rest;
        let (lights_part, rest) = lights_rest.split_at_mut(begins[rows.end][1] - begins[rows.start][1]);
        lights_rest = rest;
        parts_with_output.push((rows, table_part, lights_part));
    }
    in_parallel(parts_with_output, |(rows, table, lights)| {
        let mut cursors = vec![0i32; row_len + 1];
        let first_entry = begins[rows.start][1];
        for (row, table) in rows.clone().zip(table.chunks_exact_mut(row_len)) {
            let spans = &sorted[begins[row][0]..begins[row + 1][0]];
            fill_row(spans, begins[row][1] - first_entry, lights, &mut cursors);
            let mut begin = begins[row][1];
            for (cluster, end) in table.iter_mut().zip(&cursors) {
                let end = first_entry + *end as usize;
                *cluster = ListRecord::new(begin, &lights[begin - first_entry..end - first_entry], class_ends);
                begin = end;
            }
        }
    });
    (table, lights)
}

/// Writes the lists of one row of clusters from `offset` in `lights` on, and leaves where each ends in `cursors`, which
/// has one place more than the row.
fn fill_row(spans: &[Span], offset: usize, lights: &mut [u16], cursors: &mut [i32]) {
    // The number of lights rises by one where a span begins and falls where it ends.
    cursors.fill(0);
    for span in spans {
        cursors[usize::from(span.first)] += 1;
        cursors[usize::from(span.end)] -= 1;
    }
    let (mut count, mut end) = (0, offset);
    for cursor in cursors.iter_mut() {
        count += *cursor;
        *cursor = end as i32;
        end += count as usize;
    }
    for span in spans {
        for cursor in &mut cursors[usize::from(span.first)..usize::from(span.end)] {
            lights[*cursor as usize] = span.light;
            *cursor += 1;
        }
    }
}

/// `0..count` in parts of about the same size, one for each thread that is worth its start.
fn parts(count: usize, least: usize) -> Vec<Range<usize>> {
    let threads = if cfg!(target_arch = "wasm32") {
        1
    } else {
        std::thread::available_parallelism().map_or(1, usize::from).min(8).min(count / least.max(1)).max(1)
    };
    (0..threads).map(|i| count * i / threads..count * (i + 1) / threads).collect()
}

/// Runs `work` on every part, the first on this thread, and gives the results in their order.
fn in_parallel<P: Send, R: Send>(parts: Vec<P>, work: impl Fn(P) -> R + Sync) -> Vec<R> {
    let mut parts = parts.into_iter();
    let Some(first) = parts.next() else { return Vec::new() };
    if parts.len() == 0 {
        return vec![work(first)];
    }
    std::thread::scope(|scope| {
        let work = &work;
        let others: Vec<_> = parts.map(|part| scope.spawn(move || work(part))).collect();
        let mut results = vec![work(first)];
        for other in others {
            match other.join() {
                Ok(result) => results.push(result),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        results
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;
    use glam::{Mat4, Vec2, Vec3};
    use manypass_scene::{LightKind, Projection};

    const UNLIMITED: ListLimits = ListLimits { entries: usize::MAX, clusters: usize::MAX };

    /// 0 ≤ x < 1: the finaliser of MurmurHash3.
    fn unit(i: u32, k: u32) -> f32 {
        let mut hash = i.wrapping_mul(0x9e37_79b9) ^ k.wrapping_mul(0x7feb_352d);
        hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
        hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
        ((hash ^ (hash >> 16)) >> 8) as f32 / (1u32 << 24) as f32
    }

    /// Two lights without range, and then so many spots: the half angle, at most 90°, and the range by number.
    fn table(count: u32, outer_cone_rad: impl Fn(u32) -> Option<f32>) -> LightTable {
        let mut table = LightTable { texels: vec![[0.0; 4]; 8], class_ends: [0, 2, 2, 2, 2, 2], ..Default::default() };
        for i in 0..count {
            let position = Vec3::new(18.0 * unit(i, 1) - 9.0, 10.0 * unit(i, 2) - 5.0, -24.0 * unit(i, 3));
            let direction = Vec3::new(unit(i, 8) - 0.5, unit(i, 9) - 0.5, unit(i, 10) - 0.5).normalize_or(Vec3::X);
            let range_m = (0.1 + 0.4 * unit(i, 4)) * if outer_cone_rad(i).is_some() { 3.0 } else { 1.0 };
            let cos = outer_cone_rad(i).map_or(-2.0, f32::cos);
            let kind = match outer_cone_rad(i) {
                Some(outer_cone_rad) => LightKind::Spot { inner_cone_rad: 0.0, outer_cone_rad },
                None => LightKind::Point,
            };
            table.reaches.push(Reach::of_light(kind, position, direction, range_m));
            table.texels.extend([position.extend(range_m).to_array(), direction.extend(cos).to_array()]);
            table.texels.extend([[0.0; 4]; 2]);
        }
        table
    }

    fn lights(count: u32) -> LightTable {
        table(count, |_| None)
    }

    fn spots(count: u32) -> LightTable {
        table(count, |i| Some(1.5 * unit(i, 11)))
    }

    /// Whether a light of [`table`] reaches a point.
    fn is_reached(texels: &[[f32; 4]], place: Vec3) -> bool {
        let [x, y, z, range_m] = texels[0];
        let [axis_x, axis_y, axis_z, cos] = texels[1];
        let offset = place - Vec3::new(x, y, z);
        offset.length() < range_m && Vec3::new(axis_x, axis_y, axis_z).dot(offset) > cos * offset.length()
    }

    fn cases() -> Vec<(View, DepthRange, Target)> {
        let projections = [
            Projection::Perspective { fov_y_rad: 0.9, near_m: 0.1, far_m: None },
            Projection::Orthographic { height_m: 8.0, near_m: 0.1, far_m: 40.0 },
        ];
        let case = |projection, shift_ndc| {
            let view = View { world_from_view: Mat4::from_rotation_y(0.2), projection };
            let target = Target { size: (331, 177), aspect: 331.0 / 177.0, shift_ndc };
            (view, DepthRange { near_m: 0.4, far_m: 24.0 }, target)
        };
        let [perspective, orthographic] = projections;
        vec![
            case(perspective, Vec2::ZERO),
            case(orthographic, Vec2::ZERO),
            // As far as a lens moves it, and further.
            case(perspective, Vec2::new(0.07, -0.4)),
        ]
    }

    /// The point that the shader rebuilds at a place of a picture that is moved by `jitter_px`, and a distance.
    fn point(view: &View, target: &Target, jitter_px: Vec2, pixel: Vec2, distance_m: f32) -> Vec3 {
        let size = Vec2::new(target.size.0 as f32, target.size.1 as f32);
        let ndc = ((pixel - jitter_px) / size * 2.0 - 1.0) * Vec2::new(1.0, -1.0) - target.shift_ndc;
        let plane = ndc * view.half_extent(size.x / size.y) * if view.is_orthographic() { 1.0 } else { distance_m };
        view.world_from_view.transform_point3(plane.extend(-distance_m))
    }

    #[test]
    fn every_light_that_reaches_a_point_is_in_its_cluster_once() {
        let settings = ClusterSettings::default();
        for (table, view, range, target) in [lights(3000), spots(3000)].into_iter().flat_map(|table| {
            cases().into_iter().map(move |(view, range, target)| (table.clone(), view, range, target))
        }) {
            let lists = ClusterLists::build(&table, &view, range, &target, &settings, UNLIMITED);
            let [across, down, slices, tile_px] = lists.uniform.size;
            let mut reached = 0;
            for i in 0..4000u32 {
                let pixel = Vec2::new((unit(i, 5) * 331.0).floor() + 0.5, (unit(i, 6) * 177.0).floor() + 0.5);
                let near_m = range.near_m.max(0.01);
                let distance = near_m * (range.far_m / near_m).powf(unit(i, 7));
                let [scale, bias] = lists.uniform.slice_from_log_distance;
                let slice = (distance.log2() * scale + bias).clamp(0.0, slices as f32 - 1.0) as u32;
                let tile = (pixel / tile_px as f32).floor();
                let cluster = (slice * down + tile.y as u32) * across + tile.x as u32;
                let list = &lists.lights[lists.table[cluster as usize].entries()];
                assert!(list.windows(2).all(|pair| pair[0] < pair[1]), "a list is in the order of the lights");
                // As far as samples go: the lists are those of all.
                let jitter_px = 0.5 * [Vec2::ONE, Vec2::NEG_ONE, Vec2::NEG_X, Vec2::Y][i as usize % 4];
                let place = point(&view, &target, jitter_px, pixel, distance);
                for (index, texels) in table.texels.chunks_exact(4).skip(2).enumerate() {
                    if is_reached(texels, place) {
                        reached += 1;
                        assert!(list.contains(&(index as u16 + 2)), "light {index} at {place}");
                    }
                }
            }
            assert!(reached > 100, "{reached}");
        }
    }

    #[test]
    fn tables_that_would_get_too_large_have_larger_clusters() {
        let table = lights(300);
        let settings = ClusterSettings { tile_px: 8, slices: 64 };
        for (view, range, _) in cases() {
            let target = Target { size: (4096, 2048), aspect: 2.0, shift_ndc: Vec2::ZERO };
            let free = ClusterLists::build(&table, &view, range, &target, &settings, UNLIMITED);
            assert_eq!(free.table.len(), 512 * 256 * 64);
            let limits = ListLimits { clusters: 1 << 20, ..UNLIMITED };
            let lists = ClusterLists::build(&table, &view, range, &target, &settings, limits);
            let [across, down, slices, tile_px] = lists.uniform.size;
            assert_eq!(lists.table.len(), (across * down * slices) as usize);
            assert!(lists.table.len() <= 1 << 20, "{} clusters", lists.table.len());
            assert!(across * tile_px >= 4096 && down * tile_px >= 2048, "all of the picture has clusters");
            let all: std::collections::BTreeSet<u16> = lists.lights.iter().copied().collect();
            let all_free: std::collections::BTreeSet<u16> = free.lights.iter().copied().collect();
            assert_eq!(all, all_free, "no light is lost");
        }
    }

    #[test]
    fn without_lights_of_a_range_there_is_one_empty_list() {
        let table = LightTable { texels: vec![[0.0; 4]; 8], class_ends: [0, 2, 2, 2, 2, 2], ..Default::default() };
        for (view, range, target) in cases() {
            let lists = ClusterLists::build(&table, &view, range, &target, &ClusterSettings::default(), UNLIMITED);
            assert_eq!((lists.table, lists.lights), (vec![ListRecord::EMPTY], vec![]));
            assert_eq!(lists.uniform.global_count, 2);
        }
    }

    #[test]
    fn lists_that_would_get_too_long_have_larger_clusters() {
        let table = lights(3000);
        let settings = ClusterSettings::default();
        for (view, range, target) in cases() {
            let free = ClusterLists::build(&table, &view, range, &target, &settings, UNLIMITED);
            let most = free.lights.len() * 3 / 4;
            let lists = ClusterLists::build(
                &table,
                &view,
                range,
                &target,
                &settings,
                ListLimits { entries: most, ..UNLIMITED },
            );
            assert!(lists.lights.len() <= most && lists.uniform.size[3] > settings.tile_px);
            let lists =
                ClusterLists::build(&table, &view, range, &target, &settings, ListLimits { entries: 100, ..UNLIMITED });
            assert_eq!(lists.lights.len(), 3000, "one list of all lights is the last resort");
        }
    }

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "forward",
            "ClusterGrid",
            ClusterUniform,
            [
                size,
                slice_from_log_distance,
                directional_count,
                global_count,
                shadow_filter,
                contact,
                table_rows,
                decal_size,
                decal_slices,
                decal_rows
            ]
        );
    }
}
