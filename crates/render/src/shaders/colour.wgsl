// Transfer functions and the limits of the formats that hold colour.

import package::constants::{
    RADIANCE_MAX, SRGB_SLOPE, SRGB_LINEAR_END, SRGB_ENCODED_END, SRGB_OFFSET, SRGB_POWER,
};

fn half_float_clamped(radiance: vec3f) -> vec3f {
    return clamp(radiance, vec3f(0.0), vec3f(RADIANCE_MAX));
}

// IEC 61966-2-1.
fn srgb_from_linear(linear: vec3f) -> vec3f {
    let low = linear * SRGB_SLOPE;
    let power = pow(max(linear, vec3f(SRGB_LINEAR_END)), vec3f(1.0 / SRGB_POWER));
    return select((1.0 + SRGB_OFFSET) * power - SRGB_OFFSET, low, linear <= vec3f(SRGB_LINEAR_END));
}

fn linear_from_srgb(encoded: vec3f) -> vec3f {
    let low = encoded / SRGB_SLOPE;
    let root = (max(encoded, vec3f(SRGB_ENCODED_END)) + SRGB_OFFSET) / (1.0 + SRGB_OFFSET);
    return select(pow(root, vec3f(SRGB_POWER)), low, encoded <= vec3f(SRGB_ENCODED_END));
}
