// What reaches a surface of the environment's light, where an earlier sample of a still found that at a smaller size
// for all: at each pixel by which of its four texels lie on the same surface, see `bilateral.wgsl`.

import package::gbuffer::Surface;
import package::shaders::ambient::Seen;
import package::shaders::bilateral::{Upsampled, upsampled_by_distances};
import package::shaders::brdf::Shading;
import package::shaders::occlusion::{occluded, seen_at, seen_of};
import package::shaders::screen_space::{TangentPlane, tangent_plane_of};
@if(!layered) import package::shaders::occlusion::screen_occlusion;
@if(layered) import package::shaders::transparency::glass_distances;

struct CoarseOcclusion {
    // So far from the tangent plane another surface begins.
    reach_m: f32,
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

@group(1) @binding(7) var<uniform> coarse_occlusion: CoarseOcclusion;

// Pixels along a texel's side of `screen_occlusion`, or 0 if its texels are those of pixels.
override occlusion_side: u32 = 0u;

// A filtered texel is the mean of a square whose middle lies half a texel before its own.
const SHIFT: f32 = 0.5;
// What so little of the texels around knows of is half open.
const TRUST_HALF: f32 = 0.02;

fn found_before(position_px: vec2f, plane: TangentPlane) -> Upsampled {
    let reach_m = coarse_occlusion.reach_m;
    @if(layered) {
        return upsampled_by_distances(glass_distances, position_px, occlusion_side, SHIFT, plane, reach_m);
    }
    @if(!layered) {
        return upsampled_by_distances(screen_occlusion, position_px, occlusion_side, SHIFT, plane, reach_m);
    }
}

fn seen_by_sample(position_px: vec2f, distance_m: f32, surface: Surface, shading: Shading) -> Seen {
    if occluded == 0u || occlusion_side == 0u {
        return seen_at(vec2i(position_px), surface, shading);
    }
    let found = found_before(position_px, tangent_plane_of(surface.normal_world, position_px, distance_m));
    let trust = found.trust / (found.trust + TRUST_HALF);
    return seen_of(vec4f(mix(1.0, found.value.r, trust), 0.0, 0.0, 0.0), surface, shading);
}
