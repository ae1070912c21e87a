// gi.filter: takes the pattern of noise of 4 × 4 texels out of a picture of few samples (see `shaders/bilateral.wgsl`).
// Reads: noisy_light, normal, linear_depth. Writes: light, of the square from 2 texels before to 1 after.
// Program: gi_filter.

import package::constants::DISTANCE_BACKGROUND_M;
import package::passes::gi::gathered::{LIKENESS_REACH, side};
import package::shaders::bilateral::mean_of_square;
import package::shaders::coarse::pixel_of_texel;
import package::shaders::gbuffer_textures::distance_at;
import package::shaders::screen_space::tangent_plane_at;

@group(1) @binding(5) var noisy_light: texture_2d<f32>;

@fragment
fn fs_gi_filter(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = pixel_of_texel(vec2i(position.xy), i32(side));
    let distance_m = distance_at(pixel);
    if distance_m >= DISTANCE_BACKGROUND_M {
        return vec4f(0.0);
    }
    let plane = tangent_plane_at(pixel, distance_m);
    return mean_of_square(noisy_light, false, position.xy, side, plane, LIKENESS_REACH * distance_m);
}
