// background: the backdrop of the environment, where there is no opaque surface.
// Reads: the environment. Writes: radiance.
// Program: background.

import package::constants::ENVIRONMENT_ROUGHNESS_FIRST;
import package::view::{view, ray_direction_world_from_pixel};
import package::shaders::environment::{
    environment_backdrop, environment_reflection, picture_backdrop, shows_picture,
};
import package::shaders::colour::half_float_clamped;
import package::shaders::glow::glow_share;

// Of the first level that has none.
const WITHOUT_SUNS: f32 = ENVIRONMENT_ROUGHNESS_FIRST * ENVIRONMENT_ROUGHNESS_FIRST;

// 1 if it is what surfaces get light of, as mirrors and surroundings have it; 2 if that is without suns.
override shows_light: u32 = 0u;

@fragment
fn fs_background(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // Where the ray is 1 m ahead of the eye, height depends on the row of pixels alone while the camera's right is
    // level: the backdrop is made of straight bands, not of the arcs that equal elevations are.
    let ray_world = ray_direction_world_from_pixel(position.xy);
    if shows_light != 0u {
        let alpha = select(0.0, WITHOUT_SUNS, shows_light == 2u);
        return vec4f(half_float_clamped(environment_reflection(ray_world, alpha)), 1.0);
    }
    if shows_picture != 0u {
        return vec4f(half_float_clamped(picture_backdrop(ray_world)), 1.0);
    }
    let ahead = dot(ray_world, -view.world_from_view[2].xyz);
    let height = ray_world.y / max(ahead, 1e-3);
    let radiance = half_float_clamped(environment_backdrop(height * inverseSqrt(1.0 + height * height)));
    return vec4f(radiance, 1.0 + glow_share(radiance));
}
