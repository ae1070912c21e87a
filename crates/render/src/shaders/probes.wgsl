// Light that arrives at places, for the surfaces between them: spherical harmonics of order 2 (Ramamoorthi & Hanrahan
// 2001) or six colours (McTaggart 2004), of the eight probes around a place by how near they are and by what they see of it
// (Majercik et al. 2019, "Dynamic Diffuse Global Illumination with Ray-Traced Irradiance Fields").

import package::constants::{PROBE_DISTANCE_SIDE, PROBE_HEIGHT, PROBE_WIDTH};
import package::shaders::environment_uniform::{ProbeGrid, environment, environment_tiles};
import package::shaders::octahedral::octahedral_wrap;
import package::shaders::shading::linear_clamp;

// How many grids there are.
override probe_grids: u32 = 0u;
// 1 if the light of some of them has small sources apart.
override probe_sources: u32 = 0u;
// 1 where textures are filtered as exactly as numbers are multiplied, as software adapters do. Others go by 1/256 of a texel.
override filters_exactly: u32 = 0u;

// Probes that lie behind a surface count so much, and those that see it hardly are crushed below the second. Those with less
// than `LEAST` of the sum of all do not count at all, so that their light need not be read.
const BEHIND: f32 = 0.05;
const CRUSHED: f32 = 0.2;
const LEAST: f32 = 0.02;
// What a probe counts that is on the other side of a surface's plane.
const OTHER_SIDE: f32 = 0.002;
// What a probe counts that sees nothing of a place.
const UNSEEN: f32 = 1e-5;
// The largest that `probe_weight` is, for a probe straight ahead, and the largest for one behind the surface's plane.
const WEIGHT_MOST: f32 = (1.0 + BEHIND) * (1.0 + OTHER_SIDE) + UNSEEN;
const BEHIND_MOST: f32 = (1.0 + BEHIND) * OTHER_SIDE;
const WEIGHT_MOST_BEHIND: f32 = BEHIND_MOST * min(BEHIND_MOST * BEHIND_MOST / (CRUSHED * CRUSHED), 1.0) + UNSEEN;
// What all around a place count together, mostly.
const ALL_MOSTLY: f32 = 0.3;

// The column and row of a probe among those of its grid in the texture, where some layers along Z lie beside each other.
fn probe_cell(grid: ProbeGrid, at: vec3f) -> vec2f {
    let row = floor((at.z + 0.5) / grid.counts.w);
    let column = at.z - row * grid.counts.w;
    return vec2f(at.x + column * grid.counts.x, at.y + row * grid.counts.y);
}

// Of a probe the first of the texels of its light.
fn probe_texel(grid: ProbeGrid, cell: vec2f) -> vec2f {
    return grid.corners.xy + cell * vec2f(f32(PROBE_WIDTH), f32(PROBE_HEIGHT));
}

// How far a probe was moved, and 0 if it is off, else 1.
fn probe_place(texel: vec2f) -> vec4f {
    return textureLoad(environment_tiles, vec2i(texel) + vec2i(0, i32(PROBE_HEIGHT) - 1), 0);
}

// Irradiance of a normal n is the square form v Q v of v = (|x|, |y|, |z|, 1), where Q is symmetric and, by the signs of n, one
// of eight (Ramamoorthi & Hanrahan 2001, section 3.2, with the signs in Q in place of n). Of two pairs of numbers of v, (a, b)
// and (c, d), what bilinear filtering finds between the 2 x 2 texels of a block of Q, at b / (a + b) and d / (c + d), is their
// share of that divided by (a + b) (c + d): three lookups find all sixteen products.
struct LightLookup {
    // The first texels of the blocks of |x|, |y| by themselves, of |z|, 1 by themselves, and of both, from that of a probe on.
    of_sides: vec2f,
    of_height: vec2f,
    of_both: vec2f,
    // How far from the first to the second number of each pair.
    between: vec2f,
    // What the three are multiplied by.
    shares: vec3f,
    direction: vec3f,
}

// The first texel of a block.
fn light_block(index: f32) -> vec2f {
    let beside = f32(PROBE_WIDTH / 2u);
    let row = floor((index + 0.5) / beside);
    return vec2f(2.0 * (index - beside * row), 2.0 * row);
}

fn light_lookup(direction: vec3f) -> LightLookup {
    let v = abs(direction);
    let below = select(vec3f(0.0), vec3f(1.0), direction < vec3f(0.0));
    let quarter = below.x + 2.0 * below.y;
    let sums = vec2f(v.x + v.y, v.z + 1.0);
    var lookup: LightLookup;
    lookup.of_sides = light_block(quarter);
    lookup.of_height = light_block(4.0 + below.z);
    lookup.of_both = light_block(6.0 + quarter + 4.0 * below.z);
    lookup.between = vec2f(v.y / max(sums.x, 1e-6), 1.0 / sums.y);
    lookup.shares = vec3f(sums.x * sums.x, sums.y * sums.y, 2.0 * sums.x * sums.y);
    lookup.direction = direction;
    return lookup;
}

// What lies between the texels of a block.
fn within_block(first: vec2f, between: vec2f) -> vec4f {
    if filters_exactly != 0u {
        let place = first + between + 0.5;
        return textureSampleLevel(environment_tiles, linear_clamp, place * environment.picture_backdrop.zw, 0.0);
    }
    let texel = vec2i(first);
    let upper = mix(textureLoad(environment_tiles, texel, 0), textureLoad(environment_tiles, texel + vec2i(1, 0), 0), between.x);
    let lower = mix(
        textureLoad(environment_tiles, texel + vec2i(0, 1), 0),
        textureLoad(environment_tiles, texel + vec2i(1, 1), 0),
        between.x,
    );
    return mix(upper, lower, between.y);
}

// Light of a probe on a normal, or of several added up: irradiance divided by pi, as polynomials have it and as a small source.
struct ProbeLight {
    of_polynomial: vec3f,
    of_source: vec3f,
}

fn probe_light_at(texel: vec2f, lookup: LightLookup) -> ProbeLight {
    let of_sides = within_block(texel + lookup.of_sides, lookup.between.xx);
    let of_height = within_block(texel + lookup.of_height, lookup.between.yy);
    let of_both = within_block(texel + lookup.of_both, lookup.between.yx);
    let shares = lookup.shares;
    var light: ProbeLight;
    light.of_polynomial = of_sides.rgb * shares.x + of_height.rgb * shares.y + of_both.rgb * shares.z;
    if probe_sources != 0u {
        // Of a disc of some spread the horizon leaves a part.
        let source = textureLoad(environment_tiles, vec2i(texel) + vec2i(1, i32(PROBE_HEIGHT) - 1), 0);
        let cosine = dot(source.xyz, lookup.direction);
        let spread = max(source.a, 1e-3);
        let above = max(cosine + spread, 0.0);
        let share = select(cosine, above * above / (4.0 * spread), cosine < spread);
        light.of_source = share * vec3f(of_sides.a, of_height.a, of_both.a);
    }
    return light;
}

// Irradiance divided by pi, in the units of the grid.
fn probe_irradiance(light: ProbeLight) -> vec3f {
    return max(light.of_polynomial, vec3f(0.0)) + light.of_source;
}

// The share of a probe's light that comes from before a place, by how far surfaces are from the probe in its direction
// (Donnelly & Lauritzen 2006, "Variance Shadow Maps", of the mean distance and its deviation); the direction has length 1 by
// the sum of its absolute values.
fn seen_share(grid: ProbeGrid, cell: vec2f, n: vec3f, distance_m: f32) -> f32 {
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

// How much a probe counts for a surface at a place, but for how near it is; `place` is what `probe_place` says.
fn probe_weight(grid: ProbeGrid, place: vec4f, at: vec3f, cell: vec2f, position_world: vec3f, normal: vec3f) -> f32 {
    let to_probe = grid.first.xyz + at * grid.spacing.xyz + place.xyz - position_world;
    let away = normal * grid.half_m.w - to_probe;
    let distance_m = sqrt(dot(away, away));
    // One divided by how far the probe is, and by the sum of absolute values, by one division: software adapters feel each.
    let probe_m = sqrt(dot(to_probe, to_probe) + 1e-12);
    let sum_m = dot(abs(away), vec3f(1.0)) + 1e-6;
    let per_both = 1.0 / (probe_m * sum_m);
    let before_m = dot(to_probe, normal);
    let facing = before_m * (per_both * sum_m) * 0.5 + 0.5;
    // Those on the other side of the surface's plane see nothing of it, however near they are.
    let side = clamp(before_m * grid.inverse.w + 0.5, 0.0, 1.0);
    let is_before = side * side * (3.0 - 2.0 * side) + OTHER_SIDE;
    let seen = seen_share(grid, cell, away * (per_both * probe_m), distance_m);
    var weight = (facing * facing + BEHIND) * is_before * seen;
    weight *= min(weight * weight * (1.0 / (CRUSHED * CRUSHED)), 1.0);
    // What no probe sees has the light of those around it all the same.
    return (weight + UNSEEN) * place.a;
}

// The number of the lowest bit that is set, for which GLSL ES 3.00 has no function: the exponent of its number.
fn lowest_bit(bits: u32) -> u32 {
    return (bitcast<u32>(f32(bits & (~bits + 1u))) >> 23u) - 127u;
}

// The eight probes around a place, which a number from 0 to 7 stands for by a bit for each axis.
struct Around {
    // The first of them, and how far the place is from it to the last.
    first: vec3f,
    along: vec3f,
    last: vec3f,
    // In the texture, what the layers of the first and of the last one along Z add to their columns and rows.
    near: vec2f,
    far: vec2f,
}

fn around_place(grid: ProbeGrid, position_world: vec3f) -> Around {
    let last = grid.counts.xyz - 1.0;
    let place = clamp((position_world - grid.first.xyz) * grid.inverse.xyz, vec3f(0.0), last);
    let first = floor(place);
    let near = probe_cell(grid, vec3f(0.0, 0.0, first.z));
    let far = probe_cell(grid, vec3f(0.0, 0.0, min(first.z + 1.0, last.z)));
    return Around(first, place - first, min(first + 1.0, last), near, far);
}

// Of one of them where it is among all, and its column and row in the texture.
struct Corner {
    at: vec3f,
    cell: vec2f,
    // By how near it is.
    share: f32,
}

fn corner_of(around: Around, index: u32) -> Corner {
    let is_last = (vec3u(index) & vec3u(1u, 2u, 4u)) != vec3u(0u);
    let at = select(around.first, around.last, is_last);
    let shares = select(1.0 - around.along, around.along, is_last);
    let layer = select(around.near, around.far, is_last.z);
    return Corner(at, at.xy + layer, shares.x * shares.y * shares.z);
}

// A number for each of the eight: of those of the first layer along Z, and of the last.
struct OfCorners {
    near: vec4f,
    far: vec4f,
}

// The bits of those above a number.
fn bits_above(numbers: OfCorners, least: f32) -> u32 {
    let near = select(vec4f(0.0), vec4f(1.0, 2.0, 4.0, 8.0), numbers.near > vec4f(least));
    let far = select(vec4f(0.0), vec4f(16.0, 32.0, 64.0, 128.0), numbers.far > vec4f(least));
    return u32(dot(near + far, vec4f(1.0)));
}

// One for the one of an index, and zero for the others.
fn only_corner(index: u32) -> OfCorners {
    let order = vec4u(0u, 1u, 2u, 3u);
    return OfCorners(vec4f(vec4u(index) == order), vec4f(vec4u(index) == order + 4u));
}

// What each counts at the most: by how near it is, and by whether all places to which it may have been moved are behind the
// surface's plane.
fn most_weights(grid: ProbeGrid, around: Around, position_world: vec3f, normal: vec3f) -> OfCorners {
    let to_first = grid.first.xyz + around.first * grid.spacing.xyz - position_world;
    let from_first = (around.last - around.first) * grid.spacing.xyz * normal;
    let moved_m = dot(grid.moved_m.xyz, abs(normal)) + grid.moved_m.w;
    let first_m = dot(to_first, normal) + moved_m;
    let near_m = vec4f(0.0, from_first.x, from_first.y, from_first.x + from_first.y) + first_m;
    let near_most = select(vec4f(WEIGHT_MOST_BEHIND), vec4f(WEIGHT_MOST), near_m > vec4f(0.0));
    let far_most = select(vec4f(WEIGHT_MOST_BEHIND), vec4f(WEIGHT_MOST), near_m + from_first.z > vec4f(0.0));
    let shares = around.along;
    let others = 1.0 - shares;
    let of_layer = vec4f(others.x, shares.x, others.x, shares.x) * vec4f(others.yy, shares.yy);
    return OfCorners(of_layer * others.z * near_most, of_layer * shares.z * far_most);
}

// Irradiance divided by pi of a grid at a place, about a direction; 0 where all probes around are off, else 1.
fn grid_light(grid: ProbeGrid, position_world: vec3f, lookup: LightLookup, normal: vec3f) -> vec4f {
    let around = around_place(grid, position_world);
    // Bits, and not branches, because software adapters take all of these. First those that may count where all together count
    // as they mostly do, and then those of the others that may count all the same, which are few. Both in one loop, so that
    // pixels do not wait for each other in between.
    let most = most_weights(grid, around, position_world, normal);
    var left = bits_above(most, LEAST * ALL_MOSTLY);
    var later = ~left;
    var weights = OfCorners(vec4f(0.0), vec4f(0.0));
    var all = 0.0;
    for (var i = 0u; i < 8u; i++) {
        if left == 0u {
            left = bits_above(most, LEAST * all) & later;
            later = 0u;
        }
        if left == 0u {
            break;
        }
        let index = lowest_bit(left);
        left &= left - 1u;
        let corner = corner_of(around, index);
        let place = probe_place(probe_texel(grid, corner.cell));
        let weight = probe_weight(grid, place, corner.at, corner.cell, position_world, normal) * corner.share;
        let only = only_corner(index);
        weights.near += weight * only.near;
        weights.far += weight * only.far;
        all += weight;
    }
    // A bit for each that counts.
    left = bits_above(weights, LEAST * all);
    var sum = ProbeLight();
    var counted = 0.0;
    for (var i = 0u; i < 8u; i++) {
        if left == 0u {
            break;
        }
        let index = lowest_bit(left);
        left &= left - 1u;
        let only = only_corner(index);
        // Less by as much as others lack, so that none of them begins to count at once.
        let weight = dot(weights.near, only.near) + dot(weights.far, only.far) - LEAST * all;
        let light = probe_light_at(probe_texel(grid, corner_of(around, index).cell), lookup);
        counted += weight;
        sum.of_polynomial += weight * light.of_polynomial;
        sum.of_source += weight * light.of_source;
    }
    let is_known = select(0.0, 1.0, counted > 0.0);
    return vec4f(probe_irradiance(sum) * (grid.spacing.w / max(counted, 1e-20)), is_known);
}

// How much a grid counts at a place: 0 outside of its box, and 1 from where that does not fade.
fn grid_share(grid: ProbeGrid, position_world: vec3f) -> f32 {
    let inside_m = grid.half_m.xyz - abs(position_world - grid.center.xyz);
    let nearest_m = min(inside_m.x, min(inside_m.y, inside_m.z));
    return clamp(nearest_m * grid.first.w, 0.0, 1.0);
}

// The same of a grid by its share of what earlier ones have left, added to theirs.
fn with_grid(light: vec4f, grid: ProbeGrid, position_world: vec3f, lookup: LightLookup, normal: vec3f) -> vec4f {
    let share = (1.0 - light.a) * grid_share(grid, position_world);
    if share <= 0.0 {
        return light;
    }
    let found = grid_light(grid, position_world, lookup, normal);
    return light + vec4f(found.rgb, 1.0) * (share * found.a);
}

// Irradiance divided by pi of all grids at a place by their shares, about a direction, of a surface with a normal; and the sum
// of the shares. No loop: numbers that are not
// known when a shader is compiled make software adapters read uniforms for every pixel.
fn probe_light(position_world: vec3f, direction: vec3f, normal: vec3f) -> vec4f {
    let lookup = light_lookup(direction);
    var light = with_grid(vec4f(0.0), environment.probes[0], position_world, lookup, normal);
    if probe_grids > 1u {
        light = with_grid(light, environment.probes[1], position_world, lookup, normal);
    }
    if probe_grids > 2u {
        light = with_grid(light, environment.probes[2], position_world, lookup, normal);
    }
    if probe_grids > 3u {
        light = with_grid(light, environment.probes[3], position_world, lookup, normal);
    }
    return light;
}
