// The table of lights, before them of the lists of clusters and of decals, and after them of tiles of shadow maps, and the lists of
// lights and decals for every cluster, in textures wrapped in two dimensions, reached only through the functions of this module,
// so that another storage can take their place here.

import package::constants::{LIGHTS_PER_ROW, LIST_WIDTH, TABLE_WIDTH, TEXELS_PER_LIGHT};
import package::shaders::samplers::nearest_clamp;

struct ClusterGrid {
    // Tiles across, tiles down, slices along the view axis, side of a tile in pixels.
    size: vec4u,
    // Slice = log2(distance_m) * x + y.
    slice_from_log_distance: vec2f,
    directional_count: u32,
    global_count: u32,
    // Of shadows: how far the comparisons of a filter lie from its middle in texels, 1 if texels are seen as they are,
    // 0, the bias in texels.
    shadow_filter: vec4f,
    // Of rays in the picture that find more shadows: their length in metres, 1 / how far what they pass behind goes on.
    // Then 1 in a sample that skips converged tiles, and 0.
    contact: vec4f,
    // See `TableRows`.
    table_rows: vec4f,
    // Of the lists of decals: as `size`; as `slice_from_log_distance`, 0, 0; the first rows of their records, of decals
    // and of the layers of nodes in the table of lights, 0.
    decal_size: vec4u,
    decal_slices: vec4f,
    decal_rows: vec4f,
}

// A light has four texels: position and 1 / range² (0 without a range); intensity, in candela or lux, times colour,
// pre-exposed, and the scale of its cone; the direction in which it shines and the offset of its cone; the number of
// the first of its tiles (0: it casts no shadow), how many it has, its radius in metres, 0. A tile has four texels,
// too: see `shaders/shadows.wgsl`.

const LIGHT_POSITION: f32 = 0.0;
const LIGHT_COLOR: f32 = 1.0;
const LIGHT_AXIS: f32 = 2.0;
const LIGHT_SHADOW: f32 = 3.0;

@group(0) @binding(3) var<uniform> cluster_grid: ClusterGrid;
@group(0) @binding(4) var lights: texture_2d<f32>;
// An index in two bytes, each as a share of 255.
@group(0) @binding(5) var cluster_lights: texture_2d<f32>;

// What loops over lights read is sampled, not loaded, because software adapters find the mip of every lane of a load.
// What depends on the numbers of rows is read once, not for every light.
struct TableRows {
    inverse_light_rows: f32,
    // The middle of the first row of lights, which lie behind the records of lists.
    first_light_row: f32,
    inverse_list_rows: f32,
}

fn table_rows() -> TableRows {
    let rows = cluster_grid.table_rows;
    return TableRows(rows.x, rows.y, rows.z);
}

// Where the first texel of a light lies in the table, or of a tile, in texture coordinates.
fn light_place(index: u32, rows: TableRows) -> vec2f {
    return place_of_bytes(vec2f(vec2u(index % LIGHTS_PER_ROW, index / LIGHTS_PER_ROW)), rows);
}

// The same of an index by its column and row, which are its low byte and what is above it: a row has as many lights as
// a byte has values, which spares entries of lists their index.
fn place_of_bytes(column_and_row: vec2f, rows: TableRows) -> vec2f {
    let texel = 1.0 / f32(LIGHTS_PER_ROW * TEXELS_PER_LIGHT);
    let row = column_and_row.y * rows.inverse_light_rows + rows.first_light_row;
    return vec2f(column_and_row.x / f32(LIGHTS_PER_ROW) + 0.5 * texel, row);
}

// The texel `part` of the light at a place.
fn light_part(place: vec2f, part: f32) -> vec4f {
    let offset = part / f32(LIGHTS_PER_ROW * TEXELS_PER_LIGHT);
    return textureSampleLevel(lights, nearest_clamp, vec2f(place.x + offset, place.y), 0.0);
}

// Where the list of a cluster begins and ends among all entries, and on the way the ends of its classes of lights:
// point lights that cast no shadow, that cast one, spots that cast one; those that cast none are the rest.
struct ClusterList {
    first: u32,
    quiet_points_end: u32,
    points_end: u32,
    casters_end: u32,
    end: u32,
}

// The record of a list: see `lights/record.rs`.
fn cluster_at(index: u32) -> ClusterList {
    // By way of signed numbers, to which processors convert at once.
    let record = vec4u(vec4i(table_texel(index, 0.0)));
    let first = record.x;
    return ClusterList(
        first,
        first + (record.z & 0xffffu),
        first + ((record.y >> 16u) | ((record.z >> 16u) << 8u)),
        first + record.w,
        first + (record.y & 0xffffu),
    );
}

// A texel of what lies before the lights in their table, counted from the beginning of a row.
fn table_texel(index: u32, first_row: f32) -> vec4f {
    let uv = vec2f(
        (f32(index % TABLE_WIDTH) + 0.5) / f32(TABLE_WIDTH),
        (f32(index / TABLE_WIDTH) + first_row + 0.5) * cluster_grid.table_rows.x,
    );
    return textureSampleLevel(lights, nearest_clamp, uv, 0.0);
}

// The low and the high byte of the index that an entry of a list holds.
fn cluster_light_bytes(entry: u32, rows: TableRows) -> vec2f {
    let uv = vec2f((f32(entry % LIST_WIDTH) + 0.5) / f32(LIST_WIDTH), (f32(entry / LIST_WIDTH) + 0.5) * rows.inverse_list_rows);
    return textureSampleLevel(cluster_lights, nearest_clamp, uv, 0.0).rg * 255.0;
}

// The index of the light that an entry of a list names.
fn cluster_light_at(entry: u32, rows: TableRows) -> u32 {
    return u32(dot(cluster_light_bytes(entry, rows), vec2f(1.0, 256.0)) + 0.5);
}
