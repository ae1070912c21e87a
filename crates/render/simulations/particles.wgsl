//! simulation particles
//! start: none -> place
//! step: speed -> velocity, go -> place
//! shows: ages
//! cells: 256x4
//! rate: 60
//! reads: surfaces

// Particles, one in each cell, that are born one after the other, move, and die: their places and velocities in metres of world
// space. What is born takes the cell of the one that has been dead for longest; there are never more than `count`.

struct Particles {
    /// The most particles at once.
    // = 1024 in 1..1048576
    count: u32,
    /// The birth rate; 0 is the most that there is room for, 1/s
    // = 0 in 0..
    rate_per_s: f32,
    /// The shortest and the longest life, s
    // = 1, 2 in 0.01..10000
    life_s: vec2f,
    /// The middle of the emitter, m
    // = 0, 0, 0
    center: vec3f,
    /// The shape of the emitter: 0 a box, 1 the ellipsoid in it, 2 the upright disk in it.
    // = 0 in 0..2
    shape: u32,
    /// The extent of the emitter, m
    // = 0, 0, 0 in 0..
    size_m: vec3f,
    /// The random part of the initial velocity, at most, m/s
    // = 0 in 0..1000
    spread_m_s: f32,
    /// The initial velocity, m/s
    // = 0, 0, 0
    velocity_m_s: vec3f,
    /// The gravity, m/s²
    // = 9.81 in -1000..1000
    gravity_m_s2: f32,
    /// The velocity of the wind, m/s
    // = 0, 0, 0
    wind_m_s: vec3f,
    /// The drag: the rate at which they lose speed relative to the air, 1/s
    // = 0 in 0..1000
    drag_per_s: f32,
    /// The speed of turbulence, m/s
    // = 0 in 0..1000
    swirl_m_s: f32,
    /// The size of turbulent swirls, m
    // = 1 in 0.001..10000
    swirl_m: f32,
    /// The restitution at collisions; below 0 they end there, share
    // = 0 in -1..1
    bounce: f32,
    /// The friction at collisions, share
    // = 0.2 in 0..1
    friction: f32,
    /// A plane that they do not pass: the normal, and the product of the plane's points with it. The normal 0 is no plane.
    // = 0, 1, 0, 0
    floor: vec4f,
    /// A second such plane.
    // = 0, 0, 0, 0
    wall: vec4f,
}

@group(2) @binding(0) var<uniform> particles: Particles;

// How often a number goes into another, both below 2²⁴. Processors divide floats side by side, and integers one by one.
fn times(number: u32, by: u32) -> u32 {
    let near = u32(f32(number) / f32(by));
    let more = select(near, near + 1u, (near + 1u) * by <= number);
    return select(more, near - 1u, near * by > number);
}

// What is left of a number after another, which is below 2²⁴.
fn rest(number: u32, by: u32) -> u32 {
    let inverse = 1.0 / f32(by);
    // Twice, because a large number is no float; then what is left is by one of them too much or too little at most.
    let first = number - u32(f32(number) * inverse) * by;
    let left = bitcast<i32>(first) - i32(floor(f32(bitcast<i32>(first)) * inverse)) * i32(by);
    let more = select(left, left + i32(by), left < 0);
    return u32(select(more, more - i32(by), more >= i32(by)));
}

// How many are born by the end of so many steps, the first at once: as many as there is place for, at most.
fn born_by(steps: u32) -> u32 {
    let most = f32(particles.count) / max(particles.life_s.x, particles.life_s.y);
    let rate = select(min(particles.rate_per_s, most), most, particles.rate_per_s <= 0.0);
    // In whole seconds and the rest of them, because floats have 24 bits.
    let per_s = u32(round(1.0 / simulation.step_secs));
    let whole = times(steps, max(per_s, 1u));
    let rest = f32(steps - whole * per_s) * simulation.step_secs * rate;
    let of_whole = f32(whole) * fract(rate) + rest;
    return (whole * u32(rate) + u32(of_whole) + 1u) * min(steps, 1u);
}

fn index_of(cell: vec2i) -> u32 {
    return u32(cell.y * simulation.cells.x + cell.x);
}

// Whether a particle is born in a step, and the how-manieth of all it is.
fn birth_of(cell: vec2i) -> vec2u {
    let index = index_of(cell);
    let first = born_by(simulation.step);
    let end = born_by(simulation.step + 1u);
    let count = particles.count;
    let ahead = index + count - rest(first, count);
    let number = first + select(ahead, ahead - count, ahead >= count);
    return vec2u(select(0u, 1u, index < count && number < end), number);
}

// A direction in a ball.
fn in_ball(chance: vec3f) -> vec3f {
    let height = 2.0 * chance.x - 1.0;
    let around = 6.2831853 * chance.y;
    let ring = sqrt(max(1.0 - height * height, 0.0));
    return vec3f(ring * cos(around), height, ring * sin(around)) * pow(chance.z, 1.0 / 3.0);
}

fn place_at_birth(number: u32) -> vec3f {
    let chance = random(vec3u(number, 1u, 0u)).xyz;
    let around = 6.2831853 * chance.x;
    let in_disk = vec3f(0.5 * sqrt(chance.y) * vec2f(cos(around), sin(around)), chance.z - 0.5).xzy;
    let at = select(select(chance - 0.5, 0.5 * in_ball(chance), particles.shape == 1u), in_disk, particles.shape == 2u);
    return particles.center + at * particles.size_m;
}

// From -1 to 1, another number at every corner of the noise.
fn chance_at(corner: vec3i, what: u32) -> f32 {
    return 2.0 * random(bitcast<vec3u>(corner) + vec3u(what * 7919u)).x - 1.0;
}

// The slopes of smooth noise that repeats nowhere near.
fn noise_slopes(at: vec3f, what: u32) -> vec3f {
    let cell = floor(at);
    let f = at - cell;
    let u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let du = 30.0 * f * f * (f * (f - 2.0) + 1.0);
    let first = vec3i(cell);
    let a = vec4f(
        chance_at(first, what),
        chance_at(first + vec3i(1, 0, 0), what),
        chance_at(first + vec3i(0, 1, 0), what),
        chance_at(first + vec3i(1, 1, 0), what),
    );
    let b = vec4f(
        chance_at(first + vec3i(0, 0, 1), what),
        chance_at(first + vec3i(1, 0, 1), what),
        chance_at(first + vec3i(0, 1, 1), what),
        chance_at(first + vec3i(1, 1, 1), what),
    );
    let low = mix(mix(a.x, a.y, u.x), mix(a.z, a.w, u.x), u.y);
    let high = mix(mix(b.x, b.y, u.x), mix(b.z, b.w, u.x), u.y);
    let x_low = mix(a.y - a.x, a.w - a.z, u.y);
    let x_high = mix(b.y - b.x, b.w - b.z, u.y);
    let y_low = mix(a.z, a.w, u.x) - mix(a.x, a.y, u.x);
    let y_high = mix(b.z, b.w, u.x) - mix(b.x, b.y, u.x);
    return du * vec3f(mix(x_low, x_high, u.z), mix(y_low, y_high, u.z), high - low);
}

// Air that swirls and neither comes nor goes: the curl of three noises (Bridson, Houriham & Nordenstam 2007, "Curl-Noise for
// Procedural Fluid Flow").
fn swirl_at(place: vec3f) -> vec3f {
    let at = place / particles.swirl_m + vec3f(0.0, 0.15, 0.0) * simulation.time_secs;
    let x = noise_slopes(at, 0u);
    let y = noise_slopes(at, 1u);
    let z = noise_slopes(at, 2u);
    return particles.swirl_m_s * vec3f(z.y - y.z, x.z - z.x, y.x - x.y);
}

// What a particle meets on its way: the normal there, and how deep in it would be (at most 0: nothing).
fn met_at(before: vec3f, after: vec3f) -> vec4f {
    let of_floor = behind_plane(particles.floor, after);
    let of_wall = behind_plane(particles.wall, after);
    let of_planes = select(of_floor, of_wall, of_wall.w > of_floor.w);
    let of_seen = seen_surface(before, after);
    return select(of_planes, of_seen, of_seen.w > of_planes.w);
}

// The normal of a plane, and how deep behind it a place is; 0 where it is before it, or there is none.
fn behind_plane(plane: vec4f, place: vec3f) -> vec4f {
    let square = dot(plane.xyz, plane.xyz);
    let share = select(0.0, inverseSqrt(max(square, 1e-20)), square > 0.0);
    return vec4f(plane.xyz * share, max((plane.w - dot(plane.xyz, place)) * share, 0.0));
}

// xyz: metres, w: age in seconds, below 0 where there is none.
fn none(cell: vec2i) -> vec4f {
    return vec4f(0.0, 0.0, 0.0, -1.0);
}

// xyz: metres a second, w: the length of its life; below 0 of what has ended by what it met.
fn speed(cell: vec2i) -> vec4f {
    let birth = birth_of(cell);
    if birth.x != 0u {
        let chance = random(vec3u(birth.y, 2u, 0u));
        let spread = in_ball(random(vec3u(birth.y, 3u, 0u)).xyz) * particles.spread_m_s;
        return vec4f(particles.velocity_m_s + spread, mix(particles.life_s.x, particles.life_s.y, chance.x));
    }
    let here = place_at(cell);
    var velocity = velocity_at(cell);
    if here.w < 0.0 {
        return velocity;
    }
    let dt = simulation.step_secs;
    var air = particles.wind_m_s;
    // Conditions on uniforms alone make software adapters compile anew.
    if (here.w >= 0.0) & (particles.swirl_m_s > 0.0) {
        air += swirl_at(here.xyz);
    }
    var moved = air + (velocity.xyz - air) * exp(-particles.drag_per_s * dt);
    moved.y -= particles.gravity_m_s2 * dt;
    let met = met_at(here.xyz, here.xyz + moved * dt);
    if met.w > 0.0 {
        let into = min(dot(moved, met.xyz), 0.0);
        let along = moved - into * met.xyz;
        moved = along * (1.0 - particles.friction) - into * max(particles.bounce, 0.0) * met.xyz;
        velocity.w = select(velocity.w, -1.0, particles.bounce < 0.0);
    }
    return vec4f(moved, velocity.w);
}

fn go(cell: vec2i) -> vec4f {
    let birth = birth_of(cell);
    let here = place_at(cell);
    let velocity = velocity_at(cell);
    if birth.x != 0u {
        return vec4f(place_at_birth(birth.y), 0.0);
    }
    let age = here.w + simulation.step_secs;
    if here.w < 0.0 || velocity.w < 0.0 || age >= velocity.w {
        return vec4f(here.xyz, -1.0);
    }
    var at = here.xyz + velocity.xyz * simulation.step_secs;
    let met = met_at(here.xyz, at);
    at += met.xyz * max(met.w, 0.0);
    return vec4f(at, age);
}

fn ages(cell: vec2i) -> vec4f {
    let share = place_at(cell).w / max(velocity_at(cell).w, 1e-6);
    return vec4f(vec3f(max(share, 0.0)), 1.0);
}
