//! simulation trails
//! start: flat -> ground
//! step: press -> ground
//! shows: color, normals
//! cells: 384x256
//! rate: 60
//! reads: surfaces

// What moves over soft ground leaves trails: tracks of wheels, prints of feet. A camera below looks up at what stands on it,
// and the ground is pressed to where its underside is. What is pressed away rises as a rim, because sand is not lost.

struct Trails {
    /// The greatest depth of tracks, m
    // = 0.04 in 0..100
    depth_m: f32,
    /// The depth to which bodies on the ground sink in, m
    // = 0.012 in 0..100
    sink_m: f32,
    /// The rate at which tracks fill again, 1/s
    // = 0 in 0..1000
    recovery_per_s: f32,
    /// The height of the rim of tracks, share of their depth
    // = 0.35 in 0..2
    rim: f32,
    /// The colour of the ground, linear
    // = 0.58, 0.49, 0.37 in 0..1
    ground_color: vec3f,
    /// The random roughness of the ground, m
    // = 0.0012 in 0..1
    grain_m: f32,
    /// The colour of tracks, linear
    // = 0.4, 0.32, 0.22 in 0..1
    pressed_color: vec3f,
    padding: f32,
}

@group(2) @binding(0) var<uniform> trails: Trails;

fn flat(cell: vec2i) -> vec4f {
    return vec4f(0.0);
}

// x: how deep it is pressed, in metres; y: the same, spread to the cells around.
fn press(cell: vec2i) -> vec4f {
    let before = ground_at(cell);
    let beyond_m = surface_beyond(world_at(cell));
    let pressed = clamp(trails.sink_m - beyond_m, 0.0, trails.depth_m);
    let deep = max(before.x * exp(-trails.recovery_per_s * simulation.step_secs), pressed);
    var around = 0.0;
    for (var at = 0u; at < 9u; at++) {
        around += ground_at(cell + vec2i(i32(at % 3u), i32(at / 3u)) - 1).y / 9.0;
    }
    return vec4f(deep, mix(max(deep, around * 0.93), deep, 0.2), 0.0, 0.0);
}

// The height of the ground, in metres.
fn height(cell: vec2i) -> f32 {
    let here = ground_at(cell);
    let grain = random(vec3u(vec2u(cell), 7u)).x * trails.grain_m;
    let beside = max(here.y - here.x, 0.0);
    return trails.rim * beside * (1.0 - smoothstep(0.0, 0.5, here.x / max(trails.depth_m, 1e-6))) - here.x + grain;
}

fn color(cell: vec2i) -> vec4f {
    let share = smoothstep(0.05, 0.6, ground_at(cell).x / max(trails.depth_m, 1e-6));
    let grain = 0.9 + 0.2 * random(vec3u(vec2u(cell), 3u)).x;
    return vec4f(mix(trails.ground_color, trails.pressed_color, share) * grain, 1.0);
}

// A normal map as of glTF.
fn normals(cell: vec2i) -> vec4f {
    let right = height(cell + vec2i(1, 0)) - height(cell - vec2i(1, 0));
    let up = height(cell - vec2i(0, 1)) - height(cell + vec2i(0, 1));
    let normal = normalize(vec3f(-vec2f(right, up) / (2.0 * simulation.cell_m), 1.0));
    return vec4f(0.5 + 0.5 * normal, 1.0);
}
