// What may be taken of radiance that an effect, or a sum of terms, left.

import package::constants::HALF_FLOAT_MAX;

// Neither infinite nor NaN, nor below 0, whatever was written.
fn scrubbed(texel: vec4f) -> vec4f {
    return min(max(texel, vec4f(0.0)), vec4f(HALF_FLOAT_MAX));
}
