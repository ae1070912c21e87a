// accumulate: the mean of this frame and those before it, in linear light (ping-pong).
// Where the frame was shaded at another size than the picture's (`scaled`), radiance is filtered linearly.
// Reads: radiance, the previous mean. Writes: the next mean (rgba32float, associated alpha).

struct Accumulation {
    // The weight of this frame: 1 / number of frames so far.
    weight: f32,
    // The weight of the mean before it; 0 for the first frame, which has none.
    keep: f32,
    // 1 / width and height of the picture, which need not be the size at which the frame was shaded.
    inverse_size_px: vec2f,
}

@group(1) @binding(0) var<uniform> accumulation: Accumulation;
@group(1) @binding(1) var radiance: texture_2d<f32>;
@group(1) @binding(2) var previous: texture_2d<f32>;
@if(scaled) @group(0) @binding(2) var linear_clamp: sampler;

fn radiance_at(position_px: vec2f) -> vec4f {
    @if(scaled) {
        return textureSampleLevel(radiance, linear_clamp, position_px * accumulation.inverse_size_px, 0.0);
    }
    @if(!scaled) {
        return textureLoad(radiance, vec2i(position_px), 0);
    }
}

@fragment
fn fs_accumulate(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let share = radiance_at(position.xy) * accumulation.weight;
    if (position.x >= 0.0) & (accumulation.keep <= 0.0) {
        return share;
    }
    return textureLoad(previous, pixel, 0) * accumulation.keep + share;
}
