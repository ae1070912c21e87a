//! simulation ripples
//! start: still -> water
//! step: wave -> water
//! shows: waves, color
//! rate: 240

// Waves on shallow water: the wave equation of a height, with damping, on a grid whose edges and walls throw waves back.
// Drops fall by chance, and bodies push water away as they move through the surface.
// Steps are those of the semi-implicit Euler method, which keeps energy where nothing damps: speed first, then height. They
// hold while speed_m_s is below 0.7 sides of a cell a step (Courant, Friedrichs & Lewy 1928).

struct Ripples {
    /// The speed of waves: the square root of gravity times depth, m/s
    // = 0.7 in 0..100
    speed_m_s: f32,
    /// The damping: the rate at which waves lose energy, 1/s
    // = 0.4 in 0..1000
    damping_per_s: f32,
    /// The number of drops, 1/s
    // = 0 in 0..10000
    drops_per_s: f32,
    /// The radius of a drop, m
    // = 0.05 in 0.0001..1000
    drop_m: f32,
    /// The depth of a drop's hole, m
    // = 0.01 in -1000..1000
    drop_depth_m: f32,
    /// The height of an initial hill of water, m
    // = 0 in -1000..1000
    first_m: f32,
    /// The position of that hill, as shares of the width from the left and of the height from above.
    // = 0.5, 0.5 in 0..1
    first_place: vec2f,
    /// The share of water that a body displaces, share
    // = 0.3 in 0..1
    push: f32,
    /// The viscosity, which damps short waves first, m²/s
    // = 0.0004 in 0..100
    viscosity_m2_s: f32,
    padding: vec2f,
}

@group(2) @binding(0) var<uniform> ripples: Ripples;

// Metres of a column that bodies take below the surface at rest, and 1 within a wall.
fn taken(cell: vec2i) -> vec2f {
    let here = metres_at(cell);
    var depth = 0.0;
    var wall = 0.0;
    for (var i = 0u; i < simulation.body_count; i++) {
        let body = simulation.bodies[i];
        let away = here - body.middle_m.xy;
        if body.is_wall != 0.0 {
            let is_within = all(abs(away) < body.half_m.xy) && abs(body.middle_m.z) < body.half_m.z;
            wall = select(wall, 1.0, is_within);
        } else {
            let half = sqrt(max(body.radius_m * body.radius_m - dot(away, away), 0.0));
            depth += min(body.middle_m.z + half, 0.0) - min(body.middle_m.z - half, 0.0);
        }
    }
    return vec2f(depth * ripples.push, wall);
}

// x: height in metres, y: how fast it rises, z: metres that bodies take, w: 1 in a wall.
fn still(cell: vec2i) -> vec4f {
    let found = taken(cell);
    let middle = (ripples.first_place - 0.5) * vec2f(simulation.cells) * simulation.cell_m * vec2f(1.0, -1.0);
    let away = (metres_at(cell) - middle) / ripples.drop_m;
    return vec4f(ripples.first_m * exp(-dot(away, away)) * (1.0 - found.y), 0.0, found);
}

// Height and speed beside a cell: those of the cell itself where a wall or the edge is.
fn beside(cell: vec2i, here: vec4f) -> vec2f {
    let there = water_at(cell);
    return select(there.xy, here.xy, there.w != 0.0);
}

fn wave(cell: vec2i) -> vec4f {
    let here = water_at(cell);
    let found = taken(cell);
    if found.y != 0.0 {
        return vec4f(0.0, 0.0, found);
    }
    let across = beside(cell - vec2i(1, 0), here) + beside(cell + vec2i(1, 0), here) - 2.0 * here.xy;
    let along = beside(cell - vec2i(0, 1), here) + beside(cell + vec2i(0, 1), here) - 2.0 * here.xy;
    let bend = across / (simulation.cell_m.x * simulation.cell_m.x) + along / (simulation.cell_m.y * simulation.cell_m.y);
    let dt = simulation.step_secs;
    let pull = ripples.speed_m_s * ripples.speed_m_s * bend.x + ripples.viscosity_m2_s * bend.y;
    let rise = here.y * exp(-ripples.damping_per_s * dt) + dt * pull;
    var height = here.x + dt * rise + found.x - here.z;
    let chance = random(vec3u(simulation.step, 0u, 0u));
    if chance.x < ripples.drops_per_s * dt {
        // A hole with a rim, so that there is as much water as before.
        let middle = (chance.yz - 0.5) * vec2f(simulation.cells) * simulation.cell_m;
        let away = (metres_at(cell) - middle) / ripples.drop_m;
        height -= ripples.drop_depth_m * (1.0 - dot(away, away)) * exp(-dot(away, away));
    }
    return vec4f(height, rise, found);
}

fn waves(cell: vec2i) -> vec4f {
    let here = water_at(cell);
    let right = beside(cell + vec2i(1, 0), here).x - beside(cell - vec2i(1, 0), here).x;
    let up = beside(cell - vec2i(0, 1), here).x - beside(cell + vec2i(0, 1), here).x;
    return waves_of(vec2f(right, up) / (2.0 * simulation.cell_m));
}

fn color(cell: vec2i) -> vec4f {
    let here = water_at(cell);
    let bright = clamp(0.5 + 0.5 * here.x / max(abs(ripples.drop_depth_m) + abs(ripples.first_m), 1e-6), 0.0, 1.0);
    return vec4f(mix(vec3f(0.01, 0.05, 0.12), vec3f(0.75, 0.9, 1.0), bright * bright) * (1.0 - here.w), 1.0);
}
