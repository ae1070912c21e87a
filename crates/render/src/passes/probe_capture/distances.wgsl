// probe_capture.distances: how far what is around a probe is, as the map of `probes.wgsl`.
// Reads: probe_sides (the six sides beside each other). Writes: the mean of distances and its standard deviation.
// Program: probe_distances.

import package::constants::PROBE_DISTANCE_SIDE;
import package::shaders::cube_sides::{CubeSides, texel_of_direction};
import package::shaders::octahedral::{direction_from_octahedral, direction_from_octahedral_border};

struct ProbeDistances {
    // The first texel of its map, which is one of the border; the largest distance that counts.
    corner: vec4f,
    sides: CubeSides,
}

@group(1) @binding(0) var probe_sides: texture_2d<f32>;
@group(1) @binding(1) var<uniform> probe_distances: ProbeDistances;

// The power of the cosine by which directions count around the middle of a texel.
const POWER: f32 = 128.0;

// So many places across a texel, up to so far from its middle, in texels.
const ACROSS: u32 = 5u;
const PLACES: u32 = 25u;
const REACH: f32 = 0.8;

// The texel that one of the border repeats, or itself.
fn texel_within(texel: vec2f) -> vec2f {
    let last = f32(PROBE_DISTANCE_SIDE) - 1.0;
    let inside = clamp(texel, vec2f(0.0), vec2f(last));
    let of_x = select(texel, vec2f(inside.x, last - texel.y), texel.x != inside.x);
    return select(of_x, vec2f(last - of_x.x, inside.y), texel.y != inside.y);
}

@fragment
fn fs_probe_distances(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = texel_within(floor(position.xy - probe_distances.corner.xy) - 1.0);
    let per_texel = 2.0 / f32(PROBE_DISTANCE_SIDE);
    let middle = (texel + 0.5) * per_texel - 1.0;
    let axis = direction_from_octahedral(middle);
    let farthest_m = probe_distances.corner.z;
    var sum = vec2f(0.0);
    var weights = 0.0;
    for (var i = 0u; i < PLACES; i++) {
        let step = (vec2f(vec2u(i % ACROSS, i / ACROSS)) * (2.0 / f32(ACROSS - 1u)) - 1.0) * REACH;
        let direction = direction_from_octahedral_border(middle + step * per_texel);
        let seen_m = textureLoad(probe_sides, vec2i(texel_of_direction(probe_distances.sides, direction)), 0).a;
        let distance_m = select(seen_m, farthest_m, seen_m < 0.0);
        let weight = pow(max(dot(direction, axis), 0.0), POWER);
        sum += weight * vec2f(distance_m, distance_m * distance_m);
        weights += weight;
    }
    let mean = sum / max(weights, 1e-6);
    return vec4f(mean.x, sqrt(max(mean.y - mean.x * mean.x, 0.0)), 0.0, 0.0);
}
