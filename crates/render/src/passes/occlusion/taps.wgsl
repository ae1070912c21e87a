// What the passes of occlusion have in common: the place that is looked from, places that are looked at, and their
// noise.

import package::constants::DISTANCE_BACKGROUND_M;
import package::view::{view, position_view_from_pixel};
import package::shaders::coarse::pixel_of_texel;
import package::shaders::gbuffer_textures::{distance_at, normal_world_at};
import package::shaders::screen_space::{
    Center, center_of, distance_from_nearness, nearness_from_distance, slice_noise,
};

struct Occlusion {
    radius_m: f32,
    // 1 / the length over which occlusion fades out before the radius ends.
    fade_per_m: f32,
    thinness: f32,
    intensity: f32,
    // Of the radius, what rises less than that occludes nothing where points look.
    bias: f32,
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

@group(1) @binding(4) var<uniform> occlusion: Occlusion;

// Pixels along a texel's side: 1, 2 or 4.
override side: u32 = 1u;
// 1 if the noise is that of a pattern of 4 × 4 texels, over which a filter takes the mean; else every texel has its
// own.
override patterned: u32 = 0u;
// 0 if all texels look in the same directions.
override noisy: u32 = 1u;
override slices: u32 = 2u;
override steps: u32 = 4u;
// 1 if the direction from which light still comes is wanted.
override bends: u32 = 0u;

// 1 if texels say beside what they hold how far away their surface is, where later passes look for it.
override has_distances: u32 = 0u;

// 1 if a texel whose pixel shows the inside of a groove stands for the surface on both sides of it.
override bridges_grooves: u32 = 0u;

// Of the radius: so far from the tangent plane another surface begins.
const THICKNESS: f32 = 0.1;
// Of the way between the surfaces on both sides of a groove: as much as they may lie off each other's plane, and as
// much as the groove is deep at least. What is shallower loses little.
const STEP_MAX: f32 = 0.05;
const DEPTH_MIN: f32 = 0.1;
// The least cosine between their normals, about 18°.
const ALIKE_MIN: f32 = 0.95;
// Below this cosine from their normal a pixel shows a wall of the groove, however deep that is: of the distance, more
// than rounding leaves.
const WALL_MAX: f32 = 0.8;
const WALL_DEPTH_MIN: f32 = 4e-4;

// The surface that a texel stands for.
struct Stand {
    pixel: vec2i,
    // The pixel whose normal it has.
    normal_pixel: vec2i,
    distance_m: f32,
}

// That which its pixel shows. With `bridges_grooves` it is the surface around a groove that is thinner than a pixel:
// samples that see that surface would take what is found in the groove for their own.
fn stand_of_texel(texel: vec2i) -> Stand {
    let pixel = pixel_of_texel(texel, i32(side));
    var stand = Stand(pixel, pixel, distance_at(pixel));
    if bridges_grooves != 0u {
        let seen_m = stand.distance_m;
        stand = bridged(stand, seen_m, vec2i(1, 0));
        stand = bridged(stand, seen_m, vec2i(0, 1));
        stand = bridged(stand, seen_m, vec2i(1, 1));
        stand = bridged(stand, seen_m, vec2i(1, -1));
    }
    return stand;
}

// Where the pixels on both sides of a texel's lie on one plane, and its own below that by less than what tells surfaces
// apart, it stands for that plane.
fn bridged(stand: Stand, seen_m: f32, step: vec2i) -> Stand {
    let last = vec2i(view.size_px) - 1;
    let before = clamp(stand.pixel - step, vec2i(0), last);
    let after = clamp(stand.pixel + step, vec2i(0), last);
    let from_m = distance_at(before);
    let to_m = distance_at(after);
    let is_inside = all(after - before == 2 * step);
    if !is_inside || max(max(from_m, to_m), seen_m) >= DISTANCE_BACKGROUND_M {
        return stand;
    }
    let normal_before = normal_world_at(before);
    let normal_after = normal_world_at(after);
    let normal = (view.view_from_world * vec4f(normal_before + normal_after, 0.0)).xyz * 0.5;
    let middle_px = vec2f(stand.pixel) + 0.5;
    let way = position_view_from_pixel(middle_px + vec2f(step), to_m)
        - position_view_from_pixel(middle_px - vec2f(step), from_m);
    let across_m = distance_from_nearness(0.5 * (nearness_from_distance(from_m) + nearness_from_distance(to_m)));
    let sunk = position_view_from_pixel(middle_px, across_m) - position_view_from_pixel(middle_px, seen_m);
    let depth_m = dot(sunk, normal);
    let is_plane = dot(normal_before, normal_after) > ALIKE_MIN && abs(dot(way, normal)) < STEP_MAX * length(way);
    let is_wall = dot(normal_world_at(stand.pixel), normal_before) < WALL_MAX;
    let least_m = select(DEPTH_MIN * length(way), WALL_DEPTH_MIN * max(seen_m, across_m), is_wall);
    if is_plane && depth_m > least_m && depth_m < likeness_reach_m() {
        return Stand(stand.pixel, before, across_m);
    }
    return stand;
}

fn center_of_texel(texel: vec2i) -> Center {
    let stand = stand_of_texel(texel);
    return center_of(stand.pixel, stand.normal_pixel, stand.distance_m);
}

fn noise_at(position_px: vec2f) -> vec2f {
    if noisy == 0u {
        return vec2f(0.5);
    }
    return slice_noise(position_px, patterned != 0u, 41u);
}

// So far from the tangent plane another surface begins.
fn likeness_reach_m() -> f32 {
    return THICKNESS * occlusion.radius_m;
}

// How much what lies so far away occludes.
fn share_at(length_m: f32) -> f32 {
    return clamp((occlusion.radius_m - length_m) * occlusion.fade_per_m, 0.0, 1.0);
}

// The texel that is written where there is no surface.
fn texel_of_background() -> vec4f {
    return vec4f(1.0, select(0.0, DISTANCE_BACKGROUND_M, has_distances != 0u), 0.0, 0.0);
}

// The texel that is written of a surface, of the shares that are lost of light and of its directions in view space. The directions
// of an open surface have the mean of 2 / 3 of the normal.
fn texel_of_loss(center: Center, lost: f32, lost_direction: vec3f) -> vec4f {
    let share = 1.0 - occlusion.intensity * lost;
    if has_distances != 0u {
        return vec4f(share, -center.position.z, 0.0, 0.0);
    }
    let bent = center.normal * (2.0 / 3.0) - lost_direction;
    return vec4f(share, (view.world_from_view * vec4f(bent, 0.0)).xyz);
}
