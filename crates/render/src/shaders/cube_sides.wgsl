// The six sides of what is to be seen around a place, beside each other in one texture.

import package::constants::PROBE_FACE_SIDE;

// The axes of the sides: to the right, down, and from the place to the middle.
struct CubeSides {
    right: array<vec4f, 6>,
    down: array<vec4f, 6>,
    forward: array<vec4f, 6>,
}

// The direction of a place on a side, in texels. It is not of length 1.
fn side_direction(sides: CubeSides, face: u32, place_px: vec2f) -> vec3f {
    let place = place_px * (2.0 / f32(PROBE_FACE_SIDE)) - 1.0;
    return sides.forward[face].xyz + place.x * sides.right[face].xyz + place.y * sides.down[face].xyz;
}

// The place of a direction in the texture, in texels. The sides are those of +X, -X, +Y, -Y, +Z and -Z.
fn texel_of_direction(sides: CubeSides, direction: vec3f) -> vec2f {
    let size = abs(direction);
    let is_x = size.x >= size.y && size.x >= size.z;
    let is_y = !is_x && size.y >= size.z;
    let along = select(select(direction.z, direction.y, is_y), direction.x, is_x);
    let face = select(select(4u, 2u, is_y), 0u, is_x) + select(0u, 1u, along < 0.0);
    let ahead = max(abs(along), 1e-6);
    let place = vec2f(dot(direction, sides.right[face].xyz), dot(direction, sides.down[face].xyz)) / ahead;
    let side = f32(PROBE_FACE_SIDE);
    let px = clamp((0.5 * place + 0.5) * side, vec2f(0.0), vec2f(side - 0.01));
    return px + vec2f(f32(face) * side, 0.0);
}
