//! effect trails
//! reads: display, previous

// What was bright stays a while, as on an old screen. Shows `previous`: what the effect itself made in the frame before
// of a live view or a sequence. A still has none, and stays as it is.

/// How much is left of the frame before, share
// = 0.85 in 0..0.99
@group(2) @binding(0) var<uniform> left: f32;

@fragment
fn fs_trails(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    return max(display_at(pixel), left * textureLoad(previous, pixel, 0));
}
