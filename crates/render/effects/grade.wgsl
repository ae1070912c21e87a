//! effect grade
//! reads: radiance
//! pixel: graded_light

// Colour grading of radiance, before the tone curve: white balance, gain, gamma and lift, contrast, saturation. Radiance
// has no upper limit here: brighter values roll off by the tone curve, and no colour is clipped. White balance undoes a
// coloured lamp exactly, because the lamp multiplies radiance; after the curve this would be lost.
// Sources: Krystek 1985 (colours of black bodies), Li et al. 2017, "CAM16" (adaptation: CAT16, complete), ASC Color
// Decision List 1.2 (gain is its slope, lift its offset, 1 / gamma its power).

struct Grade {
    /// White balance: the colour temperature that looks white; below 6500 the picture gets bluer, K
    // = 6500 in 1500..15000
    temperature_k: f32,
    /// White balance: how far the colour that looks white lies on the green side of black bodies; more is more purple, 0.001 Duv
    // = 0 in -50..50
    tint: f32,
    /// Contrast around mid grey (0.18), power
    // = 1 in 0..4
    contrast: f32,
    /// The saturation: how much colour is left, share
    // = 1 in 0..4
    saturation: f32,
    /// The gain: multiplies each channel, factor
    // = 1, 1, 1 in 0..16
    gain: vec3f,
    padding_a: f32,
    /// The gamma: above 1 it brightens what is darker than exposed white and darkens what is brighter, 1 / power
    // = 1, 1, 1 in 0.1..10
    gamma: vec3f,
    padding_b: f32,
    /// The lift: is added after gain and before gamma, of white as it is exposed
    // = 0, 0, 0 in -1..1
    lift: vec3f,
    padding_c: f32,
}

@group(2) @binding(0) var<uniform> grade: Grade;

const MID_GREY: f32 = 0.18;
// The temperature on the scale of `temperature_k` that changes nothing.
const NEUTRAL_K: f32 = 6500.0;

// From linear Rec. 709 by XYZ to the responses of CAT16, and back.
const RESPONSE_FROM_REC709 = mat3x3f(
    vec3f(0.3027448, 0.1537836, 0.0279765),
    vec3f(0.6023438, 0.7773328, 0.1478733),
    vec3f(0.0704469, 0.0853666, 0.9091366),
);
const REC709_FROM_RESPONSE = mat3x3f(
    vec3f(5.4470279, -1.0784685, 0.0077965),
    vec3f(-4.2158346, 2.1445493, -0.2190841),
    vec3f(-0.0262173, -0.1178019, 1.1199123),
);

// Where black bodies lie in the CIE 1960 diagram, within 0.0001 from 1,000 to 15,000 K.
fn black_body_uv(temperature_k: f32) -> vec2f {
    let powers = vec3f(1.0, temperature_k, temperature_k * temperature_k);
    let u = dot(vec3f(0.860117757, 1.54118254e-4, 1.28641212e-7), powers)
        / dot(vec3f(1.0, 8.42420235e-4, 7.08145163e-7), powers);
    let v = dot(vec3f(0.317398726, 4.22806245e-5, 4.20481691e-8), powers)
        / dot(vec3f(1.0, -2.89741816e-5, 1.61456053e-7), powers);
    return vec2f(u, v);
}

// What cones respond to light of luminance 1.
fn response(uv: vec2f) -> vec3f {
    let xyz = vec3f(1.5 * uv.x, uv.y, 2.0 - 0.5 * uv.x - 5.0 * uv.y) / uv.y;
    return mat3x3f(
        vec3f(0.401288, -0.250268, -0.002079),
        vec3f(0.650173, 1.204414, 0.048952),
        vec3f(-0.051461, 0.045854, 0.953127),
    ) * xyz;
}

// By how much each response is multiplied so that the chosen light becomes white.
fn adaptation() -> vec3f {
    let here = black_body_uv(grade.temperature_k);
    // Across the line of black bodies, towards green.
    let along = normalize(black_body_uv(grade.temperature_k + 10.0) - black_body_uv(grade.temperature_k - 10.0));
    let light = here + vec2f(along.y, -along.x) * grade.tint * 0.001;
    return response(black_body_uv(NEUTRAL_K)) / response(light);
}

fn graded_light(here: vec4f, position: vec2f) -> vec4f {
    // What shines without covering anything is graded as if it did.
    let cover = select(1.0, here.a, here.a > 0.001);
    let balanced = REC709_FROM_RESPONSE * (adaptation() * (RESPONSE_FROM_REC709 * here.rgb / cover));
    let light = max(balanced * grade.gain + grade.lift * min(here.a * 1000.0, 1.0), vec3f(0.0));
    // Both powers at once: of 1 / gamma, and that of contrast around mid grey.
    let graded = pow(light, vec3f(grade.contrast) / grade.gamma) * pow(MID_GREY, 1.0 - grade.contrast);
    let grey = dot(graded, vec3f(0.2126, 0.7152, 0.0722));
    return vec4f(half_float_clamped(mix(vec3f(grey), graded, grade.saturation) * cover), here.a);
}
