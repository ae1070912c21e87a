// How far away surfaces are, and how their facets lie, for passes that light them: where nothing else needs linear depth
// they find distances in the depth that they are tested against.

import package::constants::{DISTANCE_BACKGROUND_M, SETTLED_TILE_PX};
import package::view::{view, distance_from_depth_texel, position_view_from_pixel};
import package::shaders::gbuffer_textures::linear_depth;

// 1 if `linear_depth` is the depth attachment.
override reads_attached_depth: u32 = 0u;

// The least cosine between the corners of a pixel on a flat surface.
const FACET_AGREEMENT_MIN: f32 = 0.998;
// The least cosine between the normals of a surface and of its facet, where it is not flat.
const FACET_LIKENESS_MIN: f32 = 0.8;

// Metres along the view axis; at least DISTANCE_BACKGROUND_M where there is no surface.
fn lit_distance_at(pixel: vec2i) -> f32 {
    let texel = textureLoad(linear_depth, pixel, 0).r;
    if reads_attached_depth != 0u {
        return distance_from_depth_texel(vec2f(pixel) + 0.5, texel);
    }
    return texel;
}

// The normal of the surface as it was drawn, from the distances of the pixels around: of the four corners that a pixel
// has with its neighbours the one that lies most like `normal`, so that no neighbour on another surface, or on the
// other side of an edge, has a part in it. `normal` itself where none is like it: then the surface shows in this pixel
// alone.
// The last of the four is how much the normal of a corner is like `normal`; 0 where none is.
// With `stays_in_tile` what lies in another tile may be left out of the sample, and has no distance: the step before
// stands for the one that leads there.
fn facet_normal_at(pixel: vec2i, distance_m: f32, normal: vec3f, stays_in_tile: bool) -> vec4f {
    let center = position_view_from_pixel(vec2f(pixel) + 0.5, distance_m);
    let place = pixel % SETTLED_TILE_PX;
    let begins = (place == vec2i(0)) & vec2<bool>(stays_in_tile);
    let ends = (place == vec2i(SETTLED_TILE_PX - 1)) & vec2<bool>(stays_in_tile);
    var right = step_to(pixel, vec2i(select(1, -2, ends.x), 0), center);
    var left = step_to(pixel, vec2i(select(-1, 2, begins.x), 0), center);
    var down = step_to(pixel, vec2i(0, select(1, -2, ends.y)), center);
    var up = step_to(pixel, vec2i(0, select(-1, 2, begins.y)), center);
    right = select(right, step_between(right, left), ends.x);
    left = select(left, step_between(left, right), begins.x);
    down = select(down, step_between(down, up), ends.y);
    up = select(up, step_between(up, down), begins.y);
    let normal_view = (view.view_from_world * vec4f(normal, 0.0)).xyz;
    let corners = array<vec3f, 4>(
        unit_or_zero(cross(down, right)),
        unit_or_zero(cross(left, down)),
        unit_or_zero(cross(up, left)),
        unit_or_zero(cross(right, up)),
    );
    // The last is how much it is like the normal.
    var best = vec4f(normal_view, FACET_LIKENESS_MIN);
    best = more_like(best, corners[0], normal_view);
    best = more_like(best, corners[1], normal_view);
    best = more_like(best, corners[2], normal_view);
    best = more_like(best, corners[3], normal_view);
    // Where all of them agree the surface is flat, however a normal map bends its normal.
    let agreement = min(dot(corners[0], corners[2]), dot(corners[1], corners[3]));
    let facet = select(best.xyz, corners[0], min(agreement, dot(corners[0], corners[1])) > FACET_AGREEMENT_MIN);
    let likeness = select(0.0, best.w, best.w > FACET_LIKENESS_MIN);
    return vec4f((view.world_from_view * vec4f(facet, 0.0)).xyz, likeness);
}

fn unit_or_zero(v: vec3f) -> vec3f {
    return v * inverseSqrt(max(dot(v, v), 1e-30));
}

// The step from a pixel's point to that of a neighbour, in view space; 0 where there is no surface, or no pixel.
fn step_to(pixel: vec2i, offset: vec2i, center: vec3f) -> vec3f {
    let other = clamp(pixel + offset, vec2i(0), vec2i(view.size_px) - 1);
    let distance_m = lit_distance_at(other);
    let step = position_view_from_pixel(vec2f(other) + 0.5, distance_m) - center;
    return select(vec3f(0.0), step, distance_m < DISTANCE_BACKGROUND_M);
}

// From the end of one step to that of another; 0 where the first leads nowhere.
fn step_between(from_step: vec3f, to_step: vec3f) -> vec3f {
    return select(vec3f(0.0), to_step - from_step, dot(from_step, from_step) > 0.0);
}

fn more_like(best: vec4f, candidate: vec3f, normal: vec3f) -> vec4f {
    let likeness = dot(candidate, normal);
    return select(best, vec4f(candidate, likeness), likeness > best.w);
}
