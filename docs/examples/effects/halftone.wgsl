//! effect halftone
//! reads: display

// Dots of three inks in screens that are turned against each other, as in print. Shows settings that are vectors, and a
// function of one's own.

struct Print {
    /// How white the paper is, linear Rec. 709
    // = 1, 1, 0.96 in 0..1
    paper: vec3f,
    /// From dot to dot, px
    // = 6 in 2..64
    pitch_px: f32,
    /// How the screens of cyan, magenta and yellow are turned, degrees
    // = 15, 75, 0 in -180..180
    angles_deg: vec3f,
}

@group(2) @binding(0) var<uniform> print: Print;

// How much of the light of one channel the paper sends back: none where there is a dot of its ink.
fn light(position: vec2f, channel: u32) -> f32 {
    let angle = radians(print.angles_deg[channel]);
    let turned = mat2x2f(cos(angle), -sin(angle), sin(angle), cos(angle));
    let place = position * turned / print.pitch_px;
    let middle = turned * (floor(place) + 0.5) * print.pitch_px;
    let ink = 1.0 - sqrt(clamp(display_at(vec2i(middle))[channel], 0.0, 1.0));
    // From 0 in the middle of a dot to 1 between four of them: dots that grow until only holes are left.
    let wave = cos(6.2832 * place);
    let height = 0.5 + 0.25 * (wave.x + wave.y);
    return clamp((height - ink) * print.pitch_px * 0.6 + 0.5, 0.0, 1.0);
}

@fragment
fn fs_halftone(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let inks = vec3f(light(position.xy, 0u), light(position.xy, 1u), light(position.xy, 2u));
    let alpha = display_at(vec2i(position.xy)).a;
    return vec4f(inks * print.paper * alpha, alpha);
}
