// Faces of cube maps that are drawn.

// A face by its axes, so that no branch depends on its number.
struct CubeFace {
    // To the right; one divided by the side in texels.
    right: vec4f,
    // Down; zero.
    down: vec4f,
    // From the middle of the cube to that of the face; zero.
    forward: vec4f,
}

// The direction of a place in texels on a face. It is not of length 1.
fn cube_direction(face: CubeFace, position_px: vec2f) -> vec3f {
    let place = 2.0 * position_px * face.right.w - 1.0;
    return face.forward.xyz + place.x * face.right.xyz + place.y * face.down.xyz;
}
