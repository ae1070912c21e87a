//! effect echo
//! reads: radiance, previous
// Adds a share of what it made in the frame before.

struct Echo {
    /// How much of the frame before stays, share
    // = 0.5 in 0..1
    share: f32,
    // Uniforms of WebGL 2 are multiples of 16 bytes.
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

@group(2) @binding(0) var<uniform> echo: Echo;

@fragment
fn fs_echo(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = radiance_at(pixel);
    return vec4f(here.rgb + previous_at(pixel).rgb * echo.share, here.a);
}
