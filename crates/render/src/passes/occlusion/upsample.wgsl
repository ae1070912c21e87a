// occlusion.upsample: occlusion at the full size, from the four nearest texels of a smaller picture (see
// `shaders/bilateral.wgsl`). With `keeps_mean` it is the mean with what earlier samples of a still left of the pixel.
// Reads: coarse_occlusion, previous_occlusion, normal, linear_depth. Writes: occlusion; with `keeps_mean` also of how
// many samples it is (g).
// Program: occlusion_upsample.

import package::constants::DISTANCE_BACKGROUND_M;
import package::passes::occlusion::taps::{has_distances, likeness_reach_m, patterned, side};
import package::shaders::bilateral::{Upsampled, upsampled};
import package::shaders::gbuffer_textures::distance_at;
import package::shaders::screen_space::tangent_plane_at;

@group(1) @binding(5) var coarse_occlusion: texture_2d<f32>;
@group(1) @binding(6) var previous_occlusion: texture_2d<f32>;

// 1 in the first of the samples whose mean is kept, 2 in those that follow it.
override keeps_mean: u32 = 0u;

fn upsampled_at(position_px: vec2f, distance_m: f32) -> Upsampled {
    let plane = tangent_plane_at(vec2i(position_px), distance_m);
    // A filtered texel is the mean of a square whose middle lies half a texel before its own.
    let shift = select(0.0, 0.5, patterned != 0u);
    return upsampled(coarse_occlusion, has_distances != 0u, position_px, side, shift, plane, likeness_reach_m());
}

@fragment
fn fs_occlusion_upsample(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = distance_at(pixel);
    if keeps_mean == 0u {
        return upsampled_at(position.xy, distance_m).value;
    }
    // Open, of no samples. One whose texels all lie on other surfaces does not count.
    var mean = vec2f(1.0, 0.0);
    if keeps_mean == 2u {
        mean = textureLoad(previous_occlusion, pixel, 0).rg;
    }
    if distance_m < DISTANCE_BACKGROUND_M {
        let found = upsampled_at(position.xy, distance_m);
        mean.y += found.trust;
        mean.x += (found.value.r - mean.x) * found.trust / max(mean.y, 1e-4);
    }
    return vec4f(mean, 0.0, 0.0);
}
