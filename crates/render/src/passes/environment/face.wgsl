// environment.face: an equirectangular picture as one face of a cube map, without suns.
// Reads: equirectangular. Writes: a face of the finest level.
// Program: environment_face.

import package::passes::environment::equirectangular::equirectangular_at;
import package::shaders::cube::{CubeFace, cube_direction};
import package::shaders::environment_suns::{EnvironmentSun, sun_cut};

struct EnvironmentFace {
    face: CubeFace,
    suns: array<EnvironmentSun, 4>,
}

@group(1) @binding(1) var<uniform> environment_face: EnvironmentFace;

@fragment
fn fs_environment_face(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let direction = normalize(cube_direction(environment_face.face, position.xy));
    var radiance = equirectangular_at(direction);
    radiance = sun_cut(environment_face.suns[0], direction, radiance);
    radiance = sun_cut(environment_face.suns[1], direction, radiance);
    radiance = sun_cut(environment_face.suns[2], direction, radiance);
    radiance = sun_cut(environment_face.suns[3], direction, radiance);
    return vec4f(radiance, 1.0);
}
