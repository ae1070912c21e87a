//! simulation fluid
//! step: carry -> flow, press -> pressure x iterations, free -> flow, spread -> smoke
//! shows: color
//! rate: 60
//! cells: 192x192

// Smoke in a box: a fluid that does not compress, with buoyancy, a source, and bodies and walls that it goes around.
// Source: Stam 1999, "Stable Fluids", on faces of cells (Harlow & Welch 1965): what leaves a cell after `free` is what `press` has
// left of its equation, the fewer the more iterations.

struct Fluid {
    /// The iterations of the pressure solver in a step, which starts from the last step's pressure.
    // = 24 in 1..64
    iterations: u32,
    /// The buoyancy: the upward acceleration per amount of smoke, m/s²
    // = 1.2 in -100..100
    buoyancy: f32,
    /// The rate at which smoke fades, 1/s
    // = 0.25 in 0..100
    fade_per_s: f32,
    /// Vorticity confinement: the strength that restores eddies which the grid damps, share
    // = 0.35 in 0..2
    swirl: f32,
    /// The position of the source, as shares of the width from the left and of the height from above.
    // = 0.5, 0.9 in 0..1
    source: vec2f,
    /// The width of the source, share of the width
    // = 0.05 in 0..1
    source_radius: f32,
    /// The amount of smoke from the source, 1/s
    // = 6 in 0..1000
    source_rate: f32,
    /// The velocity of smoke at the source, to the right and up, m/s
    // = 0, 0.5 in -100..100
    source_speed: vec2f,
    padding_a: vec2f,
    /// The colour of the smoke, linear Rec. 709
    // = 0.9, 0.75, 0.55 in 0..
    smoke_color: vec3f,
    padding_b: f32,
    /// The colour without smoke, linear Rec. 709
    // = 0.01, 0.012, 0.02 in 0..
    back_color: vec3f,
    padding_c: f32,
}

@group(2) @binding(0) var<uniform> fluid: Fluid;

// How fast what is solid at a cell moves, to the right and down the rows; z is 1 where anything is.
fn solid_at(cell: vec2i) -> vec3f {
    if any(cell < vec2i(0)) || any(cell >= simulation.cells) {
        return vec3f(0.0, 0.0, 1.0);
    }
    let here = metres_at(cell);
    for (var i = 0u; i < simulation.body_count; i++) {
        let body = simulation.bodies[i];
        let away = here - body.middle_m.xy;
        let height = body.middle_m.z;
        let in_box = all(abs(away) < body.half_m.xy) && abs(height) < body.half_m.z;
        let in_sphere = dot(away, away) + height * height < body.radius_m * body.radius_m;
        if select(in_sphere, in_box, body.is_wall != 0.0) {
            let moved = (body.middle_m - body.before_m).xy / simulation.step_secs;
            return vec3f(moved * vec2f(1.0, -1.0), 1.0);
        }
    }
    return vec3f(0.0);
}

// The speed at a place, in cells; that to the right is known in the middle of left faces, that down in the middle of upper ones.
fn speed_at(place: vec2f) -> vec2f {
    return vec2f(flow_between(place + vec2f(0.5, 0.0)).x, flow_between(place + vec2f(0.0, 0.5)).y);
}

// How the flow turns at the corner where four cells meet: the upper left one of a cell.
fn turning_at(cell: vec2i) -> f32 {
    let down = flow_at(cell).y - flow_at(cell - vec2i(1, 0)).y;
    let right = flow_at(cell).x - flow_at(cell - vec2i(0, 1)).x;
    return down / simulation.cell_m.x - right / simulation.cell_m.y;
}

// What helps eddies (Fedkiw, Stam & Jensen 2001), at the upper left corner of a cell.
fn help_at(cell: vec2i) -> vec2f {
    let turning = turning_at(cell);
    let right = abs(turning_at(cell + vec2i(1, 0))) - abs(turning_at(cell - vec2i(1, 0)));
    let down = abs(turning_at(cell + vec2i(0, 1))) - abs(turning_at(cell - vec2i(0, 1)));
    let uphill = vec2f(right, down) / max(length(vec2f(right, down)), 1e-6);
    return vec2f(uphill.y, -uphill.x) * turning * fluid.swirl * simulation.cell_m;
}

fn source_share(place: vec2f) -> f32 {
    let away = (place - fluid.source * vec2f(simulation.cells)) / (fluid.source_radius * f32(simulation.cells.x));
    return exp(-dot(away, away));
}

// x: to the right through the left face of a cell, y: down through its upper face, in m/s; z: 1 where the cell is solid.
fn carry(cell: vec2i) -> vec4f {
    let dt = simulation.step_secs;
    let left = vec2f(cell) + vec2f(0.0, 0.5);
    let upper = vec2f(cell) + vec2f(0.5, 0.0);
    let back = dt / simulation.cell_m;
    var speed = vec2f(speed_at(left - speed_at(left) * back).x, speed_at(upper - speed_at(upper) * back).y);
    speed.x += dt * 0.5 * (help_at(cell).x + help_at(cell + vec2i(0, 1)).x);
    speed.y += dt * 0.5 * (help_at(cell).y + help_at(cell + vec2i(1, 0)).y);
    speed.y -= dt * fluid.buoyancy * 0.5 * (smoke_at(cell).x + smoke_at(cell - vec2i(0, 1)).x);
    let blown = fluid.source_speed * vec2f(1.0, -1.0);
    let share = min(dt * 10.0, 1.0) * step(1e-6, length(blown));
    speed.x = mix(speed.x, blown.x, share * source_share(left));
    speed.y = mix(speed.y, blown.y, share * source_share(upper));
    // No more goes through a face than what is solid there allows.
    let here = solid_at(cell);
    let left_solid = solid_at(cell - vec2i(1, 0));
    let upper_solid = solid_at(cell - vec2i(0, 1));
    speed.x = select(speed.x, left_solid.x, left_solid.z != 0.0);
    speed.y = select(speed.y, upper_solid.y, upper_solid.z != 0.0);
    return vec4f(select(speed, here.xy, here.z != 0.0), here.z, 0.0);
}

// Whether a cell is solid, or beyond the edges of the box.
fn is_solid(cell: vec2i) -> bool {
    return any(cell < vec2i(0)) || any(cell >= simulation.cells) || flow_at(cell).z != 0.0;
}

// The speed through a face; there is none through the edges of the box.
fn across_at(cell: vec2i) -> f32 {
    return select(flow_at(cell).x, 0.0, cell.x >= simulation.cells.x);
}

fn down_at(cell: vec2i) -> f32 {
    return select(flow_at(cell).y, 0.0, cell.y >= simulation.cells.y);
}

// How much more leaves a cell than comes into it, 1/s.
fn leaving_at(cell: vec2i) -> f32 {
    let across = (across_at(cell + vec2i(1, 0)) - across_at(cell)) / simulation.cell_m.x;
    return across + (down_at(cell + vec2i(0, 1)) - down_at(cell)) / simulation.cell_m.y;
}

fn press(cell: vec2i) -> vec4f {
    if is_solid(cell) {
        return vec4f(0.0);
    }
    var sum = -leaving_at(cell);
    var weight = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let axis = i >> 1u;
        let side = select(-1, 1, (i & 1u) != 0u);
        let other = cell + select(vec2i(side, 0), vec2i(0, side), axis == 1u);
        let length_m = simulation.cell_m[axis];
        let share = select(1.0 / (length_m * length_m), 0.0, is_solid(other));
        sum += share * pressure_at(other).x;
        weight += share;
    }
    let pressure = sum / max(weight, 1e-12);
    // y: what the pressure before leaves of the equation, 1/s.
    return vec4f(pressure, weight * (pressure - pressure_at(cell).x), 0.0, 0.0);
}

fn free(cell: vec2i) -> vec4f {
    let flow = flow_at(cell);
    let here = pressure_at(cell).x;
    let before = vec2f(pressure_at(cell - vec2i(1, 0)).x, pressure_at(cell - vec2i(0, 1)).x);
    let is_open = vec2<bool>(!is_solid(cell - vec2i(1, 0)), !is_solid(cell - vec2i(0, 1)));
    let push = select(vec2f(0.0), (here - before) / simulation.cell_m, is_open);
    return vec4f(flow.xy - select(push, vec2f(0.0), flow.z != 0.0), flow.z, 0.0);
}

// x: how much smoke there is.
fn spread(cell: vec2i) -> vec4f {
    if is_solid(cell) {
        return vec4f(0.0);
    }
    let dt = simulation.step_secs;
    let here = vec2f(cell) + 0.5;
    let origin = here - speed_at(here) * dt / simulation.cell_m;
    let chance = random(vec3u(simulation.step / 4u, 0u, 0u));
    let more = fluid.source_rate * dt * (0.5 + chance.x) * source_share(here + (chance.yz - 0.5) * 4.0);
    return vec4f(min(smoke_between(origin).x * exp(-fluid.fade_per_s * dt) + more, 8.0), 0.0, 0.0, 0.0);
}

fn color(cell: vec2i) -> vec4f {
    let share = 1.0 - exp(-smoke_at(cell).x);
    let solid = flow_at(cell).z;
    return vec4f(mix(mix(fluid.back_color, fluid.smoke_color, share), vec3f(0.12), solid), 1.0);
}
