//! effect glow
//! reads: radiance
//! passes: fs_bright -> wide 1/2, fs_across -> wide 1/2 x rounds, fs_mix

// Glow around bright areas, as in fog or in an eye. Bright light is kept at half the size, blurred in rounds whose steps
// grow (Kawase 2003, "Frame Buffer Postprocessing Effects in DOUBLE-S.T.E.A.L"), and added.

struct Glow {
    /// The share of light that is spread, share
    // = 0.25 in 0..1
    strength: f32,
    /// The radiance above which light is spread, of white as it is exposed
    // = 0.8 in 0..
    threshold: f32,
    /// The number of blur rounds; more make a wider glow.
    // = 5 in 1..16
    rounds: u32,
    padding: f32,
}

@group(2) @binding(0) var<uniform> glow: Glow;

@fragment
fn fs_bright(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = textureSampleLevel(radiance, linear_clamp, uv_at(position.xy), 0.0);
    let brightest = max(max(here.r, here.g), max(here.b, 1e-6));
    return vec4f(here.rgb * max(1.0 - glow.threshold / brightest, 0.0), 1.0);
}

// The mean of four places, each between four texels, so that it is that of sixteen.
@fragment
fn fs_across(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let step = (f32(drawn.round) + 0.5) * drawn.inverse_size_px;
    let uv = uv_at(position.xy);
    var sum = textureSampleLevel(wide, linear_clamp, uv + step * vec2f(-1.0, -1.0), 0.0);
    sum += textureSampleLevel(wide, linear_clamp, uv + step * vec2f(1.0, -1.0), 0.0);
    sum += textureSampleLevel(wide, linear_clamp, uv + step * vec2f(-1.0, 1.0), 0.0);
    sum += textureSampleLevel(wide, linear_clamp, uv + step * vec2f(1.0, 1.0), 0.0);
    return 0.25 * sum;
}

@fragment
fn fs_mix(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = radiance_at(vec2i(position.xy));
    let added = glow.strength * textureSampleLevel(wide, linear_clamp, uv_at(position.xy), 0.0).rgb;
    // Where there is nothing, light covers what the picture is laid over, the more the brighter it is.
    let cover = 1.0 - exp(-max(added.r, max(added.g, added.b)));
    return vec4f(half_float_clamped(here.rgb + added), mix(cover, 1.0, here.a));
}
