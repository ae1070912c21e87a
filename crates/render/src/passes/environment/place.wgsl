// environment.place: a picture of a view as one face of a cube map.
// Reads: view_radiance. Writes: a face of the finest level.
// Program: environment_place.

import package::shaders::colour::half_float_clamped;

@group(1) @binding(0) var view_radiance: texture_2d<f32>;

@fragment
fn fs_environment_place(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(half_float_clamped(textureLoad(view_radiance, vec2i(position.xy), 0).rgb), 1.0);
}
