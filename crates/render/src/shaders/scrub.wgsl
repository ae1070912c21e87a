// What may be taken of radiance that an effect, or a sum of terms, left.

import package::constants::HALF_FLOAT_MAX;

// Neither infinite nor NaN, nor below 0, whatever was written.
fn scrubbed(texel: vec4f) -> vec4f {
    return min(max(texel, vec4f(0.0)), vec4f(HALF_FLOAT_MAX));
}

// Told by the bits of the exponent, because compilers take it that `x == x`.
fn is_finite(texel: vec4f) -> bool {
    return all((bitcast<vec4u>(texel) & vec4u(0x7f800000u)) != vec4u(0x7f800000u));
}
