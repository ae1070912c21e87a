//! effect film
//! reads: display
//! pixel: filmed

// The look of film on a finished picture: vignette, tint, saturation and grain.

struct Film {
    /// The tint of highlights, linear Rec. 709
    // = 1, 0.97, 0.9 in 0..2
    tint: vec3f,
    /// The vignette: the share of light that the corners lose, share
    // = 0.35 in 0..1
    vignette: f32,
    /// The saturation: how much colour is left, share
    // = 0.85 in 0..2
    saturation: f32,
    /// The standard deviation of the grain in the middle tones, 1/255
    // = 5 in 0..64
    grain: f32,
    padding_a: f32,
    padding_b: f32,
}

@group(2) @binding(0) var<uniform> film: Film;

// From 0 to 1, the same for the same pixel on every device (Jarzynski & Olano 2020, "Hash Functions for GPU
// Rendering").
fn noise(pixel: vec2u) -> f32 {
    let state = (pixel.x + pixel.y * 65536u) * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return f32((word >> 22u) ^ word) / 4294967296.0;
}

fn filmed(here: vec4f, position: vec2f) -> vec4f {
    let from_middle = uv_at(position) - 0.5;
    let darkened = here.rgb * film.tint * (1.0 - film.vignette * 2.0 * dot(from_middle, from_middle));
    let grey = dot(darkened, vec3f(0.2126, 0.7152, 0.0722));
    let color = max(mix(vec3f(grey), darkened, film.saturation), vec3f(0.0));
    // Of equal width in tones as displays encode them, which a square root is near to; black and white have none.
    let tone = sqrt(clamp(grey, 0.0, 1.0));
    let pixel = vec2u(position);
    // The sum of four has nearly a normal distribution, of standard deviation 1 / sqrt(3).
    var sum = -2.0;
    for (var i = 0u; i < 4u; i++) {
        sum += noise(pixel + vec2u(4099u * i, 0u));
    }
    let change = sum * sqrt(3.0) * film.grain / 255.0 * 4.0 * tone * (1.0 - tone);
    let grained = sqrt(color) + change;
    return vec4f(grained * abs(grained), here.a);
}
