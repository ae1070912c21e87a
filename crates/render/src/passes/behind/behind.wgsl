// behind: a level of the picture that transmissive surfaces are seen before, from the level above it; the first from
// radiance.
// Source: a tent over four by four texels, as four samples between them, so that coarse levels show no squares.
// Reads: finer. Writes: radiance and coverage.
// Program: behind.

import package::shaders::shading::linear_clamp;

struct Behind {
    // How far samples lie from the middle, in both directions; one divided by the size of what is drawn.
    step: vec4f,
}

@group(1) @binding(0) var finer: texture_2d<f32>;
@group(1) @binding(1) var<uniform> behind_step: Behind;

@fragment
fn fs_behind(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = position.xy * behind_step.step.zw;
    let offset = behind_step.step.xy;
    // The mark of what glows is none of coverage.
    let sum = textureSampleLevel(finer, linear_clamp, uv + vec2f(-offset.x, -offset.y), 0.0)
        + textureSampleLevel(finer, linear_clamp, uv + vec2f(offset.x, -offset.y), 0.0)
        + textureSampleLevel(finer, linear_clamp, uv + vec2f(-offset.x, offset.y), 0.0)
        + textureSampleLevel(finer, linear_clamp, uv + vec2f(offset.x, offset.y), 0.0);
    let mean = 0.25 * sum;
    return vec4f(mean.rgb, min(mean.a, 1.0));
}
