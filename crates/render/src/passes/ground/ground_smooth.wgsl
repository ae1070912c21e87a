// ground.smooth: the map of the plane without the noise of its samples: of every texel the mean of five by five around
// it, those at the rim with half the weight. So every one of the 16 ways in which samples of `ground.map` lie counts the
// same.
// Source: a tent of the width of a pattern of 4 x 4, as is usual after occlusion in screen space; bilinear taps take the
// rim with its neighbours.
// Reads: shares. Writes: the same, smooth.
// Program: ground_smooth.

@group(1) @binding(0) var shares: texture_2d<f32>;
@group(1) @binding(1) var linear_clamp: sampler;

// Weights 1/2, 1, 1, 1, 1/2 of a line of texels: those of the two at a side lie at 4/3, with 3/2 together.
const SIDE_TEXELS: f32 = 1.3333333;
const SIDE_WEIGHT: f32 = 0.375;
const MIDDLE_WEIGHT: f32 = 0.25;

@fragment
fn fs_ground_smooth(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = 1.0 / vec2f(textureDimensions(shares));
    var sum = vec4f(0.0);
    for (var i = 0; i < 9; i++) {
        let at = vec2f(f32(i % 3) - 1.0, f32(i / 3) - 1.0);
        let weights = select(vec2f(MIDDLE_WEIGHT), vec2f(SIDE_WEIGHT), at != vec2f(0.0));
        let uv = (position.xy + at * SIDE_TEXELS) * texel;
        sum += textureSampleLevel(shares, linear_clamp, uv, 0.0) * weights.x * weights.y;
    }
    return sum;
}
