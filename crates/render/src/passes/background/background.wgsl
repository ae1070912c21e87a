// background: what lies behind all surfaces, blended under `radiance` by its coverage.
// Reads: the environment. Writes: radiance.

import package::view::{view, ray_direction_world_from_pixel};
import package::shaders::environment::{environment, environment_radiance};
import package::shaders::colour::half_float_clamped;

@fragment
fn fs_background(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // As `box_count_for` explains, the branch depends on more than uniforms.
    if (position.x >= 0.0) & (environment.background.w > 0.5) {
        let radiance = environment_radiance(ray_direction_world_from_pixel(position.xy));
        return vec4f(half_float_clamped(radiance), 1.0);
    }
    return vec4f(environment.background.rgb, 1.0);
}
