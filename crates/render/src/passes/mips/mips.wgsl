// mips: a level of a picture from the level above it; the first from a picture of its size.
// Source: a tent over four by four texels, as four samples between them, so that coarse levels show no squares; or a box
// over two by two, as four samples in one place.
// Reads: finer. Writes: radiance or linear colour, and coverage.
// Program: mips.

import package::shaders::shading::linear_clamp;

struct Mips {
    // How far samples lie from the middle, in both directions; one divided by the size of what is drawn.
    step: vec4f,
}

@group(1) @binding(0) var finer: texture_2d<f32>;
@group(1) @binding(1) var<uniform> mips: Mips;

@fragment
fn fs_mips(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = position.xy * mips.step.zw;
    let offset = mips.step.xy;
    // The mark of what glows is none of coverage.
    let sum = textureSampleLevel(finer, linear_clamp, uv + vec2f(-offset.x, -offset.y), 0.0)
        + textureSampleLevel(finer, linear_clamp, uv + vec2f(offset.x, -offset.y), 0.0)
        + textureSampleLevel(finer, linear_clamp, uv + vec2f(-offset.x, offset.y), 0.0)
        + textureSampleLevel(finer, linear_clamp, uv + vec2f(offset.x, offset.y), 0.0);
    let mean = 0.25 * sum;
    return vec4f(mean.rgb, min(mean.a, 1.0));
}
