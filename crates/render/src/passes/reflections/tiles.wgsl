// reflections.cells: squares of texels in which any ray met something.
// reflections.tiles: squares of 2 × 2 of those, with those around them, in which what such rays brought is seen.
// Reads: hits. Writes: 1 where there is any, else 0.
// Program: reflections_tiles.

@group(1) @binding(0) var hits: texture_2d<f32>;

// Texels of `hits` along a side of the square that is looked at, how far it begins before that of the texel drawn, and
// how far apart these are.
override looked_at: u32 = 4u;
override before: u32 = 0u;
override stride: u32 = 4u;
// 1 if hits are in the first channel; else in the last.
override in_first: u32 = 0u;

@fragment
fn fs_reflections_tiles(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = vec2i(position.xy) * i32(stride) - i32(before);
    let last = vec2i(textureDimensions(hits)) - 1;
    var most = 0.0;
    for (var y = 0u; y < looked_at; y++) {
        for (var x = 0u; x < looked_at; x++) {
            let texel = textureLoad(hits, clamp(first + vec2i(vec2u(x, y)), vec2i(0), last), 0);
            most = max(most, select(texel.a, texel.r, in_first != 0u));
        }
    }
    return vec4f(select(0.0, 1.0, most > 0.0));
}
