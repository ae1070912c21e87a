// adaptive.depth: begins depth with tiles that are settled nearest of all, so that nothing is drawn there: depth is that
// where nothing else is drawn, and the triangle, which is farthest of all, is drawn where tiles are not settled.
// Reads: settled. Writes: depth.
// Program: adaptive_depth.

import package::constants::SETTLED_TILE_PX;

@group(1) @binding(0) var settled: texture_2d<f32>;

@fragment
fn fs_adaptive_depth(@builtin(position) position: vec4f) {
    if textureLoad(settled, vec2i(position.xy) / SETTLED_TILE_PX, 0).r > 0.0 {
        discard;
    }
}
