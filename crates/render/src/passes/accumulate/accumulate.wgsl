// accumulate: the mean of this frame and those before it (ping-pong), in linear light: of the display's colours after
// the tone curve, so that edges of bright surfaces are smooth, or, with `of_radiance`, of radiance for linear files.
// Where the frame was shaded at another size than the picture's (`scaled`), radiance is filtered linearly. Where lights
// take turns (`marked`), the mean may be of a part of every sample: of what glows (`shaders/glow.wgsl`), or of all
// else.
// Reads: radiance, the previous mean. Writes: the next mean (rgba32float, associated alpha). A mean of radiance has
// negative alpha where a sample reached the limit of half floats or was no number: its value is too small.
// Program: accumulate.

import package::constants::RADIANCE_MAX;
import package::shaders::scrub::{is_finite, scrubbed};
import package::shaders::tone_curve::display_linear;

struct Accumulation {
    // The weight of this frame: 1 / number of frames so far.
    weight: f32,
    // The weight of the mean before it; 0 for the first frame, which has none.
    keep: f32,
    // 1 / width and height of the picture, which need not be the size at which the frame was shaded.
    inverse_size_px: vec2f,
    // From pre-exposed radiance to what the tone curve takes.
    exposure: f32,
    // How much of a sample counts that does not glow, and how much more of one that does.
    share: f32,
    share_of_glow: f32,
    // Uniforms of WebGL 2 are multiples of 16 bytes.
    padding: f32,
}

@group(1) @binding(0) var<uniform> accumulation: Accumulation;
@group(1) @binding(1) var radiance: texture_2d<f32>;
@group(1) @binding(2) var previous: texture_2d<f32>;
@group(0) @binding(2) var linear_clamp: sampler;

// 1 if radiance has another size than the picture.
override scaled: u32 = 0u;
// 1 if what glows is marked, and the mean may be of a part.
override marked: u32 = 0u;
// 1 if the mean is of radiance.
override of_radiance: u32 = 0u;

fn whole_at(position_px: vec2f) -> vec4f {
    if scaled != 0u {
        return textureSampleLevel(radiance, linear_clamp, position_px * accumulation.inverse_size_px, 0.0);
    }
    return textureLoad(radiance, vec2i(position_px), 0);
}

// The part of a texel that this is the mean of, with coverage as alpha.
fn part_at(pixel: vec2i) -> vec4f {
    let texel = textureLoad(radiance, pixel, 0);
    let glow = clamp(texel.a - 1.0, 0.0, 1.0);
    return vec4f(texel.rgb, min(texel.a, 1.0)) * (accumulation.share + accumulation.share_of_glow * glow);
}

// Filtered after texels were divided into parts: a mean of marks is none.
fn marked_at(position_px: vec2f) -> vec4f {
    if scaled != 0u {
        let size = vec2i(textureDimensions(radiance));
        let place = position_px * accumulation.inverse_size_px * vec2f(size) - 0.5;
        let first = vec2i(floor(place));
        let between = place - floor(place);
        var sum = vec4f(0.0);
        for (var i = 0; i < 4; i++) {
            let step = vec2i(i & 1, i >> 1u);
            let near = select(1.0 - between, between, step == vec2i(1));
            sum += part_at(clamp(first + step, vec2i(0), size - 1)) * (near.x * near.y);
        }
        return sum;
    }
    return part_at(vec2i(position_px));
}

fn radiance_at(position_px: vec2f) -> vec4f {
    if marked != 0u {
        return marked_at(position_px);
    }
    return whole_at(position_px);
}

@fragment
fn fs_accumulate(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = radiance_at(position.xy);
    // So that the mean is never spoilt for good.
    let sample = scrubbed(texel);
    var before = vec4f(0.0);
    // What was never written may be a NaN. The branch depends on more than uniforms, see docs/decisions/006.
    if (position.x >= 0.0) & (accumulation.keep > 0.0) {
        before = textureLoad(previous, vec2i(position.xy), 0) * accumulation.keep;
    }
    if of_radiance != 0u {
        let mean = vec4f(before.rgb, abs(before.a)) + sample * accumulation.weight;
        // The limit is that of a surface as it was shaded; alpha is how much of it is here.
        let brightest = max(sample.r, max(sample.g, sample.b));
        let is_at_limit = brightest >= 0.999 * RADIANCE_MAX * max(sample.a, 1e-3);
        let is_clamped = (before.a < 0.0) | is_at_limit | !is_finite(texel);
        return vec4f(mean.rgb, select(mean.a, -mean.a, is_clamped));
    }
    let display = display_linear(sample.rgb / max(sample.a, 1e-6) * accumulation.exposure) * sample.a;
    return before + vec4f(display, sample.a) * accumulation.weight;
}
