// What the picture shows of a surface's reflection, as rays found it, in texels that may be of several pixels: at each
// pixel by which of its four texels lie on the same surface, see `bilateral.wgsl`.

import package::shaders::bilateral::upsampled;
import package::shaders::screen_space::tangent_plane_of;

// Radiance times how much it is to be trusted, and that share.
@group(1) @binding(8) var found_reflections: texture_2d<f32>;

// Pixels along a texel's side, or 0 if nothing was found.
override reflections_side: u32 = 0u;

// Of the distance: so far from the tangent plane another surface begins.
const LIKENESS_REACH: f32 = 0.01;

fn reflected_at(position_px: vec2f, distance_m: f32, normal_world: vec3f) -> vec4f {
    if reflections_side == 0u {
        return vec4f(0.0);
    }
    if reflections_side == 1u {
        return textureLoad(found_reflections, vec2i(position_px), 0);
    }
    let plane = tangent_plane_of(normal_world, floor(position_px) + 0.5, distance_m);
    let reach_m = LIKENESS_REACH * distance_m;
    return upsampled(found_reflections, false, position_px, reflections_side, 0.0, plane, reach_m).value;
}
