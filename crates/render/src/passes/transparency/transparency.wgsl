// transparency: the weighted mean of blended surfaces, over what lies behind them all (see `mod.rs`).
// Reads: sums (radiance times weight, and what comes through all surfaces), weights (alpha times weight). Writes:
// radiance (premultiplied).
// Program: transparency.

import package::shaders::colour::half_float_clamped;
import package::shaders::scrub::scrubbed;

@group(1) @binding(0) var sums: texture_2d<f32>;
@group(1) @binding(1) var weights: texture_2d<f32>;

// The least half float.
const WEIGHT_MIN: f32 = 6e-8;

@fragment
fn fs_transparency(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let sum = scrubbed(textureLoad(sums, vec2i(position.xy), 0));
    let weight = textureLoad(weights, vec2i(position.xy), 0).r;
    let coverage = 1.0 - min(sum.a, 1.0);
    let mean = half_float_clamped(sum.rgb / max(weight, WEIGHT_MIN));
    return vec4f(mean * coverage, coverage);
}
