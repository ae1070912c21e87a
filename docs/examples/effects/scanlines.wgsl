//! effect scanlines
//! reads: display
//! pixel: lined

// Lines of a tube's screen, or a grid. Shows the word `pixel`: a function of one pixel alone. Neighbours of the chain
// that are such functions, too, share its pass.

struct Lines {
    /// Pixels from one line to the next, to the right and down; 1 has none, px
    // = 1, 3 in 1..64
    pitch_px: vec2u,
    /// How much light a line takes, share
    // = 0.6 in 0..1
    darkness: f32,
}

@group(2) @binding(0) var<uniform> lines: Lines;

fn lined(color: vec4f, position: vec2f) -> vec4f {
    let place = vec2u(position) % lines.pitch_px;
    let is_line = any(place >= (lines.pitch_px + 1u) / 2u);
    return vec4f(color.rgb * select(1.0, 1.0 - lines.darkness, is_line), color.a);
}
