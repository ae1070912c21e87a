// tile_depth: the nearest and the farthest surface of every tile of the lists of lights. First along rows, tile by
// tile; with `columns` down the columns of what that left, so that a tile of n × n pixels takes n texels twice.
// Reads: linear_depth, or what rows left. Writes: least and greatest distance (rg32float); without a surface
// DISTANCE_BACKGROUND_M and 0, which no light reaches.
// Program: tile_depth.

import package::constants::DISTANCE_BACKGROUND_M;
import package::shaders::light_table::cluster_grid;
import package::view::view;

// 1 for the second step.
override columns: u32 = 0u;

// Distances, or what rows left.
@group(1) @binding(0) var bounded: texture_2d<f32>;

fn bounds_at(place: vec2i) -> vec2f {
    let texel = textureLoad(bounded, place, 0).rg;
    if columns != 0u {
        return texel;
    }
    return vec2f(texel.r, select(texel.r, 0.0, texel.r >= DISTANCE_BACKGROUND_M));
}

@fragment
fn fs_tile_depth(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = vec2i(position.xy);
    // How long the loop is depends on more than uniforms, see docs/decisions/006.
    let tile_px = select(0, i32(cluster_grid.size.w), position.x >= 0.0);
    let step = select(vec2i(1, 0), vec2i(0, 1), columns != 0u);
    let first = place + place * step * (tile_px - 1);
    let left = vec2i(view.size_px) - first;
    let count = min(tile_px, select(left.x, left.y, columns != 0u));
    var bounds = vec2f(DISTANCE_BACKGROUND_M, 0.0);
    for (var i = 0; i < count; i++) {
        let texel = bounds_at(first + step * i);
        bounds = vec2f(min(bounds.x, texel.x), max(bounds.y, texel.y));
    }
    return vec4f(bounds, 0.0, 1.0);
}
