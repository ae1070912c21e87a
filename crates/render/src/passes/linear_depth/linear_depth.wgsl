// linear_depth: the distance along the view axis in metres, from the depth attachment, once for all later passes.
// Where nothing was drawn it is DISTANCE_BACKGROUND_M, which stands for infinity and survives every comparison.
// Reads: depth. Writes: linear_depth (r32float).
// Program: linear_depth.

import package::view::{view, distance_from_depth_texel};

// 1 if what is nearest of all is left out of the frame, see the pass `adaptive`.
override leaves_out: u32 = 0u;

@group(1) @binding(0) var depth: texture_2d<f32>;
@group(0) @binding(7) var nearest_clamp: sampler;

@fragment
fn fs_linear_depth(@builtin(position) position: vec4f) -> @location(0) f32 {
    // Sampled, not loaded: a depth texture without a sampler reads 0 on WebGL 2.
    let depth_ndc = textureSampleLevel(depth, nearest_clamp, position.xy * view.inverse_size_px, 0.0).r;
    if leaves_out != 0u {
        if depth_ndc >= 1.0 {
            discard;
        }
    }
    return distance_from_depth_texel(position.xy, depth_ndc);
}
