// scrub: radiance without what is no number, or infinite.
// Reads: radiance. Writes: radiance (pre-exposed); with `counts` 1 where it is no number or infinite, else 0.
// Program: scrub.

import package::shaders::scrub::{is_finite, scrubbed};

@group(1) @binding(0) var radiance: texture_2d<f32>;

// 1 if such pixels are counted.
override counts: u32 = 0u;

@fragment
fn fs_scrub(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = textureLoad(radiance, vec2i(position.xy), 0);
    if counts != 0u {
        return vec4f(select(1.0, 0.0, is_finite(texel)), 0.0, 0.0, 1.0);
    }
    return scrubbed(texel);
}
