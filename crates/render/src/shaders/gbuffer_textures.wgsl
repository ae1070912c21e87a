// The G-buffer as passes after the geometry pass read it.

import package::constants::DISTANCE_BACKGROUND_M;
import package::view::{view, position_view_from_pixel};
import package::gbuffer::{GbufferTexels, Surface, gbuffer_unpack};

@group(1) @binding(0) var base_color: texture_2d<f32>;
@group(1) @binding(1) var normal: texture_2d<u32>;
@group(1) @binding(2) var material: texture_2d<f32>;
@group(1) @binding(3) var linear_depth: texture_2d<f32>;

fn surface_at(pixel: vec2i) -> Surface {
    var texels: GbufferTexels;
    texels.base_color = textureLoad(base_color, pixel, 0);
    texels.normal = textureLoad(normal, pixel, 0).rg;
    texels.material = textureLoad(material, pixel, 0);
    return gbuffer_unpack(texels);
}

// Metres along the view axis; at least DISTANCE_BACKGROUND_M where there is no surface.
fn distance_at(pixel: vec2i) -> f32 {
    return textureLoad(linear_depth, pixel, 0).r;
}

// The normal of the surface that the pixels around show, from their distances: along each axis the neighbour that is more
// likely on the same surface. `normal` where there is none.
fn facet_normal_at(pixel: vec2i, distance_m: f32, normal: vec3f) -> vec3f {
    let last = vec2i(view.size_px) - 1;
    let center = position_view_from_pixel(vec2f(pixel) + 0.5, distance_m);
    let across = step_along(pixel, vec2i(1, 0), last, center, distance_m);
    let down = step_along(pixel, vec2i(0, 1), last, center, distance_m);
    let facet = (view.world_from_view * vec4f(cross(down.xyz, across.xyz), 0.0)).xyz;
    let length_squared = dot(facet, facet);
    let is_found = (min(across.w, down.w) > 0.0) & (length_squared > 1e-30);
    return select(normal, facet * inverseSqrt(max(length_squared, 1e-30)), is_found);
}

// From a pixel's point to that of the next or from that of the last, in view space, whichever is the smaller step; w is 0 if
// there is no surface on either side.
fn step_along(pixel: vec2i, axis: vec2i, last: vec2i, center: vec3f, distance_m: f32) -> vec4f {
    let before = max(pixel - axis, vec2i(0));
    let after = min(pixel + axis, last);
    let distances = vec2f(distance_at(before), distance_at(after));
    // At the edge of the picture there is no neighbour.
    let steps = abs(distances - distance_m) + vec2f(
        select(0.0, DISTANCE_BACKGROUND_M, all(before == pixel)),
        select(0.0, DISTANCE_BACKGROUND_M, all(after == pixel)),
    );
    let is_after = steps.y < steps.x;
    let other = position_view_from_pixel(
        vec2f(select(before, after, is_after)) + 0.5,
        select(distances.x, distances.y, is_after),
    );
    let step = (other - center) * select(-1.0, 1.0, is_after);
    return vec4f(step, select(0.0, 1.0, min(steps.x, steps.y) < 0.5 * DISTANCE_BACKGROUND_M));
}
