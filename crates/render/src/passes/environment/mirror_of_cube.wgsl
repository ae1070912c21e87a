// environment.mirror: a cube map as an octahedral one, for mirrors.
// Reads: source (a cube map). Writes: the mirror's tile.
// Program: environment_mirror_of_cube.

import package::passes::environment::mirror::EnvironmentTile;
import package::shaders::octahedral::direction_from_octahedral_border;

@group(1) @binding(0) var source: texture_cube<f32>;
@group(1) @binding(1) var<uniform> environment_tile: EnvironmentTile;
@group(1) @binding(2) var linear_clamp: sampler;

@fragment
fn fs_environment_mirror_of_cube(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let tile = environment_tile.corner;
    let place = 2.0 * (position.xy - tile.xy) * tile.z - 1.0;
    let direction = direction_from_octahedral_border(place);
    return vec4f(textureSampleLevel(source, linear_clamp, direction, 0.0).rgb, 1.0);
}
