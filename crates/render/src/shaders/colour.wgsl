// Transfer functions and the limits of the formats that hold colour.

// Above this, rgba16float overflows on some drivers into infinity and from there into a NaN.
const HALF_FLOAT_MAX: f32 = 65000.0;
// A half float of which three, of emission, of the environment and of lights, add up without overflowing.
const RADIANCE_MAX: f32 = 20992.0;

fn half_float_clamped(radiance: vec3f) -> vec3f {
    return clamp(radiance, vec3f(0.0), vec3f(RADIANCE_MAX));
}

// IEC 61966-2-1.
fn srgb_from_linear(linear: vec3f) -> vec3f {
    let low = linear * 12.92;
    let high = 1.055 * pow(max(linear, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3f(0.0031308));
}

fn linear_from_srgb(encoded: vec3f) -> vec3f {
    let low = encoded / 12.92;
    let high = pow((max(encoded, vec3f(0.04045)) + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, encoded <= vec3f(0.04045));
}
