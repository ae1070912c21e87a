// How particles of a system shade and hide each other: the optical depth of those that lie between a particle and its light,
// and between it and the eye.
// Source: columns through balls of the profile in which `particles.wgsl` draws them; light that is scattered more than once
// on its way as the brighter of two exponentials (Schneider 2015, "The Real-Time Volumetric Cloudscapes of Horizon: Zero
// Dawn"). Of large systems some stand for all: they are wider, as the cube root of how many each stands for, so that a
// shadow has no grain.
// Reads: the states of what moves them.

import package::passes::particles::uniform::{OPACITY_MAX, opacity_at, particles, place, radius_at, velocity};

// What comes through by more than one scattering: its share, and how much of the optical depth it meets.
const SCATTERED: f32 = 0.7;
const SCATTERED_DEPTH: f32 = 0.25;

// The optical depth on a line of sight is counted as less than that: the line is one through the particle's middle, and
// pixels beside it would be too bright or too dark.
const SEEN_DEPTH_MAX: f32 = 4.0;

// Optical depths from a particle in a direction, straight up, straight down and to the eye.
struct Depths {
    around: vec4f,
    // On the whole line of sight.
    in_sight: f32,
}

// Those from the particle `own`.
fn depths_around(own: u32, middle_world: vec3f, towards: vec3f, to_eye: vec3f) -> Depths {
    let size = textureDimensions(place);
    let cells = size.x * size.y;
    let stride = f32(cells) / f32(max(particles.occluders, 1u));
    let wider = pow(stride, 1.0 / 3.0);
    // How long loops are depends on more than uniforms, see docs/decisions/006.
    let count = select(0u, particles.occluders, own < cells);
    var depths = Depths(vec4f(0.0), 0.0);
    for (var i = 0u; i < count; i++) {
        let index = u32((f32(i) + 0.5) * stride);
        let cell = vec2i(vec2u(index % size.x, index / size.x));
        let at = textureLoad(place, cell, 0);
        let life_secs = textureLoad(velocity, cell, 0).w;
        let share = clamp(at.w / max(life_secs, 1e-6), 0.0, 1.0);
        // In radii.
        let offset = (at.xyz - middle_world) / max(wider * radius_at(share), 1e-6);
        let along = vec4f(dot(offset, towards), offset.y, -offset.y, dot(offset, to_eye));
        let round = max(vec4f(1.0 - dot(offset, offset)) + along * along, vec4f(0.0));
        // Half of what is as far away as the particle itself lies before it.
        let before = clamp(0.5 + 0.5 * along, vec4f(0.0), vec4f(1.0));
        let depth = -log(1.0 - min(opacity_at(share), OPACITY_MAX));
        let column = select(0.0, depth, (at.w >= 0.0) & (index != own)) * round * round;
        depths.around += column * before;
        depths.in_sight += column.w;
    }
    // Each is as many as a stride, over an area as much larger as they are wider.
    let each = stride / (wider * wider);
    return Depths(depths.around * each, depths.in_sight * each);
}

// How much light comes through an optical depth.
fn comes_through(depth: vec3f) -> vec3f {
    return max(exp(-depth), SCATTERED * exp(-SCATTERED_DEPTH * depth));
}

// What a particle counts in the mean by optical depth, so that those before hide those behind: what comes through to the eye
// of it, over the mean of that along its line of sight.
fn weight_in_sight(depths: Depths) -> f32 {
    let scale = SEEN_DEPTH_MAX / (SEEN_DEPTH_MAX + depths.in_sight);
    let whole = max(scale * depths.in_sight, 1e-3);
    return exp(-scale * depths.around.w) * whole / (1.0 - exp(-whole));
}
