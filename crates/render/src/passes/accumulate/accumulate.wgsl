// accumulate: adds this frame's share to the sum of the frames before it, in linear light (ping-pong).
// Reads: radiance, the previous sum. Writes: the next sum (rgba32float, associated alpha).


struct Accumulation {
    // The weight of this frame: 1 / number of frames.
    weight: f32,
    // 0 for the first frame, whose previous sum is undefined, else 1.
    keep: f32,
    padding: vec2f,
}

@group(1) @binding(0) var<uniform> accumulation: Accumulation;
@group(1) @binding(1) var radiance: texture_2d<f32>;
@group(1) @binding(2) var previous: texture_2d<f32>;

@fragment
fn fs_accumulate(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let share = textureLoad(radiance, pixel, 0) * accumulation.weight;
    if (position.x >= 0.0) & (accumulation.keep < 0.5) {
        return share;
    }
    return textureLoad(previous, pixel, 0) + share;
}
