// Light that arrives at places, for the surfaces between them: spherical harmonics of order 2 (Ramamoorthi & Hanrahan
// 2001) or six colours (McTaggart 2004), of the eight probes around a place by how near they are and by what they see of it
// (Majercik et al. 2019, "Dynamic Diffuse Global Illumination with Ray-Traced Irradiance Fields").

import package::constants::{PROBE_DISTANCE_SIDE, PROBE_TEXELS};
import package::shaders::environment::{environment, environment_tiles};
import package::shaders::octahedral::{direction_from_octahedral, octahedral_from_direction};
import package::shaders::shading::linear_clamp;

// A grid of probes.
struct ProbeGrid {
    // The place of the first probe; one divided by how many metres the box fades over.
    first: vec4f,
    // How far probes are apart; what their light is multiplied by.
    spacing: vec4f,
    // How many there are along each axis; layers along Z that lie beside each other in the texture.
    counts: vec4f,
    // The corners of the light and of the distances in texels.
    corners: vec4f,
    // The middle of the box; 1 if light is six colours.
    center: vec4f,
    // Half the box's extent; how far from a surface its light is looked up, in metres.
    half_m: vec4f,
}

// How many grids there are.
override probe_grids: u32 = 0u;
// Their light is spherical harmonics; 1 if it is six colours; 2 if there are both.
override probe_bases: u32 = 0u;

// What is off is farther away than this from its place.
const OFF_M: f32 = 30000.0;
// Probes that lie behind a surface count so much, and those that see it hardly are crushed below the other.
const BEHIND: f32 = 0.05;
const CRUSHED: f32 = 0.2;

// What is added up of probes: coefficients with what is left of them in the last places, or the colours of three faces.
struct ProbeSum {
    a: vec4f,
    b: vec4f,
    c: vec4f,
    d: vec4f,
    e: vec4f,
    f: vec4f,
    g: vec4f,
    h: vec4f,
    // Of small sources, by their cosines.
    of_sources: vec3f,
    weight: f32,
}

// The share of a probe's light that comes from before a place, by how far surfaces are from the probe in its direction
// (Donnelly & Lauritzen 2006, "Variance Shadow Maps", of the mean distance and its deviation).
fn seen_share(grid: ProbeGrid, cell: vec2f, from_probe: vec3f, distance_m: f32) -> f32 {
    let side = f32(PROBE_DISTANCE_SIDE);
    let place = (octahedral_from_direction(from_probe) * 0.5 + 0.5) * side + 1.0;
    let texel = grid.corners.zw + cell * (side + 2.0) + place;
    let met = textureSampleLevel(environment_tiles, linear_clamp, texel * environment.picture_backdrop.zw, 0.0).rg;
    let beyond_m = max(distance_m - met.x, 0.0);
    let variance = met.y * met.y + 1e-6 * distance_m * distance_m;
    let share = variance / (variance + beyond_m * beyond_m);
    return share * share * share;
}

fn add_probe(sum: ptr<function, ProbeSum>, grid: ProbeGrid, at: vec3f, nearness: f32, position_world: vec3f, normal: vec3f) {
    // Of a layer along Z its row and column.
    let row = floor((at.z + 0.5) / grid.counts.w);
    let column = at.z - row * grid.counts.w;
    let cell = vec2f(at.x + column * grid.counts.x, at.y + row * grid.counts.y);
    let texel = vec2i(grid.corners.xy + cell * vec2f(f32(PROBE_TEXELS), 1.0));
    let is_cube = probe_bases == 1u || (probe_bases == 2u && grid.center.w > 0.5);
    var a: vec4f;
    var b: vec4f;
    var c: vec4f;
    var d = vec4f(0.0);
    var offset_m: vec3f;
    var is_on: f32;
    if is_cube {
        let faces = vec3i(vec3u(normal < vec3f(0.0))) + vec3i(0, 2, 4);
        a = textureLoad(environment_tiles, texel + vec2i(faces.x, 0), 0);
        b = textureLoad(environment_tiles, texel + vec2i(faces.y, 0), 0);
        c = textureLoad(environment_tiles, texel + vec2i(faces.z, 0), 0);
        offset_m = vec3f(a.a, b.a, c.a);
        is_on = select(1.0, 0.0, a.a > OFF_M);
        offset_m = select(vec3f(0.0), offset_m, is_on > 0.0);
    } else {
        a = textureLoad(environment_tiles, texel, 0);
        b = textureLoad(environment_tiles, texel + vec2i(1, 0), 0);
        c = textureLoad(environment_tiles, texel + vec2i(2, 0), 0);
        d = textureLoad(environment_tiles, texel + vec2i(3, 0), 0);
        offset_m = vec3f(b.a, c.a, d.a);
        is_on = min(a.a, 1.0);
    }
    let probe_world = grid.first.xyz + at * grid.spacing.xyz + offset_m;
    let seen_world = position_world + normal * grid.half_m.w;
    let to_probe = normalize(probe_world - position_world + vec3f(1e-6, 0.0, 0.0));
    let away = seen_world - probe_world;
    let distance_m = length(away);
    let facing = dot(to_probe, normal) * 0.5 + 0.5;
    var weight = (facing * facing + BEHIND) * is_on;
    weight *= seen_share(grid, cell, away / max(distance_m, 1e-6), distance_m);
    weight *= select(1.0, weight * weight / (CRUSHED * CRUSHED), weight < CRUSHED);
    // What no probe sees has the light of those around it all the same.
    weight = (weight + 1e-5 * is_on) * nearness;
    (*sum).weight += weight;
    (*sum).a += weight * a;
    (*sum).b += weight * b;
    (*sum).c += weight * c;
    if !is_cube {
        (*sum).d += weight * d;
        (*sum).e += weight * textureLoad(environment_tiles, texel + vec2i(4, 0), 0);
        (*sum).f += weight * textureLoad(environment_tiles, texel + vec2i(5, 0), 0);
        (*sum).g += weight * textureLoad(environment_tiles, texel + vec2i(6, 0), 0);
        let h = textureLoad(environment_tiles, texel + vec2i(7, 0), 0);
        (*sum).h += weight * h;
        let source = textureLoad(environment_tiles, texel + vec2i(8, 0), 0);
        // Of a disc of some spread the horizon leaves a part.
        let spread = max(a.a - 1.0, 1e-3);
        let cosine = dot(direction_from_octahedral(vec2f(h.a, source.a)), normal);
        let above = max(cosine + spread, 0.0);
        let share = select(cosine, above * above / (4.0 * spread), cosine < spread);
        (*sum).of_sources += (weight * share) * source.rgb;
    }
}

// Irradiance divided by pi of a grid at a place; how much of it is known, 0 or 1.
fn grid_light(grid: ProbeGrid, position_world: vec3f, normal: vec3f) -> vec4f {
    let last = grid.counts.xyz - 1.0;
    let place = clamp((position_world - grid.first.xyz) / grid.spacing.xyz, vec3f(0.0), last);
    let before = floor(place);
    let along = place - before;
    var sum = ProbeSum();
    for (var i = 0u; i < 8u; i++) {
        let corner = vec3f(vec3u(i, i >> 1u, i >> 2u) & vec3u(1u));
        let shares = mix(1.0 - along, along, corner);
        let nearness = shares.x * shares.y * shares.z;
        add_probe(&sum, grid, min(before + corner, last), nearness, position_world, normal);
    }
    let n = normal;
    var light: vec3f;
    if probe_bases == 1u || (probe_bases == 2u && grid.center.w > 0.5) {
        let squares = n * n;
        light = sum.a.rgb * squares.x + sum.b.rgb * squares.y + sum.c.rgb * squares.z;
    } else {
        let last_color = vec3f(sum.e.a, sum.f.a, sum.g.a);
        light = sum.a.rgb + sum.b.rgb * n.y + sum.c.rgb * n.z + sum.d.rgb * n.x + sum.e.rgb * (n.x * n.y)
            + sum.f.rgb * (n.y * n.z) + sum.g.rgb * (3.0 * n.z * n.z - 1.0) + sum.h.rgb * (n.x * n.z)
            + last_color * (n.x * n.x - n.y * n.y);
    }
    light = max(light, vec3f(0.0)) + sum.of_sources;
    let is_known = select(0.0, 1.0, sum.weight > 0.0);
    return vec4f(light * (grid.spacing.w / max(sum.weight, 1e-20)), is_known);
}

// Irradiance divided by pi of all grids at a place by their shares, and the sum of the shares.
fn probe_light(position_world: vec3f, normal: vec3f) -> vec4f {
    var light = vec4f(0.0);
    for (var i = 0u; i < probe_grids; i++) {
        let grid = environment.probes[i];
        let inside_m = grid.half_m.xyz - abs(position_world - grid.center.xyz);
        let nearest_m = min(inside_m.x, min(inside_m.y, inside_m.z));
        let share = (1.0 - light.a) * clamp(nearest_m * grid.first.w, 0.0, 1.0);
        if share > 0.0 {
            let found = grid_light(grid, position_world, normal);
            light += vec4f(found.rgb, 1.0) * (share * found.a);
        }
    }
    return light;
}
