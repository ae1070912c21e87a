// tint: how much more, or less, of the background comes through than alpha says, by channel, and 1, so that it is above 0.
// Reads: transmittance, by channel and in alpha as coverage had it when it was drawn; radiance, of which alpha is the
// coverage at the end. What came over glass since covers all channels alike.
// Writes: tint.
// Program: tint.

@group(1) @binding(0) var transmittance: texture_2d<f32>;
@group(1) @binding(1) var radiance: texture_2d<f32>;

@fragment
fn fs_tint(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let through = textureLoad(transmittance, pixel, 0);
    let uncovered = 1.0 - clamp(textureLoad(radiance, pixel, 0).a, 0.0, 1.0);
    let share = select(vec3f(1.0), through.rgb / max(through.a, 1e-4), through.a > 1e-4);
    return vec4f(1.0 + uncovered * (share - 1.0), 1.0);
}
