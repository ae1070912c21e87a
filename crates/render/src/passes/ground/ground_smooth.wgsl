// ground.smooth: the map of the plane without the noise of its samples: of every texel the mean of four places around
// it.
// Source: a blur of about 3x3 texels by four bilinear taps, three quarters of a texel away on the diagonals.
// Reads: shares. Writes: the same, smooth.
// Program: ground_smooth.

import package::constants::GROUND_MAP_SIDE;

@group(1) @binding(0) var shares: texture_2d<f32>;
@group(1) @binding(1) var linear_clamp: sampler;

@fragment
fn fs_ground_smooth(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = position.xy / GROUND_MAP_SIDE;
    let step = 0.75 / GROUND_MAP_SIDE;
    let sum = textureSampleLevel(shares, linear_clamp, uv + step, 0.0)
        + textureSampleLevel(shares, linear_clamp, uv - step, 0.0)
        + textureSampleLevel(shares, linear_clamp, uv + vec2f(step, -step), 0.0)
        + textureSampleLevel(shares, linear_clamp, uv - vec2f(step, -step), 0.0);
    return 0.25 * sum;
}
