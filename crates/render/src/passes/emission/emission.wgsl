// emission: keeps what surfaces emit, before light is added to it.
// Reads: radiance as `geometry` or `coverage` begins it. Writes: emission (pre-exposed).
// Program: emission.

@group(1) @binding(0) var radiance: texture_2d<f32>;

@fragment
fn fs_emission(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return textureLoad(radiance, vec2i(position.xy), 0);
}
