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

// Light of a probe, or of several added up: coefficients, of which the ninth lies in the last places of the fifth to the
// seventh; or the colours of the three faces that a normal sees. And what a small source gives by its cosine.
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

struct Probe {
    light: ProbeLight,
    // How far it was moved, and 1 if it has light.
    offset_m: vec3f,
    is_on: f32,
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

fn probe_at(grid: ProbeGrid, cell: vec2f, normal: vec3f) -> Probe {
    let texel = vec2i(grid.corners.xy + cell * vec2f(f32(PROBE_TEXELS), 1.0));
    var probe = Probe();
    if has_colors(grid) {
        let faces = vec3i(vec3u(normal < vec3f(0.0))) + vec3i(0, 2, 4);
        probe.light.a = textureLoad(environment_tiles, texel + vec2i(faces.x, 0), 0);
        probe.light.b = textureLoad(environment_tiles, texel + vec2i(faces.y, 0), 0);
        probe.light.c = textureLoad(environment_tiles, texel + vec2i(faces.z, 0), 0);
        probe.is_on = select(1.0, 0.0, probe.light.a.a > OFF_M);
        probe.offset_m = vec3f(probe.light.a.a, probe.light.b.a, probe.light.c.a) * probe.is_on;
        return probe;
    }
    probe.light.a = textureLoad(environment_tiles, texel, 0);
    probe.light.b = textureLoad(environment_tiles, texel + vec2i(1, 0), 0);
    probe.light.c = textureLoad(environment_tiles, texel + vec2i(2, 0), 0);
    probe.light.d = textureLoad(environment_tiles, texel + vec2i(3, 0), 0);
    probe.light.e = textureLoad(environment_tiles, texel + vec2i(4, 0), 0);
    probe.light.f = textureLoad(environment_tiles, texel + vec2i(5, 0), 0);
    probe.light.g = textureLoad(environment_tiles, texel + vec2i(6, 0), 0);
    probe.light.h = textureLoad(environment_tiles, texel + vec2i(7, 0), 0);
    let source = textureLoad(environment_tiles, texel + vec2i(8, 0), 0);
    // Of a disc of some spread the horizon leaves a part.
    let spread = max(probe.light.a.a - 1.0, 1e-3);
    let cosine = dot(direction_from_octahedral(vec2f(probe.light.h.a, source.a)), normal);
    let above = max(cosine + spread, 0.0);
    let share = select(cosine, above * above / (4.0 * spread), cosine < spread);
    probe.light.of_source = share * source.rgb;
    probe.is_on = min(probe.light.a.a, 1.0);
    probe.offset_m = vec3f(probe.light.b.a, probe.light.c.a, probe.light.d.a);
    return probe;
}

// Irradiance divided by pi on a surface with a normal, in the units of the grid.
fn probe_irradiance(light: ProbeLight, grid: ProbeGrid, normal: vec3f) -> vec3f {
    let n = normal;
    if has_colors(grid) {
        let squares = n * n;
        return light.a.rgb * squares.x + light.b.rgb * squares.y + light.c.rgb * squares.z;
    }
    let ninth = vec3f(light.e.a, light.f.a, light.g.a);
    let of_harmonics = light.a.rgb + light.b.rgb * n.y + light.c.rgb * n.z + light.d.rgb * n.x
        + light.e.rgb * (n.x * n.y) + light.f.rgb * (n.y * n.z) + light.g.rgb * (3.0 * n.z * n.z - 1.0)
        + light.h.rgb * (n.x * n.z) + ninth * (n.x * n.x - n.y * n.y);
    return max(of_harmonics, vec3f(0.0)) + light.of_source;
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

// How much a probe counts for a surface at a place, but for how near it is.
fn probe_weight(grid: ProbeGrid, probe: Probe, at: vec3f, cell: vec2f, position_world: vec3f, normal: vec3f) -> f32 {
    let probe_world = grid.first.xyz + at * grid.spacing.xyz + probe.offset_m;
    let to_probe = normalize(probe_world - position_world + vec3f(1e-6, 0.0, 0.0));
    let away = position_world + normal * grid.half_m.w - probe_world;
    let distance_m = length(away);
    let facing = dot(to_probe, normal) * 0.5 + 0.5;
    var weight = facing * facing + BEHIND;
    weight *= seen_share(grid, cell, away / max(distance_m, 1e-6), distance_m);
    weight *= select(1.0, weight * weight / (CRUSHED * CRUSHED), weight < CRUSHED);
    // What no probe sees has the light of those around it all the same.
    return (weight + 1e-5) * probe.is_on;
}

// Irradiance divided by pi of a grid at a place; 0 where all probes around are off, else 1.
fn grid_light(grid: ProbeGrid, position_world: vec3f, normal: vec3f) -> vec4f {
    let last = grid.counts.xyz - 1.0;
    let place = clamp((position_world - grid.first.xyz) / grid.spacing.xyz, vec3f(0.0), last);
    let before = floor(place);
    let along = place - before;
    var sum = ProbeLight();
    var weights = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let corner = vec3f(vec3u(i, i >> 1u, i >> 2u) & vec3u(1u));
        let shares = mix(1.0 - along, along, corner);
        let at = min(before + corner, last);
        let cell = probe_cell(grid, at);
        let probe = probe_at(grid, cell, normal);
        let weight = probe_weight(grid, probe, at, cell, position_world, normal) * shares.x * shares.y * shares.z;
        weights += weight;
        sum.a += weight * probe.light.a;
        sum.b += weight * probe.light.b;
        sum.c += weight * probe.light.c;
        if probe_bases != 1u {
            sum.d += weight * probe.light.d;
            sum.e += weight * probe.light.e;
            sum.f += weight * probe.light.f;
            sum.g += weight * probe.light.g;
            sum.h += weight * probe.light.h;
            sum.of_source += weight * probe.light.of_source;
        }
    }
    let is_known = select(0.0, 1.0, weights > 0.0);
    return vec4f(probe_irradiance(sum, grid, normal) * (grid.spacing.w / max(weights, 1e-20)), is_known);
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
