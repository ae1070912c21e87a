// Light that arrives at places, for the surfaces between them: spherical harmonics of order 2 (Ramamoorthi & Hanrahan
// 2001) or six colours (McTaggart 2004), of the eight probes around a place by how near they are and by what they see of it
// (Majercik et al. 2019, "Dynamic Diffuse Global Illumination with Ray-Traced Irradiance Fields").

import package::constants::{PROBE_DISTANCE_SIDE, PROBE_TEXELS};
import package::shaders::environment_uniform::{ProbeGrid, environment, environment_tiles};
import package::shaders::octahedral::{direction_from_octahedral, octahedral_wrap};
import package::shaders::shading::linear_clamp;

// How many grids there are.
override probe_grids: u32 = 0u;
// Their light is spherical harmonics; 1 if it is six colours; 2 if there are both.
override probe_bases: u32 = 0u;

// Probes that lie behind a surface count so much, and those that see it hardly are crushed below the second. Those with less
// than the third of all do not count at all, so that their light need not be read.
const BEHIND: f32 = 0.05;
const CRUSHED: f32 = 0.2;
const LEAST: f32 = 0.01;
// What a probe counts that is on the other side of a surface's plane.
const OTHER_SIDE: f32 = 0.002;

// Light of a probe, or of several added up: coefficients, of which the ninth lies in the last places of the first three; or the
// colours of the three faces that a normal sees. And what a small source gives by its cosine.
struct ProbeLight {
    a: vec4f,
    b: vec4f,
    c: vec4f,
    d: vec4f,
    e: vec4f,
    f: vec4f,
    g: vec4f,
    h: vec4f,
    of_source: vec3f,
}

fn has_colors(grid: ProbeGrid) -> bool {
    return probe_bases == 1u || (probe_bases == 2u && grid.center.w > 0.5);
}

// The column and row of a probe among those of its grid in the texture, where some layers along Z lie beside each other.
fn probe_cell(grid: ProbeGrid, at: vec3f) -> vec2f {
    let row = floor((at.z + 0.5) / grid.counts.w);
    let column = at.z - row * grid.counts.w;
    return vec2f(at.x + column * grid.counts.x, at.y + row * grid.counts.y);
}

// Of a probe the first of its texels: how far it was moved, and 0 if it is off, else 1 and how wide its small source is. Those
// of its light follow.
fn probe_texel(grid: ProbeGrid, cell: vec2f) -> vec2i {
    return vec2i(grid.corners.xy + cell * vec2f(f32(PROBE_TEXELS), 1.0));
}

fn probe_place(texel: vec2i) -> vec4f {
    return textureLoad(environment_tiles, texel, 0);
}

// `place` is the first of its texels.
fn probe_light_at(grid: ProbeGrid, texel: vec2i, place: vec4f, normal: vec3f) -> ProbeLight {
    var light = ProbeLight();
    if has_colors(grid) {
        let faces = vec3i(vec3u(normal < vec3f(0.0))) + vec3i(1, 3, 5);
        light.a = textureLoad(environment_tiles, texel + vec2i(faces.x, 0), 0);
        light.b = textureLoad(environment_tiles, texel + vec2i(faces.y, 0), 0);
        light.c = textureLoad(environment_tiles, texel + vec2i(faces.z, 0), 0);
        return light;
    }
    light.a = textureLoad(environment_tiles, texel + vec2i(1, 0), 0);
    light.b = textureLoad(environment_tiles, texel + vec2i(2, 0), 0);
    light.c = textureLoad(environment_tiles, texel + vec2i(3, 0), 0);
    light.d = textureLoad(environment_tiles, texel + vec2i(4, 0), 0);
    light.e = textureLoad(environment_tiles, texel + vec2i(5, 0), 0);
    light.f = textureLoad(environment_tiles, texel + vec2i(6, 0), 0);
    light.g = textureLoad(environment_tiles, texel + vec2i(7, 0), 0);
    light.h = textureLoad(environment_tiles, texel + vec2i(8, 0), 0);
    // Of a disc of some spread the horizon leaves a part.
    let spread = max(place.a - 1.0, 1e-3);
    let cosine = dot(direction_from_octahedral(vec2f(light.g.a, light.h.a)), normal);
    let above = max(cosine + spread, 0.0);
    let share = select(cosine, above * above / (4.0 * spread), cosine < spread);
    light.of_source = share * vec3f(light.d.a, light.e.a, light.f.a);
    return light;
}

// Irradiance divided by pi on a surface with a normal, in the units of the grid.
fn probe_irradiance(light: ProbeLight, grid: ProbeGrid, normal: vec3f) -> vec3f {
    let n = normal;
    if has_colors(grid) {
        let squares = n * n;
        return light.a.rgb * squares.x + light.b.rgb * squares.y + light.c.rgb * squares.z;
    }
    let ninth = vec3f(light.a.a, light.b.a, light.c.a);
    let of_harmonics = light.a.rgb + light.b.rgb * n.y + light.c.rgb * n.z + light.d.rgb * n.x
        + light.e.rgb * (n.x * n.y) + light.f.rgb * (n.y * n.z) + light.g.rgb * (3.0 * n.z * n.z - 1.0)
        + light.h.rgb * (n.x * n.z) + ninth * (n.x * n.x - n.y * n.y);
    return max(of_harmonics, vec3f(0.0)) + light.of_source;
}

// The share of a probe's light that comes from before a place, by how far surfaces are from the probe in its direction
// (Donnelly & Lauritzen 2006, "Variance Shadow Maps", of the mean distance and its deviation).
fn seen_share(grid: ProbeGrid, cell: vec2f, away: vec3f, distance_m: f32) -> f32 {
    // As `octahedral_from_direction`, by one division: software adapters feel each.
    let n = away * (1.0 / (abs(away.x) + abs(away.y) + abs(away.z) + 1e-6));
    let place = select(octahedral_wrap(n.xy), n.xy, n.z >= 0.0);
    let side = f32(PROBE_DISTANCE_SIDE);
    let texel = grid.corners.zw + cell * (side + 2.0) + place * (0.5 * side) + (0.5 * side + 1.0);
    let met = textureSampleLevel(environment_tiles, linear_clamp, texel * environment.picture_backdrop.zw, 0.0).rg;
    let beyond_m = max(distance_m - met.x, 0.0);
    let variance = met.y * met.y + 1e-6 * distance_m * distance_m;
    let share = variance / (variance + beyond_m * beyond_m);
    let cubed = share * share * share;
    return cubed * cubed;
}

// How much a probe counts for a surface at a place, but for how near it is; `place` is the first of its texels.
fn probe_weight(grid: ProbeGrid, place: vec4f, at: vec3f, cell: vec2f, position_world: vec3f, normal: vec3f) -> f32 {
    let to_probe = grid.first.xyz + at * grid.spacing.xyz + place.xyz - position_world;
    let away = normal * grid.half_m.w - to_probe;
    let distance_m = sqrt(dot(away, away));
    let before_m = dot(to_probe, normal);
    let facing = before_m * inverseSqrt(dot(to_probe, to_probe) + 1e-12) * 0.5 + 0.5;
    // Those on the other side of the surface's plane see nothing of it, however near they are.
    let side = clamp(before_m * grid.inverse.w + 0.5, 0.0, 1.0);
    let is_before = side * side * (3.0 - 2.0 * side) + OTHER_SIDE;
    var weight = (facing * facing + BEHIND) * is_before * seen_share(grid, cell, away, distance_m);
    weight *= min(weight * weight * (1.0 / (CRUSHED * CRUSHED)), 1.0);
    // What no probe sees has the light of those around it all the same.
    return (weight + 1e-5) * min(place.a, 1.0);
}

// The corner of a cell that a number from 0 to 7 stands for.
fn cell_corner(index: u32) -> vec3f {
    return vec3f(vec3u(index, index >> 1u, index >> 2u) & vec3u(1u));
}

// Irradiance divided by pi of a grid at a place, about a direction; 0 where all probes around are off, else 1.
fn grid_light(grid: ProbeGrid, position_world: vec3f, direction: vec3f, normal: vec3f) -> vec4f {
    let last = grid.counts.xyz - 1.0;
    let place = clamp((position_world - grid.first.xyz) * grid.inverse.xyz, vec3f(0.0), last);
    let before = floor(place);
    let along = place - before;
    var weights: array<f32, 8>;
    var all = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let corner = cell_corner(i);
        let shares = mix(1.0 - along, along, corner);
        let at = min(before + corner, last);
        let cell = probe_cell(grid, at);
        let weight = probe_weight(grid, probe_place(probe_texel(grid, cell)), at, cell, position_world, normal)
            * shares.x * shares.y * shares.z;
        weights[i] = weight;
        all += weight;
    }
    // A bit for each that counts.
    var left = 0u;
    for (var i = 0u; i < 8u; i++) {
        left |= select(0u, 1u << i, weights[i] > LEAST * all);
    }
    var sum = ProbeLight();
    var counted = 0.0;
    for (var i = 0u; i < 8u; i++) {
        if left == 0u {
            break;
        }
        // The lowest bit and its number, for which GLSL ES 3.00 has no function.
        let rest = left & (left - 1u);
        let index = u32(log2(f32(left ^ rest)) + 0.5);
        left = rest;
        let at = min(before + cell_corner(index), last);
        let texel = probe_texel(grid, probe_cell(grid, at));
        // Less by as much as others lack, so that none of them begins to count at once.
        let weight = weights[index] - LEAST * all;
        let light = probe_light_at(grid, texel, probe_place(texel), direction);
        counted += weight;
        sum.a += weight * light.a;
        sum.b += weight * light.b;
        sum.c += weight * light.c;
        if probe_bases != 1u {
            sum.d += weight * light.d;
            sum.e += weight * light.e;
            sum.f += weight * light.f;
            sum.g += weight * light.g;
            sum.h += weight * light.h;
            sum.of_source += weight * light.of_source;
        }
    }
    let is_known = select(0.0, 1.0, counted > 0.0);
    return vec4f(probe_irradiance(sum, grid, direction) * (grid.spacing.w / max(counted, 1e-20)), is_known);
}

// The same of a grid by its share of what earlier ones have left, added to theirs.
fn with_grid(light: vec4f, grid: ProbeGrid, position_world: vec3f, direction: vec3f, normal: vec3f) -> vec4f {
    let inside_m = grid.half_m.xyz - abs(position_world - grid.center.xyz);
    let nearest_m = min(inside_m.x, min(inside_m.y, inside_m.z));
    let share = (1.0 - light.a) * clamp(nearest_m * grid.first.w, 0.0, 1.0);
    if share <= 0.0 {
        return light;
    }
    let found = grid_light(grid, position_world, direction, normal);
    return light + vec4f(found.rgb, 1.0) * (share * found.a);
}

// Irradiance divided by pi of all grids at a place by their shares, about a direction, of a surface with a normal; and the sum
// of the shares. No loop: numbers that are not
// known when a shader is compiled make software adapters read uniforms for every pixel.
fn probe_light(position_world: vec3f, direction: vec3f, normal: vec3f) -> vec4f {
    var light = with_grid(vec4f(0.0), environment.probes[0], position_world, direction, normal);
    if probe_grids > 1u {
        light = with_grid(light, environment.probes[1], position_world, direction, normal);
    }
    if probe_grids > 2u {
        light = with_grid(light, environment.probes[2], position_world, direction, normal);
    }
    if probe_grids > 3u {
        light = with_grid(light, environment.probes[3], position_world, direction, normal);
    }
    return light;
}
