// Sums of light over lists: of a cluster, of a tile, of an object; and of a single light. One light's contribution is
// that of `lights.wgsl`, here as everywhere.

import package::constants::{CASTING_POINTS, CASTING_SPOTS, DATA_WIDTH, LIGHTS_PER_ROW, QUIET_POINTS, QUIET_SPOTS};
import package::shaders::brdf::Shading;
import package::shaders::light_table::{
    ClusterList, TableRows, cluster_at, cluster_grid, cluster_light_bytes, light_place, place_of_bytes,
    table_rows,
};
import package::shaders::lights::{LightSums, add_global_lights, add_light, global_light_sums, light_classes};
import package::shaders::samplers::nearest_clamp;
import package::shaders::shadows::shadowed;

// What `LightReaches` holds: see `lights/reaches.rs`.
@if(tiled) @group(1) @binding(4) var light_reaches: texture_2d<f32>;
@if(tiled) @group(1) @binding(5) var tile_depth: texture_2d<f32>;

// The least and the greatest distance of the surfaces of the pixel's tile, and one divided by the rows of
// `light_reaches`.
@if(tiled) var<private> tile_bounds_m: vec2f;
@if(tiled) var<private> inverse_reach_rows: f32;

// 1 if those lights alone are wanted that are in no list.
override without_lists: u32 = 0u;

fn cluster_index_at(position_px: vec2f, distance_m: f32) -> u32 {
    let tile = min(vec2u(position_px) / cluster_grid.size.w, cluster_grid.size.xy - 1u);
    let slice_float = log2(distance_m) * cluster_grid.slice_from_log_distance.x + cluster_grid.slice_from_log_distance.y;
    let slice = u32(clamp(slice_float, 0.0, f32(cluster_grid.size.z - 1u)));
    return (slice * cluster_grid.size.y + tile.y) * cluster_grid.size.x + tile.x;
}

// Whether a light ends before the surfaces of the tile, or begins behind them. The bytes are those of its index.
@if(tiled) fn is_beside_tile(bytes: vec2f) -> bool {
    // A row holds several times as many as a byte has values. Half of one more, taken away again, because bytes are
    // shares of 255, which devices round either way.
    let rows = (bytes.y + 0.5) * f32(LIGHTS_PER_ROW) / f32(DATA_WIDTH);
    let column = bytes.x + fract(rows) * f32(DATA_WIDTH) - 0.5 * f32(LIGHTS_PER_ROW);
    let uv = vec2f((column + 0.5) / f32(DATA_WIDTH), (floor(rows) + 0.5) * inverse_reach_rows);
    let reach_m = textureSampleLevel(light_reaches, nearest_clamp, uv, 0.0).rg;
    return (reach_m.x > tile_bounds_m.y) | (reach_m.y < tile_bounds_m.x);
}

// Adds the entries of a list from one to another, which are all of one of `classes`.
fn add_entries(
    classes: u32,
    first: u32,
    end: u32,
    rows: TableRows,
    position_world: vec3f,
    shading: Shading,
    sums: ptr<function, LightSums>,
) {
    if (light_classes & classes) != 0u {
        for (var entry = first; entry < end; entry++) {
            let bytes = cluster_light_bytes(entry, rows);
            @if(tiled) {
                if is_beside_tile(bytes) {
                    (*sums).visited += 1.0;
                    (*sums).passed_over += 1.0;
                } else {
                    add_light(classes, place_of_bytes(bytes, rows), position_world, shading, sums);
                }
            }
            @if(!tiled) {
                add_light(classes, place_of_bytes(bytes, rows), position_world, shading, sums);
            }
        }
    }
}

// Adds the lights of a list. Each class of lights has a loop of its own, so that the others are spared what it costs
// where a processor runs both sides of a branch.
fn add_list(
    list: ClusterList,
    rows: TableRows,
    position_world: vec3f,
    shading: Shading,
    sums: ptr<function, LightSums>,
) {
    // Without shadows all are quiet.
    let is_quiet = shadowed == 0u;
    let quiet_points = select(QUIET_POINTS, QUIET_POINTS | CASTING_POINTS, is_quiet);
    let quiet_points_end = select(list.quiet_points_end, list.points_end, is_quiet);
    add_entries(quiet_points, list.first, quiet_points_end, rows, position_world, shading, sums);
    if shadowed != 0u {
        add_entries(CASTING_POINTS, list.quiet_points_end, list.points_end, rows, position_world, shading, sums);
        add_entries(CASTING_SPOTS, list.points_end, list.casters_end, rows, position_world, shading, sums);
    }
    let quiet_spots = select(QUIET_SPOTS, QUIET_SPOTS | CASTING_SPOTS, is_quiet);
    let quiet_spots_first = select(list.casters_end, list.points_end, is_quiet);
    add_entries(quiet_spots, quiet_spots_first, list.end, rows, position_world, shading, sums);
}

// The lights that are in no list, and those of the pixel's cluster; with `tiled` those of the pixel's tile that reach
// the distances at which it has surfaces.
fn light_sums(position_px: vec2f, distance_m: f32, position_world: vec3f, shading: Shading) -> LightSums {
    let rows = table_rows();
    var sums = global_light_sums(position_px, position_world, shading, rows);
    @if(tiled) {
        let tile = min(vec2u(position_px) / cluster_grid.size.w, cluster_grid.size.xy - 1u);
        tile_bounds_m = textureLoad(tile_depth, vec2i(tile), 0).rg;
        inverse_reach_rows = 1.0 / f32(textureDimensions(light_reaches).y);
    }
    if without_lists == 0u {
        add_list(cluster_at(cluster_index_at(position_px, distance_m)), rows, position_world, shading, &sums);
    }
    return sums;
}

// One light that has a range, of a class among `light_classes`.
fn single_light_sums(light: u32, position_world: vec3f, shading: Shading) -> LightSums {
    var sums: LightSums;
    add_light(light_classes, light_place(light, table_rows()), position_world, shading, &sums);
    return sums;
}

// So many of the lights that reach an object, from the one with the number `first` on: those that are in no list, and
// then those of its own list, which lie behind the lists of clusters.
fn object_light_sums(
    object_id: u32,
    first: u32,
    most: u32,
    position_world: vec3f,
    shading: Shading,
) -> LightSums {
    var sums: LightSums;
    let list = cluster_at(cluster_grid.size.x * cluster_grid.size.y * cluster_grid.size.z + object_id);
    let rows = table_rows();
    let global_count = cluster_grid.global_count;
    let end = min(first + most, global_count + list.end - list.first);
    let directional_end = min(cluster_grid.directional_count, end);
    add_global_lights(first, directional_end, min(global_count, end), rows, position_world, shading, &sums);
    let first_entry = list.first + max(first, global_count) - global_count;
    let end_entry = max(list.first + max(end, global_count) - global_count, first_entry);
    let part = ClusterList(
        first_entry,
        clamp(list.quiet_points_end, first_entry, end_entry),
        clamp(list.points_end, first_entry, end_entry),
        clamp(list.casters_end, first_entry, end_entry),
        end_entry,
    );
    add_list(part, rows, position_world, shading, &sums);
    return sums;
}
