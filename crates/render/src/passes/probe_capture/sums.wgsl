// probe_capture.sums: what the columns of the sides around a probe add to each coefficient of its light.
// Reads: probe_sides (the six sides beside each other). Writes: radiance by a polynomial of its direction, of a column of
// texels in each texel, a polynomial in each row.
// Program: probe_sums.

import package::constants::{HALF_LARGEST, PROBE_FACE_SIDE};
import package::shaders::cube_sides::{CubeSides, side_direction};

struct ProbeSums {
    // What makes the sum over all texels an integral over all directions; zeros.
    scale: vec4f,
    // The axes of the sides.
    sides: CubeSides,
}

@group(1) @binding(0) var probe_sides: texture_2d<f32>;
@group(1) @binding(1) var<uniform> probe_sums: ProbeSums;

// 1, y, z, x, xy, yz, 3 z² - 1, xz or x² - y².
fn polynomial(index: u32, d: vec3f) -> f32 {
    let first = select(select(select(d.x, d.z, index == 2u), d.y, index == 1u), 1.0, index == 0u);
    let mixed = select(select(d.x * d.z, d.y * d.z, index == 5u), d.x * d.y, index == 4u);
    let squares = select(d.x * d.x - d.y * d.y, 3.0 * d.z * d.z - 1.0, index == 6u);
    return select(select(mixed, squares, index == 6u || index == 8u), first, index < 4u);
}

@fragment
fn fs_probe_sums(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = vec2u(position.xy);
    let face = place.x / PROBE_FACE_SIDE;
    let column = place.x - face * PROBE_FACE_SIDE;
    var sum = vec3f(0.0);
    for (var y = 0u; y < PROBE_FACE_SIDE; y++) {
        let away = side_direction(probe_sums.sides, face, vec2f(vec2u(column, y)) + 0.5);
        let inverse = inverseSqrt(dot(away, away));
        // As the solid angle of the texel is.
        let weight = inverse * inverse * inverse * polynomial(place.y, away * inverse);
        sum += weight * textureLoad(probe_sides, vec2u(place.x, y), 0).rgb;
    }
    return vec4f(clamp(sum * probe_sums.scale.x, vec3f(-HALF_LARGEST), vec3f(HALF_LARGEST)), 1.0);
}
