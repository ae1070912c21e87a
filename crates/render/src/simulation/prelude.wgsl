// What a simulation finds declared beside its own text.

// A node of the scene within the place that the cells lie over. Lengths are metres: to the right, up, and out of it.
struct Body {
    // Its middle, and the radius of the sphere that it is.
    middle_m: vec3f,
    radius_m: f32,
    // Half the sides of the box around it; 1 of a wall, else 0.
    half_m: vec3f,
    is_wall: f32,
    // Where its middle was before the step.
    before_m: vec3f,
    padding: f32,
}

struct Simulation {
    // Columns and rows.
    cells: vec2i,
    // Width and height of a cell, in metres.
    cell_m: vec2f,
    // How many steps were made before, and how long one is.
    step: u32,
    step_secs: f32,
    // The scene's time after the step.
    time_secs: f32,
    // What chance begins with.
    seed: u32,
    body_count: u32,
    padding_a: u32,
    padding_b: vec2f,
    bodies: array<Body, 16>,
    // From metres to the right, up and out of the place, from its middle, to world space.
    world_from_place: mat4x4f,
}

struct Turn {
    // How often the pass was drawn before in this step, and how often it is drawn in all.
    round: u32,
    rounds: u32,
    padding: vec2f,
}

@group(1) @binding(0) var<uniform> simulation: Simulation;
@group(1) @binding(1) var<uniform> turn: Turn;

// Beyond this a number is held.
const NUMBER_MAX: f32 = 1e6;

// Where the middle of a cell is, in metres from the middle of the place: to the right, and up.
fn metres_at(cell: vec2i) -> vec2f {
    return (vec2f(cell) + 0.5 - 0.5 * vec2f(simulation.cells)) * simulation.cell_m * vec2f(1.0, -1.0);
}

// Where the middle of a cell is in world space.
fn world_at(cell: vec2i) -> vec3f {
    return (simulation.world_from_place * vec4f(metres_at(cell), 0.0, 1.0)).xyz;
}

// The same backwards, in cells: the middle of the first is at 0.5.
fn cells_from_metres(place_m: vec2f) -> vec2f {
    return place_m * vec2f(1.0, -1.0) / simulation.cell_m + 0.5 * vec2f(simulation.cells);
}

// Four numbers from 0 up to 1 by chance, which three numbers and the seed tell.
// Source: pcg4d (Jarzynski & Olano 2020).
fn random(key: vec3u) -> vec4f {
    var v = vec4u(key, simulation.seed) * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v = v ^ (v >> vec4u(16u));
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return vec4f(v >> vec4u(8u)) / 16777216.0;
}

// A texel of the picture `waves` from slopes to the right and up: with their squares, so that what is filtered keeps both.
fn waves_of(slopes: vec2f) -> vec4f {
    let held = clamp(slopes, vec2f(-8.0), vec2f(8.0));
    return vec4f(held, held * held);
}

fn held_number(x: f32) -> f32 {
    let is_number = (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
    return select(NUMBER_MAX, clamp(x, -NUMBER_MAX, NUMBER_MAX), is_number);
}

// What is kept of a state.
fn held(value: vec4f) -> vec4f {
    return vec4f(held_number(value.x), held_number(value.y), held_number(value.z), held_number(value.w));
}

// What half floats hold of it.
fn pictured(value: vec4f) -> vec4f {
    return clamp(held(value), vec4f(-65000.0), vec4f(65000.0));
}
