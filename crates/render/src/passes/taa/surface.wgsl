// taa.surface: whether the frames before showed the surface of a pixel under the same light, how many did, and how much it
// flickers.
// Reads: radiance, linear_depth, motion, previous_surface. Writes: taa.surface (rgba16float, whose counts are whole; rgba32float
// where the picture is larger than the frame): log2 of the farthest distance
// of 3 × 3 pixels in metres; how many frames are averaged, plus 128 (2048) times the number of the nearest of these pixels
// (0 to 8); in how many frames of one the luma is on the other side of its mean than in the frame before, with the sign
// of the last side; and that mean, over few frames, as they were without those before them.
// Program: taa_surface.

import package::constants::DISTANCE_BACKGROUND_M;
import package::view::position_world_from_pixel;
import package::passes::taa::history::{
    STILL_FRAMES, color_at, flickers, frame_weight, luma, motion_of, moved_texels, neighbour, packed_count, shaded_place, taa,
    unpacked_count, upscales,
};

@group(1) @binding(4) var linear_depth: texture_2d<f32>;
@group(1) @binding(5) var previous_surface: texture_2d<f32>;

// A surface that lies farther away by such a factor than all that was there was hidden: log2 of 1.1.
const DISOCCLUSION: f32 = 0.1375;
// What lies nearer by such a factor is another surface.
const BEFORE: f32 = 0.98;
// The least weight of a frame in means over few of them.
const FRAME_SHARE: f32 = 0.02;
// Of the display's white: less is no change of light.
const CHANGE_MIN: f32 = 0.04;
// So that there is a sign, and that it tells where something moves.
const RATE_MOVING: f32 = 0.001;
const RATE_STILL: f32 = 0.004;
// By more than this share of the sum of both, and this much of the display's white, luma differs under another light.
const RELIT_SHARE: f32 = 0.04;
const RELIT_MIN: f32 = 0.004;
// Means of so few frames began when the light changed beside a pixel.
const RELIT_FRAMES: f32 = 2.0;

fn distance_at(texel: vec2i) -> f32 {
    let last = vec2i(textureDimensions(linear_depth)) - 1;
    return textureLoad(linear_depth, clamp(texel, vec2i(0), last), 0).r;
}

// What the last frame knew at a place.
fn previous_at_texel(position_px: vec2f) -> vec4f {
    let last = vec2f(textureDimensions(previous_surface)) - 1.0;
    return textureLoad(previous_surface, vec2i(clamp(position_px, vec2f(0.0), last)), 0);
}

// Whether another light falls on a surface than in the frames before. Then luma is on one side of its means in all of
// 3 × 3 texels, by a share of itself, since light multiplies what textures show; what is seen in some frames alone covers
// fewer of them. Jitter moves it by less than the contrast of these texels, of which the lesser one counts: means are
// smoother than a frame, and both have less in shadow. Where light changed one or two frames ago means are those of the
// new light, so that a shadow's edge that moves slowly is followed as well.
fn is_relit(pixel: vec2i, before: vec2f, difference: f32) -> bool {
    var sums = vec4f(0.0);
    var agreeing = 0.0;
    for (var i = 0; i < 9; i++) {
        let light = luma(color_at(pixel + neighbour(i)).rgb);
        let left = previous_at_texel(before + vec2f(neighbour(i)));
        let rises = (light - left.w) * sign(difference);
        let differs = rises > RELIT_MIN + RELIT_SHARE * (light + left.w);
        let began_lately = (i != 4) & (unpacked_count(left.y) <= RELIT_FRAMES);
        agreeing += select(0.0, 1.0, differs | began_lately);
        sums += vec4f(light, light * light, left.w, left.w * left.w);
    }
    let means = sums / 9.0;
    let variance = max(min(means.y - means.x * means.x, means.w - means.z * means.z), 0.0);
    return (agreeing > 8.5) & (difference * difference > variance);
}

@fragment
fn fs_taa_surface(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = shaded_place(position.xy);
    let pixel = vec2i(floor(place));
    let distance_m = distance_at(pixel);
    var nearest_m = distance_m;
    var farthest_m = distance_m;
    var nearest = 4;
    for (var i = 0; i < 9; i++) {
        let around_m = distance_at(pixel + neighbour(i));
        // Of one surface each pixel has its own motion, or what follows a slope would drift.
        let is_nearer = around_m < min(nearest_m, distance_m * BEFORE);
        nearest = select(nearest, i, is_nearer);
        nearest_m = select(nearest_m, around_m, is_nearer);
        farthest_m = max(farthest_m, around_m);
    }
    let moved = moved_texels(pixel + neighbour(nearest));
    let before = position.xy - moved;
    let size = vec2f(textureDimensions(previous_surface));
    let is_inside = all(before >= vec2f(0.0)) & all(before < size);
    let left = previous_at_texel(before);

    // As far away as it was from the last camera, if it did not move itself.
    let position_world = vec4f(position_world_from_pixel(floor(place) + 0.5, distance_m), 1.0);
    let before_m = max(dot(taa.previous_distance_row, position_world), 1e-6);
    let expected_m = select(before_m, DISTANCE_BACKGROUND_M, distance_m >= DISTANCE_BACKGROUND_M);
    let was_seen = log2(expected_m) <= left.x + DISOCCLUSION;
    // Where nothing moved nothing came to light, though this frame may look through a gap that the last one missed.
    let moving = motion_of(moved);
    let stood_still = (moving < 0.5) & (abs(left.z) > 0.5 * RATE_STILL);
    let light = luma(color_at(pixel).rgb);
    let difference = light - left.w;
    // Where nothing at all changed no light did. Of a frame that is smaller than the picture 3 × 3 texels are so much of it
    // that a fence which one frame misses looks like a shadow.
    var relit = false;
    if upscales == 0u && moving < 0.5 && taa.reach <= 0.0 {
        relit = is_relit(pixel, before, difference);
    }
    // The first frame comes before none.
    let goes_on = is_inside & (was_seen | stood_still) & (taa.gain > 0.0) & !relit;

    let side = select(-1.0, 1.0, difference > 0.0);
    let turns = side * left.z < 0.0;
    let was_flickering = flickers(left.z);
    // A change of light goes one way.
    let changes = select(1.0 - was_flickering, 0.0, turns | (abs(difference) < CHANGE_MIN));
    let still = mix(min(taa.most_still, 2.0 * STILL_FRAMES), taa.most_still, was_flickering);
    let unsure = mix(still, min(taa.most_moving, taa.most_still), max(moving, changes));
    let most = max(unsure, taa.most_sure);
    let weight = frame_weight(place, moving);
    let counted = min(unpacked_count(left.y) + weight, most);
    let whole = select(counted, floor(counted), upscales == 0u);
    let count = max(select(weight, whole, goes_on), weight);
    let share = max(1.0 / count, FRAME_SHARE);
    let rate = mix(abs(left.z), select(0.0, 1.0, turns), FRAME_SHARE) * (1.0 - moving);
    let rate_min = select(RATE_STILL, RATE_MOVING, moving >= 0.5);
    let flicker = side * max(select(0.0, rate, goes_on), rate_min);
    return vec4f(log2(farthest_m), packed_count(count, nearest), flicker, select(light, mix(left.w, light, share), goes_on));
}
