// tile_depth: the nearest and the farthest surface of every tile of the lists of lights. First along rows, tile by tile;
// with `columns` down the columns of what that left, so that a tile of n × n pixels takes n texels twice.
// Reads: linear_depth, or what rows left. Writes: least and greatest distance (rg32float); without a surface
// DISTANCE_BACKGROUND_M and 0, which no light reaches.
// Program: tile_depth. Axes: columns.

import package::constants::DISTANCE_BACKGROUND_M;
import package::shaders::light_table::cluster_grid;
import package::view::view;

@if(!columns) @group(1) @binding(0) var linear_depth: texture_2d<f32>;
@if(columns) @group(1) @binding(1) var rows: texture_2d<f32>;

@if(!columns) fn bounds_at(place: vec2i) -> vec2f {
    let distance_m = textureLoad(linear_depth, place, 0).r;
    return vec2f(distance_m, select(distance_m, 0.0, distance_m >= DISTANCE_BACKGROUND_M));
}

@if(columns) fn bounds_at(place: vec2i) -> vec2f {
    return textureLoad(rows, place, 0).rg;
}

@fragment
fn fs_tile_depth(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = vec2i(position.xy);
    // How long the loop is depends on more than uniforms, see ARCHITECTURE.md.
    let tile_px = select(0, i32(cluster_grid.size.w), position.x >= 0.0);
    @if(!columns) let first = vec2i(place.x * tile_px, place.y);
    @if(columns) let first = vec2i(place.x, place.y * tile_px);
    @if(!columns) let step = vec2i(1, 0);
    @if(columns) let step = vec2i(0, 1);
    @if(!columns) let count = min(tile_px, i32(view.size_px.x) - first.x);
    @if(columns) let count = min(tile_px, i32(view.size_px.y) - first.y);
    var bounds = vec2f(DISTANCE_BACKGROUND_M, 0.0);
    for (var i = 0; i < count; i++) {
        let texel = bounds_at(first + step * i);
        bounds = vec2f(min(bounds.x, texel.x), max(bounds.y, texel.y));
    }
    return vec4f(bounds, 0.0, 1.0);
}
