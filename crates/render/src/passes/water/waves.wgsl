// The slopes of waves: two copies of one map that move over each other, or what a simulation has made of them, with how
// much of the slopes is too fine for a pixel.
// Sources: two scrolling maps (Vlachos 2010, "Water Flow in Portal 2", and many before); moments of slopes that are
// filtered linearly (Olano & Baker 2010, "LEAN Mapping").

import package::passes::water::uniform::water;
import package::view::view;

// Slopes along x and y, and their squares; or a normal map.
@group(1) @binding(11) var waves: texture_2d<f32>;
@group(1) @binding(12) var linear_repeat: sampler;

// 1 if the map is one of normals.
override has_normal_map: u32 = 0u;

// 1 if the map is a simulation's, over a rectangle: moments of slopes, as they are.
override has_simulation: u32 = 0u;

// How much longer than wide the footprint of a pixel may be before it is filtered along its length, too.
const ANISOTROPY: f32 = 4.0;

// Slopes in the directions of the surface's x and y, and the variance of what is too fine, of both together.
struct Slopes {
    mean: vec2f,
    variance: f32,
}

fn slopes_of_texel(texel: vec4f) -> Slopes {
    if has_normal_map != 0u {
        let normal = texel.xyz * 2.0 - 1.0;
        let size = clamp(length(normal), 1e-3, 1.0);
        // What a mean of unit vectors lacks tells their spread (Toksvig 2005).
        return Slopes(-normal.xy / max(normal.z, 0.1), 2.0 * (1.0 - size) / size);
    }
    let squares = texel.zw - texel.xy * texel.xy;
    return Slopes(texel.xy, max(squares.x + squares.y, 0.0));
}

// The level of a map of which a pixel's steps are so many texels.
fn level_of(sides: vec2f) -> f32 {
    let long = max(sides.x, sides.y);
    let footprint = max(min(sides.x, sides.y), long / ANISOTROPY);
    return max(log2(max(footprint, 1e-6)) - view.mip_gain, 0.0);
}

// Of a simulation, beyond whose edges the water is as at them.
fn slopes_of_simulation(at: vec2f, step_x: vec2f, step_y: vec2f) -> Slopes {
    let right = water.copies[0];
    let up = water.copies[1];
    let texels = vec2f(textureDimensions(waves));
    let along_x = vec2f(dot(step_x, right.xy), dot(step_x, up.xy)) * texels;
    let along_y = vec2f(dot(step_y, right.xy), dot(step_y, up.xy)) * texels;
    let uv = vec2f(dot(at, right.xy) + right.z, 1.0 - dot(at, up.xy) - up.z);
    let within = clamp(uv, 0.5 / texels, 1.0 - 0.5 / texels);
    let level = level_of(vec2f(length(along_x), length(along_y)));
    let found = slopes_of_texel(textureSampleLevel(waves, linear_repeat, within, level));
    // An axis that stands on the water has no length in it.
    let to_right = right.xy * inverseSqrt(max(dot(right.xy, right.xy), 1e-20));
    let to_up = up.xy * inverseSqrt(max(dot(up.xy, up.xy), 1e-20));
    return Slopes(found.mean.x * to_right + found.mean.y * to_up, found.variance);
}

// One copy: `placed` is its turn divided by its side, and how far it has moved.
fn slopes_of_copy(at: vec2f, step_x: vec2f, step_y: vec2f, placed: vec4f) -> Slopes {
    let texels_a_metre = length(placed.xy) * f32(textureDimensions(waves).x);
    let level = level_of(vec2f(length(step_x), length(step_y)) * texels_a_metre);
    let place = vec2f(dot(at, placed.xy), dot(at, vec2f(-placed.y, placed.x))) + placed.zw;
    // An image's rows go down.
    let found = slopes_of_texel(textureSampleLevel(waves, linear_repeat, vec2f(place.x, -place.y), level));
    let turn = placed.xy * inverseSqrt(max(dot(placed.xy, placed.xy), 1e-30));
    let mean = vec2f(found.mean.x * turn.x - found.mean.y * turn.y, found.mean.x * turn.y + found.mean.y * turn.x);
    return Slopes(mean, found.variance);
}

// At a place on the surface, in metres, of which a pixel's steps are so long.
fn slopes_at(at: vec2f, step_x: vec2f, step_y: vec2f) -> Slopes {
    if has_simulation != 0u {
        return slopes_of_simulation(at, step_x, step_y);
    }
    let first = slopes_of_copy(at, step_x, step_y, water.copies[0]);
    let second = slopes_of_copy(at, step_x, step_y, water.copies[1]);
    let steepness = water.steepness;
    return Slopes((first.mean + second.mean) * steepness, (first.variance + second.variance) * steepness * steepness);
}
