//! effect echo
//! reads: radiance, previous
// Adds a share of what it made in the frame before.

struct Echo {
    /// How much of the frame before stays, share
    // = 0.5 in 0..1
    share: f32,
}

// Neither of these is a multiple of 16 bytes, as WebGL 2 wants uniforms: they are filled up there.
@group(2) @binding(0) var<uniform> echo: Echo;
/// How bright the picture is, share
// = 1 in 0..
@group(2) @binding(1) var<uniform> gain: f32;

@fragment
fn fs_echo(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = radiance_at(pixel);
    // Two that are as bright as half floats hold are more than those hold.
    return vec4f(half_float_clamped(here.rgb * gain + previous_at(pixel).rgb * echo.share), here.a);
}
