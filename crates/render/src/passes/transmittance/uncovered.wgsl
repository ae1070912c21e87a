// uncovered: how much of the background comes through what is there so far.
// Reads: radiance, of which alpha is coverage. Writes: transmittance, by channel, and in alpha as coverage says.
// Program: uncovered.

@group(1) @binding(0) var radiance: texture_2d<f32>;

@fragment
fn fs_uncovered(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(1.0 - clamp(textureLoad(radiance, vec2i(position.xy), 0).a, 0.0, 1.0));
}
