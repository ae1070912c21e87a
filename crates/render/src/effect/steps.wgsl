// What an effect of several passes finds declared beside the prelude: what the pass draws into.

struct Drawn {
    // Width and height of what this pass draws into, in texels.
    size_px: vec2f,
    // 1 / size_px.
    inverse_size_px: vec2f,
    // How often the pass was drawn before in this frame, and how often it is drawn in all.
    round: u32,
    rounds: u32,
    // Uniforms of WebGL 2 are multiples of 16 bytes.
    padding: vec2f,
}

@group(1) @binding(8) var<uniform> drawn: Drawn;

// From `@builtin(position)` to texture coordinates, of any pass.
fn uv_at(position_px: vec2f) -> vec2f {
    return position_px * drawn.inverse_size_px;
}
