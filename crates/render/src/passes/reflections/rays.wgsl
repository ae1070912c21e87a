// What the passes of reflections have in common.

import package::constants::SHARP_ROUGHNESS;
import package::shaders::gbuffer_textures::normal_world_at;
import package::view::view;

struct Reflections {
    distance_m: f32,
    // 1 / the length over which reflections fade out before the distance ends; 0 where they do not.
    fade_per_m: f32,
    thickness_m: f32,
    roughness_max: f32,
    // Pre-exposed; rays of a roughness have this divided by its square.
    radiance_max: f32,
    // 1 / the number of rays of which a pixel shows the mean.
    share_of_ray: f32,
    // The most that a body may be thick whose back is drawn.
    thickness_max_m: f32,
    // Half of how far apart texels lie whose rays are alike, in pixels, counting those of all samples; 0 where every
    // texel has a ray of its own.
    spacing_px: f32,
}

@group(1) @binding(4) var<uniform> reflections: Reflections;

// Pixels along a texel's side: 1, 2 or 4.
override side: u32 = 1u;
// 1 if the noise is that of a pattern of 4 × 4 texels, over which a filter takes the mean; else every texel has its
// own.
override patterned: u32 = 0u;

// Surfaces of this roughness are filtered whole, and smoother ones less.
const FILTERED_ROUGHNESS: f32 = 0.1;

fn filtered_share(roughness: f32) -> f32 {
    return smoothstep(0.0, FILTERED_ROUGHNESS, roughness);
}

// At half the picture's size, surfaces smoother than SHARP_ROUGHNESS have rays of each pixel, and from the first number
// on they show more of the smaller picture.
const SHARPEST_ROUGHNESS: f32 = 0.05;

// A curved mirror sees so little of the picture that its hits are dots: it shows the smaller picture, too. How much the
// normal turns over two pixels, on the side on which it turns less, as 1 - cos: from 0.3 degrees on, up to 1 degree.
const FLAT_TURN: f32 = 1.4e-5;
const CURVED_TURN: f32 = 1.5e-4;

fn turn_to(pixel: vec2i, normal: vec3f, step: vec2i) -> f32 {
    let last = vec2i(view.size_px) - 1;
    let before = dot(normal, normal_world_at(clamp(pixel - step, vec2i(0), last)));
    let after = dot(normal, normal_world_at(clamp(pixel + step, vec2i(0), last)));
    return 1.0 - max(before, after);
}

fn sharp_share(pixel: vec2i, normal: vec3f, roughness: f32) -> f32 {
    let turn = max(turn_to(pixel, normal, vec2i(2, 0)), turn_to(pixel, normal, vec2i(0, 2)));
    let flatness = 1.0 - smoothstep(FLAT_TURN, CURVED_TURN, turn);
    return flatness * (1.0 - smoothstep(SHARPEST_ROUGHNESS, SHARP_ROUGHNESS, roughness));
}

// Rays of rough surfaces have a second number in their share's channel, in whole steps: how much narrower the filter is
// than at its widest, because what they meet is near. Half floats below 8 have room for 256 parts of a share.
const NARROW_STEPS: f32 = 7.0;
const SHARE_PARTS: f32 = 256.0;

// A share above 0 as it can be packed beside so many steps.
fn packable_share(share: f32, steps_narrower: f32) -> f32 {
    return select(share, ceil(share * SHARE_PARTS) / SHARE_PARTS, steps_narrower > 0.0);
}

fn steps_narrower_of(packed: f32) -> f32 {
    return max(ceil(packed) - 1.0, 0.0);
}
