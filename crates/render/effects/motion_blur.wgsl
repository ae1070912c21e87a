//! effect motion_blur
//! reads: radiance, depth, motion
//! passes: fs_quarter -> quarter 1/4, fs_tile -> tile 1/16, fs_around -> around 1/16, fs_gather

// Motion blur: moving surfaces are smeared along their motion vectors while the shutter is open. A pixel samples along
// the longest motion vector in and around its tile. Samples in front of it, or behind it if it moves itself, count as far
// as their own motion reaches.
// Source: McGuire, Hennessy, Bukowski & Osman 2012, "A Reconstruction Filter for Plausible Motion Blur". Differs from it:
// tiles are found in two steps, and a pixel takes the longest motion vector within 32 pixels.

struct MotionBlur {
    /// The share of the time between two frames with an open shutter; 180 degrees are 0.5, share
    // = 0.5 in 0..2
    shutter: f32,
    /// The number of samples along the motion
    // = 15 in 3..63
    taps: u32,
    padding: vec2f,
}

@group(2) @binding(0) var<uniform> motion_blur: MotionBlur;

// Tiles around one reach so far.
const REACH_PX = 32.0;
// Of two distances that differ by this share of them one lies before the other.
const DEPTH_SOFTNESS = 0.02;

fn longer(a: vec2f, b: vec2f) -> vec2f {
    return select(a, b, dot(b, b) > dot(a, a));
}

// Half of the way that a pixel goes while the shutter is open, at most as far as tiles reach.
fn half_way(moved_px: vec2f) -> vec2f {
    let half = 0.5 * motion_blur.shutter * moved_px;
    return half * min(1.0, REACH_PX / max(length(half), 1e-6));
}

fn moved_at(pixel: vec2i) -> vec2f {
    return textureLoad(motion, clamp(pixel, vec2i(0), vec2i(textureDimensions(motion)) - 1), 0).xy;
}

@fragment
fn fs_quarter(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = 4 * vec2i(position.xy);
    var longest = vec2f(0.0);
    for (var i = 0; i < 16; i++) {
        longest = longer(longest, moved_at(first + vec2i(i & 3, i >> 2u)));
    }
    // What a half float holds.
    return vec4f(clamp(longest, vec2f(-65504.0), vec2f(65504.0)), 0.0, 1.0);
}

@fragment
fn fs_tile(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = 4 * vec2i(position.xy);
    let last = vec2i(textureDimensions(quarter)) - 1;
    var longest = vec2f(0.0);
    for (var i = 0; i < 16; i++) {
        longest = longer(longest, textureLoad(quarter, min(first + vec2i(i & 3, i >> 2u), last), 0).xy);
    }
    return vec4f(longest, 0.0, 1.0);
}

@fragment
fn fs_around(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let middle = vec2i(position.xy);
    let last = vec2i(textureDimensions(tile)) - 1;
    var longest = vec2f(0.0);
    for (var y = -2; y < 3; y++) {
        for (var x = -2; x < 3; x++) {
            let place = clamp(middle + vec2i(x, y), vec2i(0), last);
            longest = longer(longest, textureLoad(tile, place, 0).xy);
        }
    }
    return vec4f(half_way(longest), 0.0, 1.0);
}

// From 0 to 1, as a lies before b.
fn lies_before(a_m: f32, b_m: f32) -> f32 {
    return clamp((b_m - a_m) / (DEPTH_SOFTNESS * min(a_m, b_m)) + 1.0, 0.0, 1.0);
}

fn cone(distance_px: f32, reach_px: f32) -> f32 {
    return clamp(1.0 - distance_px / max(reach_px, 1e-3), 0.0, 1.0);
}

fn cylinder(distance_px: f32, reach_px: f32) -> f32 {
    return 1.0 - smoothstep(0.95 * reach_px, 1.05 * reach_px + 1e-3, distance_px);
}

// Interleaved gradient noise (Jimenez 2014), from 0 to 1; each sample of a still looks elsewhere.
fn noise(pixel: vec2f) -> f32 {
    return fract(52.9829189 * fract(dot(pixel, vec2f(0.06711056, 0.00583715))));
}

@fragment
fn fs_gather(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = radiance_at(pixel);
    let way = textureLoad(around, pixel / 16, 0).xy;
    let own_reach = length(half_way(moved_at(pixel)));
    let distance_m = max(distance_at(pixel), 1e-4);
    let count = f32(motion_blur.taps);
    // As many as fall on the pixel itself, of those that lie a pixel apart.
    var weight = 1.0 / max(own_reach, 0.5);
    var sum = here * weight;
    for (var i = 0u; i < motion_blur.taps; i++) {
        let t = 2.0 * (f32(i) + noise(position.xy + 5.588238 * f32(view.sample_index % 64u))) / count - 1.0;
        let place = vec2i(floor(position.xy + way * t));
        let there_reach = length(half_way(moved_at(place)));
        let there_m = max(distance_at(clamp(place, vec2i(0), vec2i(view.size_px) - 1)), 1e-4);
        let apart = length(way * t);
        let comes = lies_before(there_m, distance_m) * cone(apart, there_reach);
        let goes = lies_before(distance_m, there_m) * cone(apart, own_reach);
        let both = 2.0 * cylinder(apart, there_reach) * cylinder(apart, own_reach);
        let share = comes + goes + both;
        weight += share;
        sum += radiance_at(place) * share;
    }
    let blurred = sum / weight;
    let is_moved = dot(way, way) > 0.25;
    return select(here, vec4f(half_float_clamped(blurred.rgb), clamp(blurred.a, 0.0, 1.0)), is_moved);
}
