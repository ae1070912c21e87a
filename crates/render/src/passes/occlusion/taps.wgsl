// What the passes of occlusion have in common: the place that is looked from, places that are looked at, and their
// noise.

import package::constants::DISTANCE_BACKGROUND_M;
import package::view::view;
import package::shaders::coarse::pixel_of_texel;
import package::shaders::screen_space::{Center, center_at, slice_noise};

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

// Of the radius: so far from the tangent plane another surface begins.
const THICKNESS: f32 = 0.1;

fn center_of_texel(texel: vec2i) -> Center {
    return center_at(pixel_of_texel(texel, i32(side)));
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
