// environment.halve: a face of a cube map at half the size.
// Reads: finer, one level of a cube map. Writes: a face of the next level.
// Program: environment_halve.

import package::shaders::cube::{CubeFace, cube_direction};

@group(1) @binding(0) var finer: texture_cube<f32>;
@group(1) @binding(1) var linear_clamp: sampler;
@group(1) @binding(2) var<uniform> cube_face: CubeFace;

// A place in texels on the face, with the solid angle of finer texels there as its weight. On the cube a texel's solid
// angle goes with the third power of the direction's largest component.
fn weighted(position_px: vec2f) -> vec4f {
    let direction = normalize(cube_direction(cube_face, position_px));
    let largest = max(max(abs(direction.x), abs(direction.y)), abs(direction.z));
    let weight = largest * largest * largest;
    return vec4f(textureSampleLevel(finer, linear_clamp, direction, 0.0).rgb * weight, weight);
}

@fragment
fn fs_environment_halve(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // One, three, three and one parts of four finer texels in each direction: what is small stays where it is, because
    // the means of places are kept. A sample there lies between two texels.
    let sum = weighted(position.xy + vec2f(-0.375, -0.375)) + weighted(position.xy + vec2f(0.375, -0.375))
        + weighted(position.xy + vec2f(-0.375, 0.375)) + weighted(position.xy + vec2f(0.375, 0.375));
    return vec4f(sum.rgb / sum.w, 1.0);
}
