// occlusion.upsample: occlusion at the full size, from the four nearest texels of a smaller picture (see
// `shaders/bilateral.wgsl`). Reads: coarse_occlusion, normal, linear_depth. Writes: occlusion.
// Program: occlusion_upsample.

import package::passes::occlusion::taps::{likeness_reach_m, patterned, side};
import package::shaders::bilateral::upsampled;
import package::shaders::gbuffer_textures::distance_at;
import package::shaders::screen_space::tangent_plane_at;

@group(1) @binding(5) var coarse_occlusion: texture_2d<f32>;

@fragment
fn fs_occlusion_upsample(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let plane = tangent_plane_at(pixel, distance_at(pixel));
    // A filtered texel is the mean of a square whose middle lies half a texel before its own.
    let shift = select(0.0, 0.5, patterned != 0u);
    return upsampled(coarse_occlusion, position.xy, side, shift, plane, likeness_reach_m());
}
