//! effect NAME
//! reads: display
//! pixel: graded

// Colours by what a file says of them; it is of colours as displays encode them (sRGB, IEC 61966-2-1).

/// How much of the file's colour is taken, share
// = 1 in 0..1
@group(2) @binding(0) var<uniform> strength: f32;

fn encoded(color: vec3f) -> vec3f {
    let low = color * 12.92;
    let high = 1.055 * pow(max(color, vec3f(1e-6)), vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, color <= vec3f(0.0031308));
}

fn decoded(color: vec3f) -> vec3f {
    let positive = max(color, vec3f(0.0));
    let high = pow((positive + 0.055) / 1.055, vec3f(2.4));
    return select(high, positive / 12.92, positive <= vec3f(0.04045));
}

fn graded(color: vec4f, position: vec2f) -> vec4f {
    let plain = color.rgb / max(color.a, 1e-4);
    return vec4f(mix(plain, decoded(looked_up(encoded(plain))), strength) * color.a, color.a);
}
