// adaptive: which tiles of a still's picture are settled, because the mean of all samples so far and that of their
// first half show the same there, and around it.
// Source: Dammertz et al. 2010, "A Hierarchical Automatic Stopping Condition for Monte Carlo Global Illumination".
// Reads: the mean, that of half of the samples. Writes: settled (r8unorm, a texel for each tile: the share of the
// samples that it is left out of, or 0).
// Program: adaptive.

import package::constants::SETTLED_TILE_PX;

// The side of a tile with the pixels beside it.
const WITH_BORDER_PX: i32 = SETTLED_TILE_PX + 2;

struct Settling {
    // What may change, of display values encoded by a square root.
    threshold: f32,
    // The same, just beside the tile.
    threshold_beside: f32,
    // Which share of the samples is left out of a tile that is settled now.
    share_left_out: f32,
    // Uniforms of WebGL 2 are multiples of 16 bytes.
    padding: f32,
}

@group(1) @binding(0) var<uniform> settling: Settling;
@group(1) @binding(1) var mean: texture_2d<f32>;
@group(1) @binding(2) var mean_of_half: texture_2d<f32>;

// About as displays encode light.
fn encoded(color: vec4f) -> vec4f {
    return sqrt(max(color, vec4f(0.0)));
}

@fragment
fn fs_adaptive(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let last = vec2i(textureDimensions(mean)) - 1;
    let first = vec2i(position.xy) * SETTLED_TILE_PX - 1;
    var is_settled = true;
    for (var y = 0; y < WITH_BORDER_PX; y++) {
        for (var x = 0; x < WITH_BORDER_PX; x++) {
            let pixel = clamp(first + vec2i(x, y), vec2i(0), last);
            let change = abs(encoded(textureLoad(mean, pixel, 0)) - encoded(textureLoad(mean_of_half, pixel, 0)));
            // Where an edge just beside the tile moves, samples may have missed that it reaches into it.
            let is_inside = all(vec2i(x, y) == clamp(vec2i(x, y), vec2i(1), vec2i(SETTLED_TILE_PX)));
            let threshold = select(settling.threshold_beside, settling.threshold, is_inside);
            is_settled = is_settled && all(change <= vec4f(threshold));
        }
    }
    return vec4f(select(0.0, settling.share_left_out, is_settled));
}
