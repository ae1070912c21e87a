// occlusion.blur: takes the pattern of noise of 4 × 4 texels out of a picture of few samples, by the mean over each
// such square of what lies on the same surface: near the tangent plane (Tomasi & Manduchi 1998, "Bilateral Filtering",
// by that distance in place of one of colours). Reads: noisy_occlusion, normal, linear_depth. Writes: occlusion, of the
// square from 2 texels before to 1 after.
// Program: occlusion_blur.

import package::constants::DISTANCE_BACKGROUND_M;
import package::passes::occlusion::taps::{likeness, middle_of_first_texel, side};
import package::shaders::coarse::pixel_of_texel;
import package::shaders::gbuffer_textures::distance_at;
import package::shaders::screen_space::{nearest_clamp, tangent_plane_at};

@group(1) @binding(5) var noisy_occlusion: texture_2d<f32>;

@fragment
fn fs_occlusion_blur(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = pixel_of_texel(vec2i(position.xy), i32(side));
    let distance_m = distance_at(pixel);
    let size = vec2f(textureDimensions(noisy_occlusion));
    let texel_size = 1.0 / size;
    let own = textureSampleLevel(noisy_occlusion, nearest_clamp, position.xy * texel_size, 0.0);
    if distance_m >= DISTANCE_BACKGROUND_M {
        return own;
    }
    let plane = tangent_plane_at(pixel, distance_m);
    let first = middle_of_first_texel();
    // The texel itself counts in any case.
    var sum = own * 1e-3;
    var weights = 1e-3;
    for (var y = -2; y < 2; y++) {
        for (var x = -2; x < 2; x++) {
            let middle = position.xy + vec2f(vec2i(x, y));
            let inside = all(middle > vec2f(0.0)) && all(middle < size);
            let weight = select(0.0, likeness(plane, max(middle - 0.5, vec2f(0.0)), first), inside);
            sum += textureSampleLevel(noisy_occlusion, nearest_clamp, middle * texel_size, 0.0) * weight;
            weights += weight;
        }
    }
    return sum / weights;
}
