// particles.compose: the mean of particles by optical depth, over what lies behind them.
// Reads: the sums that `particles.wgsl` leaves. Writes: radiance (premultiplied).
// Program: particles_compose.

import package::shaders::colour::half_float_clamped;
import package::shaders::scrub::scrubbed;

@group(1) @binding(1) var sums: texture_2d<f32>;

// The least half float.
const LEAST: f32 = 6e-8;

@fragment
fn fs_particles_compose(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let sum = scrubbed(textureLoad(sums, vec2i(position.xy), 0));
    let through = clamp(sum.a, LEAST, 1.0);
    let coverage = 1.0 - through * through;
    let mean = sum.rgb / max(-2.0 * log(through), 1e-4);
    return vec4f(half_float_clamped(mean) * coverage, coverage);
}
