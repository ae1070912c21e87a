// What the passes of occlusion have in common: the place that is looked from, places that are looked at, and their
// noise.

import package::constants::DISTANCE_BACKGROUND_M;
import package::view::{view, position_view_from_pixel};
import package::shaders::coarse::{pixel_of_texel, turn_in_square};
import package::shaders::hash::{seed_of_pixel, stratified};
import package::shaders::screen_space::{Center, FARTHEST_M, TangentPlane, center_at, distance_sampled, likeness_to};

struct Occlusion {
    radius_m: f32,
    // 1 / the length over which occlusion fades out before the radius ends.
    fade_per_m: f32,
    thinness: f32,
    intensity: f32,
}

@group(1) @binding(4) var<uniform> occlusion: Occlusion;

// Pixels along a texel's side: 1, 2 or 4.
override side: u32 = 1u;
// 1 if the noise is that of a pattern of 4 × 4 texels, over which a filter takes the mean; else every texel has its
// own.
override patterned: u32 = 0u;
override slices: u32 = 2u;
override steps: u32 = 4u;
// 1 if the direction from which light still comes is wanted.
override bends: u32 = 0u;

// Of the radius: so far from the tangent plane another surface begins.
const THICKNESS: f32 = 0.1;

fn center_of_texel(texel: vec2i) -> Center {
    return center_at(pixel_of_texel(texel, i32(side)));
}

// Two numbers from 0 up to 1: of the direction, and of the place along it.
fn noise_at(position_px: vec2f) -> vec2f {
    if patterned != 0u {
        // Jimenez et al. 2016; another part of each sixteenth, and of each fourth, in every sample (Roberts 2018).
        let texel = vec2u(position_px);
        let direction = (((texel.x + texel.y) & 3u) << 2u) + (texel.x & 3u);
        let turn = fract(f32(view.sample_index) * vec2f(0.7548777, 0.5698403));
        return vec2f((f32(direction) + turn.x) / 16.0, (f32((texel.y - texel.x) & 3u) + fract(turn.y + 0.5)) / 4.0);
    }
    return vec2f(
        stratified(view.sample_index, seed_of_pixel(position_px, 41u)),
        stratified(view.sample_index, seed_of_pixel(position_px, 42u)),
    );
}

// From the center to the surface that the picture shows at a place; the last is 1, or 0 where it shows none.
fn seen_from(center: Center, position_px: vec2f) -> vec4f {
    let middle = floor(position_px) + 0.5;
    let nearest = clamp(middle, vec2f(0.5), view.size_px - 0.5);
    let distance_m = distance_sampled(nearest);
    let seen = position_view_from_pixel(nearest, min(distance_m, FARTHEST_M));
    let is_seen = all(middle == nearest) && distance_m < DISTANCE_BACKGROUND_M;
    return vec4f(seen - center.position, select(0.0, 1.0, is_seen));
}

// From 0 to 1, how much what was found at a texel tells of a tangent plane's surface: nothing where it lies on another.
// `first` is the middle of the first texel's pixel.
fn likeness(plane: TangentPlane, texel: vec2f, first: vec2f) -> f32 {
    let middle = min(texel * f32(side) + first, view.size_px - 0.5);
    return likeness_to(plane, middle, THICKNESS * occlusion.radius_m);
}

fn middle_of_first_texel() -> vec2f {
    return vec2f(turn_in_square(i32(side))) + 0.5;
}

// How much what lies so far away occludes.
fn share_at(length_m: f32) -> f32 {
    return clamp((occlusion.radius_m - length_m) * occlusion.fade_per_m, 0.0, 1.0);
}

// The texel that is written, of the shares that are lost of light and of its directions in view space. The directions
// of an open surface have the mean of 2 / 3 of the normal.
fn texel_of_loss(center: Center, lost: f32, lost_direction: vec3f) -> vec4f {
    let bent = center.normal * (2.0 / 3.0) - lost_direction;
    return vec4f(1.0 - occlusion.intensity * lost, (view.world_from_view * vec4f(bent, 0.0)).xyz);
}
