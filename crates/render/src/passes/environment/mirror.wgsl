// environment.mirror: an equirectangular picture as an octahedral one, for mirrors and for the camera.
// Reads: equirectangular. Writes: the mirror's tile.
// Program: environment_mirror.

import package::passes::environment::equirectangular::equirectangular_at;
import package::shaders::octahedral::direction_from_octahedral_border;

struct EnvironmentTile {
    // The first texel behind the border, and one divided by the side in texels; zero.
    corner: vec4f,
}

@group(1) @binding(1) var<uniform> environment_tile: EnvironmentTile;

@fragment
fn fs_environment_mirror(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let tile = environment_tile.corner;
    let place = 2.0 * (position.xy - tile.xy) * tile.z - 1.0;
    return vec4f(equirectangular_at(direction_from_octahedral_border(place)), 1.0);
}
