// probes: every probe as a white sphere in its light, to see where they stand and what they know; those that are off are
// small and red.
// Reads: the texels of probes. Writes: radiance, and depth of the planes through their middles.
// Program: probes.

import package::shaders::environment_uniform::environment;
import package::shaders::probes::{
    light_lookup, probe_cell, probe_grids, probe_irradiance, probe_light_at, probe_place, probe_texel,
};
import package::view::{direction_to_eye_world, position_world_from_pixel, ray_direction_world_from_pixel, view};

// Radii as shares of the least distance between probes.
const RADIUS: f32 = 0.12;
const RADIUS_OFF: f32 = 0.05;
// What is off, in radiance that is not exposed.
const OFF: vec3f = vec3f(0.5, 0.0, 0.0);

struct SphereVarying {
    @builtin(position) position_clip: vec4f,
    // The middle and the radius in metres.
    @location(0) @interpolate(flat, either) sphere: vec4f,
    // Which probe of its grid.
    @location(1) @interpolate(flat, either) at: vec3f,
    @location(2) @interpolate(flat, either) grid: u32,
}

@vertex
fn vs_probes(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> SphereVarying {
    var left = instance;
    var index = 0u;
    for (var i = 0u; i < probe_grids; i++) {
        let counts = vec3u(environment.probes[i].counts.xyz);
        let count = counts.x * counts.y * counts.z;
        if index == i && left >= count && i + 1u < probe_grids {
            left -= count;
            index = i + 1u;
        }
    }
    let grid = environment.probes[index];
    let counts = vec3u(grid.counts.xyz);
    var out: SphereVarying;
    out.grid = index;
    out.at = vec3f(vec3u(left % counts.x, left / counts.x % counts.y, left / (counts.x * counts.y)));
    let place = probe_place(probe_texel(grid, probe_cell(grid, out.at)));
    let middle = grid.first.xyz + out.at * grid.spacing.xyz + place.xyz;
    let least_m = min(grid.spacing.x, min(grid.spacing.y, grid.spacing.z));
    out.sphere = vec4f(middle, least_m * select(RADIUS_OFF, RADIUS, place.a > 0.5));
    // A square across the way to the eye, around what is seen of the sphere from nearby, too.
    let forward = direction_to_eye_world(middle);
    let helper = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(forward.y) > 0.9);
    let right = normalize(cross(helper, forward));
    let up = cross(forward, right);
    let corner = vec2f(vec2u(vertex, vertex >> 1u) & vec2u(1u)) * 2.0 - 1.0;
    let second = vec2f(vec2u(vertex - 2u, (vertex - 2u) >> 1u) & vec2u(1u)) * 2.0 - 1.0;
    let within = select(corner, second, vertex >= 3u) * (1.3 * out.sphere.w);
    out.position_clip = view.clip_from_world * vec4f(middle + right * within.x + up * within.y, 1.0);
    return out;
}

@fragment
fn fs_probes(in: SphereVarying) -> @location(0) vec4f {
    let origin = position_world_from_pixel(in.position_clip.xy, 0.0);
    let ray = ray_direction_world_from_pixel(in.position_clip.xy);
    let to_middle = in.sphere.xyz - origin;
    let along = dot(to_middle, ray);
    let beside = to_middle - along * ray;
    let half_squared = in.sphere.w * in.sphere.w - dot(beside, beside);
    if half_squared < 0.0 {
        discard;
    }
    let normal = normalize(ray * (along - sqrt(half_squared)) - to_middle);
    let grid = environment.probes[in.grid];
    let texel = probe_texel(grid, probe_cell(grid, in.at));
    let place = probe_place(texel);
    let light = probe_irradiance(probe_light_at(texel, light_lookup(normal))) * grid.spacing.w;
    return vec4f(select(OFF * (0.5 + 0.5 * normal.y), light, place.a > 0.5), 1.0);
}
