// What the passes of temporal anti-aliasing have in common: colours as they are averaged, and what the frames before
// left.

import package::shaders::compressed::compressed;
import package::view::view;

struct Taa {
    // The distance from the last frame's camera of a point (x, y, z, 1) in world space.
    previous_distance_row: vec4f,
    // 1 / width and height of what is written.
    inverse_size_px: vec2f,
    // Its texels for each pixel of the picture, in which motion is.
    texels_per_px: vec2f,
    // The frame's texels for each of its.
    shaded_per_texel: vec2f,
    // From pre-exposed radiance to what the tone curve takes.
    exposure: f32,
    // What the last frame's radiance is multiplied by; 0 without one.
    gain: f32,
    // Frames that are averaged where nothing moves.
    most_still: f32,
    // And where something does.
    most_moving: f32,
    // Half the side of boxes in standard deviations.
    clip: f32,
    // What is added to that, more than any colour where nothing changed since the last frame.
    reach: f32,
    // The least number of frames that are averaged at the most.
    most_sure: f32,
    // What a sample counts that lies in the texel, where the frame is smaller than what is written; in frames.
    near_weight: f32,
    // What a frame counts whose samples lie beside it.
    far_weight: f32,
    // The same where something moves.
    far_weight_moving: f32,
}

@group(1) @binding(0) var<uniform> taa: Taa;
@group(1) @binding(1) var radiance: texture_2d<f32>;
@group(1) @binding(2) var previous: texture_2d<f32>;
@group(1) @binding(3) var motion: texture_2d<f32>;
@group(0) @binding(2) var linear_clamp: sampler;

// 1 if the frame is smaller than what is written, which then has the picture's size.
override upscales: u32 = 0u;

// How far the sides of a texel are from sharp, in texels, so that weights do not jump.
const SIDE: f32 = 0.1;
// More than means are of where something moves, with the default settings. After twice as many frames it is known whether
// what stands still flickers; until then more would keep what boxes took.
const STILL_FRAMES: f32 = 12.0;

fn luma(color: vec3f) -> f32 {
    return dot(color, vec3f(0.25, 0.5, 0.25));
}

// Whether a pixel shows now this and now that, in turn: 0 to 1. What is seen in one frame of many lies twice on the other
// side of its mean than in the frame before; where a shadow comes and goes such frames are few.
fn flickers(rate: f32) -> f32 {
    return smoothstep(0.01, 0.04, abs(rate));
}

// The frame's texel as it is averaged.
fn color_at(texel: vec2i) -> vec4f {
    let last = vec2i(textureDimensions(radiance)) - 1;
    return compressed(textureLoad(radiance, clamp(texel, vec2i(0), last), 0), taa.exposure);
}

// The place in the frame of a place in what is written, in texels: samples lie in the middles of its texels, which jitter
// moved.
fn shaded_place(position_px: vec2f) -> vec2f {
    if upscales == 0u {
        return position_px;
    }
    return position_px * taa.shaded_per_texel + view.jitter_ndc * vec2f(0.5, -0.5) * view.size_px;
}

// What share of a texel of what is written, of which samples lie so far from the middle, is theirs: 1 within it, 0 beside.
fn inside(offset_px: vec2f) -> f32 {
    let share = clamp((0.5 + SIDE - abs(offset_px)) / (2.0 * SIDE), vec2f(0.0), vec2f(1.0));
    return share.x * share.y;
}

// A sample's weight by its distance from a place, in texels of the frame: of samples within a texel of what is written its
// full one (Karis 2014, "High Quality Temporal Supersampling"), of the four around a little, linearly, for texels that
// had none yet.
// Where something moves means are of few frames: there a sample counts less beside what is interpolated, or texels that
// have one in this frame would stand out.
fn sample_weight(offset: vec2f, moving: f32) -> f32 {
    let linear = max(1.0 - abs(offset), vec2f(0.0));
    let near = mix(taa.near_weight, sqrt(taa.near_weight), moving);
    let far = mix(taa.far_weight, taa.far_weight_moving, moving);
    return near * inside(offset / taa.shaded_per_texel) + far * linear.x * linear.y;
}

// How much something moves, by texels since the last frame: 0 to 1.
fn motion_of(moved: vec2f) -> f32 {
    return min(length(moved), 1.0);
}

// Where the nearest sample lies, from a place.
fn nearest_offset(place: vec2f) -> vec2f {
    return floor(place) + 0.5 - place;
}

// How much a frame counts at a place, in frames.
fn frame_weight(place: vec2f, moving: f32) -> f32 {
    if upscales == 0u {
        return 1.0;
    }
    let first = nearest_offset(place);
    var sum = 0.0;
    for (var i = 0; i < 9; i++) {
        sum += sample_weight(first + vec2f(neighbour(i)), moving);
    }
    return sum;
}

// How many frames a mean is of, and the number of the nearest neighbour, in one number.
fn packed_count(count: f32, nearest: i32) -> f32 {
    return f32(nearest) * counts() + count;
}

fn unpacked_count(both: f32) -> f32 {
    return both - floor(both / counts()) * counts();
}

fn unpacked_nearest(both: f32) -> i32 {
    return i32(floor(both / counts()));
}

// More than a count is: half floats have eleven bits, and what is larger than frames is known in more.
fn counts() -> f32 {
    return select(2048.0, 128.0, upscales == 0u);
}

// What the last frame left at a place, as it is averaged.
fn previous_at(position_px: vec2f) -> vec4f {
    let found = textureSampleLevel(previous, linear_clamp, position_px * taa.inverse_size_px, 0.0);
    return compressed(found, taa.exposure * taa.gain);
}

// One of the 3 × 3 texels around another one, row by row.
fn neighbour(index: i32) -> vec2i {
    return vec2i(index % 3 - 1, index / 3 - 1);
}

// How far what a texel shows moved since the last frame, in texels.
fn moved_texels(texel: vec2i) -> vec2f {
    let last = vec2i(textureDimensions(motion)) - 1;
    return textureLoad(motion, clamp(texel, vec2i(0), last), 0).rg * taa.texels_per_px;
}
