// occlusion.blur: takes the pattern of noise of 4 × 4 texels out of a picture of few samples, by the mean over each
// such square of what lies on the same surface (see `shaders/bilateral.wgsl`). Reads: noisy_occlusion, normal,
// linear_depth. Writes: occlusion, of the square from 2 texels before to 1 after; with `keeps_distances` also how far away
// its surface is (g).
// Program: occlusion_blur.

import package::constants::DISTANCE_BACKGROUND_M;
import package::passes::occlusion::taps::{has_distances, likeness_reach_m, side, stand_of_texel};
import package::shaders::bilateral::mean_of_square;
import package::shaders::gbuffer_textures::normal_world_at;
import package::shaders::screen_space::tangent_plane_of;

@group(1) @binding(5) var noisy_occlusion: texture_2d<f32>;

// 1 if whoever reads what is written looks for distances in it.
override keeps_distances: u32 = 0u;

@fragment
fn fs_occlusion_blur(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let stand = stand_of_texel(vec2i(position.xy));
    let distance_m = stand.distance_m;
    if distance_m >= DISTANCE_BACKGROUND_M {
        return vec4f(1.0, select(0.0, DISTANCE_BACKGROUND_M, keeps_distances != 0u), 0.0, 0.0);
    }
    let plane = tangent_plane_of(normal_world_at(stand.normal_pixel), vec2f(stand.pixel) + 0.5, distance_m);
    let mean = mean_of_square(noisy_occlusion, has_distances != 0u, position.xy, side, plane, likeness_reach_m());
    if keeps_distances != 0u {
        return vec4f(mean.r, distance_m, 0.0, 0.0);
    }
    return mean;
}
