//! effect sharpen
//! reads: display

// Sharpening: raises the contrast between neighbours, less where it is strong already, and never beyond the neighbours'
// range (after Lottes 2019, "FidelityFX Contrast Adaptive Sharpening").

/// The strength, share
// = 0.6 in 0..1
@group(2) @binding(0) var<uniform> strength: f32;

@fragment
fn fs_sharpen(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = display_at(pixel);
    let above = display_at(pixel + vec2i(0, -1)).rgb;
    let below = display_at(pixel + vec2i(0, 1)).rgb;
    let left = display_at(pixel + vec2i(-1, 0)).rgb;
    let right = display_at(pixel + vec2i(1, 0)).rgb;
    let lowest = min(here.rgb, min(min(above, below), min(left, right)));
    let highest = max(here.rgb, max(max(above, below), max(left, right)));
    let room = clamp(min(lowest, 1.0 - highest) / max(highest, vec3f(1e-4)), vec3f(0.0), vec3f(1.0));
    let weight = -sqrt(room) * mix(0.125, 0.2, strength) * step(1e-6, strength);
    let sum = here.rgb + (above + below + left + right) * weight;
    return vec4f(clamp(sum / (1.0 + 4.0 * weight), lowest, highest), here.a);
}
