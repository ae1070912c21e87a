// meter: radiance in a format that every backend can read back.
// Reads: radiance. Writes: meter (rgba32float, pre-exposed, associated alpha).
// Program: meter.

@group(1) @binding(0) var radiance: texture_2d<f32>;

@fragment
fn fs_meter(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return textureLoad(radiance, vec2i(position.xy), 0);
}
