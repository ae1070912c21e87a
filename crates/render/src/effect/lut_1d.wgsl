//! effect NAME
//! reads: display
//! pixel: graded

// Colours by a curve of SIZE entries for each channel. It is of colours as displays encode them (sRGB).

/// How much of the curve's colour is taken, share
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

fn entry(index: i32) -> vec3f {
    return textureLoad(TABLE, vec3i(index % 256, index / 256, 0), 0).rgb;
}

fn looked_up(color: vec3f) -> vec3f {
    let within = clamp((color - DOMAIN_LEAST) / (DOMAIN_MOST - DOMAIN_LEAST), vec3f(0.0), vec3f(1.0));
    let place = within * f32(SIZE - 1);
    let first = min(vec3i(place), vec3i(SIZE - 2));
    let part = place - vec3f(first);
    return vec3f(
        mix(entry(first.r).r, entry(first.r + 1).r, part.r),
        mix(entry(first.g).g, entry(first.g + 1).g, part.g),
        mix(entry(first.b).b, entry(first.b + 1).b, part.b),
    );
}

fn graded(color: vec4f, position: vec2f) -> vec4f {
    let plain = color.rgb / max(color.a, 1e-4);
    return vec4f(mix(plain, decoded(looked_up(encoded(plain))), strength) * color.a, color.a);
}
