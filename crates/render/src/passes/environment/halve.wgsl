// environment.halve: a face of a cube map at half the size.
// Reads: finer, one level of a cube map. Writes: a face of the next level.
// Program: environment_halve.

import package::shaders::cube::{CubeFace, cube_direction};

@group(1) @binding(0) var finer: texture_cube<f32>;
@group(1) @binding(1) var linear_clamp: sampler;
@group(1) @binding(2) var<uniform> cube_face: CubeFace;

@fragment
fn fs_environment_halve(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // The middle of a texel is the corner of four finer ones.
    return textureSampleLevel(finer, linear_clamp, cube_direction(cube_face, position.xy), 0.0);
}
