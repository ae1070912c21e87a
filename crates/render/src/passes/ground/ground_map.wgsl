// ground.map: how much light reaches the plane under the scene, from a parallel light and from everywhere.
// Source: percentage-closer soft shadows (Fernando 2005); form factors of parts of planes that lie over the point,
// h² / π (h² + r²)² each, by points of importance for two heights (Veach & Guibas 1995, the balance heuristic).
// Reads: depths, seen along the light and from below. Writes: the shares of both.
// Program: ground_map.

import package::shaders::samplers::nearest_clamp;

struct GroundMap {
    // X and z of the map's middle, half its width and depth.
    place: vec4f,
    // The height of the plane, how far above it the scene reaches, the heights below which what hangs over it counts as
    // so high: for what touches it, and for what stands on it.
    heights: vec4f,
    // The rows of the tile along the light.
    light_x: vec4f,
    light_y: vec4f,
    light_z: vec4f,
    // Of the light the tangent of half its angle; metres of half the side of its tile, and of its depth; 1 if it casts
    // shadows.
    light: vec4f,
    // The first two rows of the tile from below.
    below_x: vec4f,
    below_y: vec4f,
    // One divided by the texels along the sides of the map; the width of the band along its edge in which light comes
    // back, as a share of its half; zero.
    texels: vec4f,
}

@group(1) @binding(0) var depths: texture_2d<f32>;
@group(1) @binding(1) var<uniform> ground_map: GroundMap;

const GOLDEN_ANGLE: f32 = 2.39996323;
const LIGHT_TAPS: u32 = 32u;
const SKY_TAPS: u32 = 64u;
// Room for rounding.
const DEPTH_SLACK: f32 = 1e-3;

// The depth that a tile, the first or the second, holds at a place from -1 to 1; 0 beyond it.
fn depth_at(tile: f32, place: vec2f) -> f32 {
    let inside = clamp(place, vec2f(-0.998), vec2f(0.998));
    let uv = vec2f(0.5 * tile + 0.25 + 0.25 * inside.x, 0.5 - 0.5 * inside.y);
    let depth = textureSampleLevel(depths, nearest_clamp, uv, 0.0).r;
    return select(0.0, depth, max(abs(place.x), abs(place.y)) < 0.998);
}

// How the samples of a texel lie between those of the texels around it: turned, and moved within their strata.
struct Phase {
    rotation: f32,
    within: f32,
}

// One of 16, in squares of 4 x 4 texels. `ground_smooth.wgsl` takes means in which each of them counts the same: so many
// times the samples of one texel.
fn phase_at(texel: vec2u) -> Phase {
    let column = texel.x % 4u;
    let row = texel.y % 4u;
    let turn = f32(4u * row + column) / 16.0;
    // Neighbours in turn are far apart within the strata: a Latin square.
    let within = (f32((4u * column + row) * 7u % 16u) + 0.5) / 16.0;
    return Phase(6.2831853 * turn, within);
}

fn spiral(index: u32, count: u32, phase: Phase) -> vec2f {
    let angle = f32(index) * GOLDEN_ANGLE + phase.rotation;
    return vec2f(cos(angle), sin(angle)) * sqrt((f32(index) + phase.within) / f32(count));
}

// The share of the parallel light.
fn light_share(point: vec4f, phase: Phase) -> f32 {
    let place = vec2f(dot(ground_map.light_x, point), dot(ground_map.light_y, point));
    let depth = dot(ground_map.light_z, point) + DEPTH_SLACK;
    // By how much the disc of the light grows, in units of half the tile, for every unit of depth.
    let growth = ground_map.light.x * ground_map.light.z / ground_map.light.y;
    let search = growth * (1.0 - min(depth, 1.0));
    var blockers = vec2f(0.0);
    for (var i = 0u; i < LIGHT_TAPS; i++) {
        let blocker = depth_at(0.0, place + spiral(i, LIGHT_TAPS, phase) * search);
        blockers += select(vec2f(0.0), vec2f(blocker, 1.0), blocker > max(depth, 1e-6));
    }
    let nearest = blockers.x / max(blockers.y, 1.0);
    let width = max(growth * (nearest - depth), 0.004);
    var blocked = 0.0;
    for (var i = 0u; i < LIGHT_TAPS; i++) {
        let blocker = depth_at(0.0, place + spiral(i, LIGHT_TAPS, phase) * width);
        blocked += select(0.0, 1.0, blocker > max(depth, 1e-6));
    }
    return 1.0 - ground_map.light.w * blocked / f32(LIGHT_TAPS);
}

// The form factor of a part of a plane that lies over the point, times pi and divided by its area.
fn form_factor(height_m: f32, across_squared: f32) -> f32 {
    let square = height_m * height_m;
    let sum = square + across_squared;
    return square / (sum * sum);
}

// The share of light from everywhere.
fn sky_share(at: vec2f, phase: Phase) -> f32 {
    let low_m = ground_map.heights.z;
    let high_m = ground_map.heights.w;
    var touching = 0.0;
    var standing = 0.0;
    for (var i = 0u; i < SKY_TAPS; i++) {
        // Of every two points one is for each height.
        let u = (f32(i >> 1u) + phase.within) / f32(SKY_TAPS / 2u);
        let across_m = select(high_m, low_m, (i & 1u) == 0u) * sqrt(u / (1.0 - u));
        let angle = f32(i) * GOLDEN_ANGLE + phase.rotation;
        let over = vec4f(at.x + across_m * cos(angle), ground_map.heights.x, at.y + across_m * sin(angle), 1.0);
        let depth = depth_at(1.0, vec2f(dot(ground_map.below_x, over), dot(ground_map.below_y, over)));
        let height_m = (1.0 - depth) * ground_map.heights.y;
        let square = across_m * across_m;
        let density = 0.5 * (form_factor(low_m, square) + form_factor(high_m, square));
        let weight = select(0.0, 1.0 / max(density, 1e-20), depth > 0.0);
        touching += weight * form_factor(max(height_m, low_m), square);
        standing += weight * form_factor(max(height_m, high_m), square);
    }
    return 1.0 - min(max(touching, standing) / f32(SKY_TAPS), 1.0);
}

@fragment
fn fs_ground_map(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = position.xy * ground_map.texels.x * 2.0 - 1.0;
    let at = ground_map.place.xy + place * ground_map.place.zw;
    let phase = phase_at(vec2u(position.xy));
    let point = vec4f(at.x, ground_map.heights.x, at.y, 1.0);
    let shares = vec2f(light_share(point, phase), sky_share(at, phase));
    let inside = clamp((1.0 - max(abs(place.x), abs(place.y))) / ground_map.texels.y, 0.0, 1.0);
    return vec4f(mix(vec2f(1.0), shares, smoothstep(0.0, 1.0, inside)), 0.0, 1.0);
}
