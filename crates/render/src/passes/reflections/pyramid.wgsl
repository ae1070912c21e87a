// reflections.pyramid: a level of the least distances of squares of pixels, from the level below; with `begins` the
// first one, of pixels, from linear_depth. The first level's sides are multiples of the largest square's, so that every
// texel is of four whole ones; beyond the picture there is nothing.
// Source: Uludag 2014, "Hi-Z Screen-Space Cone-Traced Reflections" (GPU Pro 5). Reads: finer. Writes: distances (r).
// Program: reflections_pyramid.

import package::constants::DISTANCE_BACKGROUND_M;

@group(1) @binding(0) var finer: texture_2d<f32>;

override begins: u32 = 0u;

fn nearest_at(texel: vec2i) -> f32 {
    return textureLoad(finer, texel, 0).r;
}

@fragment
fn fs_reflections_pyramid(@builtin(position) position: vec4f) -> @location(0) f32 {
    let texel = vec2i(position.xy);
    if begins != 0u {
        let last = vec2i(textureDimensions(finer)) - 1;
        let is_inside = all(texel <= last);
        return select(DISTANCE_BACKGROUND_M, nearest_at(min(texel, last)), is_inside);
    }
    let first = texel * 2;
    let above = min(nearest_at(first), nearest_at(first + vec2i(1, 0)));
    let below = min(nearest_at(first + vec2i(0, 1)), nearest_at(first + vec2i(1, 1)));
    return min(above, below);
}
