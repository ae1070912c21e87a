// background: the backdrop of the environment behind all surfaces, blended under `radiance` by its coverage.
// Reads: the environment. Writes: radiance.

import package::view::{view, ray_direction_world_from_pixel};
import package::shaders::environment::environment_backdrop;
import package::shaders::colour::half_float_clamped;

@fragment
fn fs_background(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(half_float_clamped(environment_backdrop(ray_direction_world_from_pixel(position.xy))), 1.0);
}
