// What the passes of temporal anti-aliasing have in common: colours as they are averaged, and what the frames before
// left.

import package::shaders::compressed::compressed;

struct Taa {
    // The distance from the last frame's camera of a point (x, y, z, 1) in world space.
    previous_distance_row: vec4f,
    // 1 / width and height of what is written.
    inverse_size_px: vec2f,
    // Its texels for each pixel of the picture, in which motion is.
    texels_per_px: vec2f,
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
    // Zero.
    padding: f32,
}

@group(1) @binding(0) var<uniform> taa: Taa;
@group(1) @binding(1) var radiance: texture_2d<f32>;
@group(1) @binding(2) var previous: texture_2d<f32>;
@group(1) @binding(3) var motion: texture_2d<f32>;
@group(0) @binding(2) var linear_clamp: sampler;

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
