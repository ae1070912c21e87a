// What the passes of particles know of them.

struct Particles {
    // Albedo, and the colour of what they emit.
    color: vec3f,
    // What they emit, times the colour, pre-exposed.
    emission: f32,
    // Radius at the beginning of their life and at its end, in metres.
    radius_m: vec2f,
    opacity: f32,
    // For how many seconds of their way they are drawn.
    stretch_secs: f32,
    // How far before a surface they begin to fade, in metres.
    softness_m: f32,
    // Columns of the states.
    columns: u32,
    // How many of the system shade each of it.
    occluders: u32,
    // How ragged their edges are, from 0 to 1.
    raggedness: f32,
}

@group(1) @binding(1) var<uniform> particles: Particles;
// Place in world space, and age in seconds, below 0 where there is none.
@group(1) @binding(2) var place: texture_2d<f32>;
// Metres a second, and how long it lives, in seconds.
@group(1) @binding(3) var velocity: texture_2d<f32>;

// The most that the middle of one hides.
const OPACITY_MAX: f32 = 0.98;

// The radius in metres after a share of their life.
fn radius_at(share: f32) -> f32 {
    return mix(particles.radius_m.x, particles.radius_m.y, share);
}

// How much the middle of one hides then: it fades in, and out in the second half of its life.
fn opacity_at(share: f32) -> f32 {
    return particles.opacity * smoothstep(0.0, 0.1, share) * (1.0 - smoothstep(0.5, 1.0, share));
}
