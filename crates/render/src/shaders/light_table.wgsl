// The table of lights, and after them of tiles of shadow maps, in a texture wrapped in two dimensions.

import package::constants::{LIGHTS_PER_ROW, TEXELS_PER_LIGHT};

struct ClusterGrid {
    // Tiles across, tiles down, slices along the view axis, side of a tile in pixels.
    size: vec4u,
    // Slice = log2(distance_m) * x + y.
    slice_from_log_distance: vec2f,
    directional_count: u32,
    global_count: u32,
    // Of shadows: how far the comparisons of a filter lie from its middle in texels, 1 if texels are seen as they are, 0,
    // the bias in texels.
    shadow_filter: vec4f,
    // The number of lights before the first that is in lists and casts a shadow, and zeros.
    first_caster: vec4u,
}

// A light has four texels: position and 1 / range² (0 without a range); intensity, in candela or lux, times colour, pre-exposed,
// and the scale of its cone; the direction in which it shines and the offset of its cone; the number of the first of its tiles
// (0: it casts no shadow), how many it has, its radius in metres, 0. A tile has four texels, too: see `shaders/shadows.wgsl`.

@group(0) @binding(3) var<uniform> cluster_grid: ClusterGrid;
@group(0) @binding(4) var lights: texture_2d<f32>;

fn light_texel(index: u32) -> vec2i {
    return vec2i(i32((index % LIGHTS_PER_ROW) * TEXELS_PER_LIGHT), i32(index / LIGHTS_PER_ROW));
}
