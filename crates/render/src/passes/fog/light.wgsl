// fog.light: light that fog scatters into the ray of every pixel, up to the surface that ends it. With `halves` one
// pixel of each two by two, another one in every sample.
// Reads: linear_depth, the tables of lights, clusters and shadows. Writes: pre-exposed radiance.
// Program: fog_light.

import package::view::{view, position_world_from_pixel, ray_direction_world_from_pixel};
import package::shaders::colour::half_float_clamped;
import package::shaders::fog::{fog, ray_length_m};
import package::shaders::fog_light::{interleaved_noise, light_in_fog};
import package::passes::fog::halves::SIDE;
import package::shaders::coarse::pixel_of_texel;

@group(1) @binding(1) var linear_depth: texture_2d<f32>;

// 1 if the target has half the width and height.
override halves: u32 = 0u;

@fragment
fn fs_fog_light(@builtin(position) position: vec4f) -> @location(0) vec4f {
    var position_px = position.xy;
    if halves != 0u {
        position_px = vec2f(pixel_of_texel(vec2i(position.xy), SIDE)) + 0.5;
    }
    let depth_m = textureLoad(linear_depth, vec2i(position_px), 0).r;
    let direction_world = ray_direction_world_from_pixel(position_px);
    let eye_world = position_world_from_pixel(position_px, 0.0);
    // Of a background, infinitely far away, no position is known.
    let surface_m = ray_length_m(position_world_from_pixel(position_px, min(depth_m, fog.far_m)));
    let length_m = select(fog.far_m, surface_m, depth_m <= fog.far_m);
    let noise = interleaved_noise(position.xy);
    let radiance = light_in_fog(position_px, noise, eye_world, direction_world, min(length_m, fog.far_m));
    return vec4f(half_float_clamped(radiance), 0.0);
}
