//! effect glitch
//! reads: display
//! fallback: none

// Rows of a broken signal: some bands slip sideways, and their colours part. Shows `fallback`: where time is short
// (`effects.fallbacks`) the effect is left out. Another `seed` in each frame makes it move.

struct Glitch {
    /// How far a band slips at the most, share of the width
    // = 0.08 in 0..1
    slip: f32,
    /// How many bands slip, share
    // = 0.4 in 0..1
    bands: f32,
    /// The height of a band, px
    // = 12 in 1..512
    band_px: u32,
    /// Which bands, and how far
    // = 1 in 0..65535
    seed: u32,
}

@group(2) @binding(0) var<uniform> glitch: Glitch;

// From 0 to 1, the same for the same number on every device.
fn noise(number: u32) -> f32 {
    let word = (number ^ (number >> 15u)) * 747796405u + 2891336453u;
    return f32(((word >> 13u) ^ word) * 277803737u >> 8u) / 16777216.0;
}

@fragment
fn fs_glitch(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let band = u32(pixel.y) / glitch.band_px * 2u + glitch.seed * 8192u;
    let slips = select(0.0, glitch.slip * drawn.size_px.x, noise(band) < glitch.bands);
    let slip = i32(slips * (2.0 * noise(band + 1u) - 1.0));
    let green = display_at(pixel + vec2i(slip, 0));
    let red = display_at(pixel + vec2i(slip + slip / 4, 0)).r;
    let blue = display_at(pixel + vec2i(slip - slip / 4, 0)).b;
    return vec4f(min(vec3f(red, green.g, blue), vec3f(green.a)), green.a);
}
