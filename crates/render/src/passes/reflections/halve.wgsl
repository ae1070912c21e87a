// reflections.radiance: a level of the picture's light, at half the size of the level below: of each direction one, three,
// three and one parts of four finer texels, so that what is small stays where it is.
// Reads: finer. Writes: radiance, and how much of it is surfaces (a).
// Program: reflections_halve.

import package::constants::RADIANCE_MAX;

@group(1) @binding(0) var finer: texture_2d<f32>;
@group(1) @binding(1) var linear_clamp: sampler;
@group(1) @binding(2) var<uniform> coarse_level: CoarseLevel;

struct CoarseLevel {
    // 1 / the size in texels.
    inverse_size: vec2f,
    // 1 / that of the level below.
    inverse_finer_size: vec2f,
}

// What is no number must not reach its neighbours.
fn finer_at(uv: vec2f) -> vec4f {
    return clamp(textureSampleLevel(finer, linear_clamp, uv, 0.0), vec4f(0.0), vec4f(RADIANCE_MAX));
}

@fragment
fn fs_reflections_halve(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // Three quarters of a finer texel from the middle, linear filtering weighs two of them by three and one parts.
    let uv = position.xy * coarse_level.inverse_size;
    let step = 0.75 * coarse_level.inverse_finer_size;
    let across = vec2f(step.x, -step.y);
    return 0.25 * (finer_at(uv - step) + finer_at(uv + step) + finer_at(uv - across) + finer_at(uv + across));
}
