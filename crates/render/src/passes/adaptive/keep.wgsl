// adaptive.keep: keeps the mean as it is now, to be compared with that of twice as many samples.
// Reads: the mean. Writes: the same in half floats.
// Program: adaptive_keep.

@group(1) @binding(0) var mean: texture_2d<f32>;

@fragment
fn fs_adaptive_keep(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return textureLoad(mean, vec2i(position.xy), 0);
}
