// Which probes light a place: a colour for each, mixed as `shaders/probes.wgsl` mixes their light.

import package::shaders::environment_uniform::{ProbeGrid, environment};
import package::shaders::probes::{
    LEAST, OfCorners, around_place, corner_of, grid_share, only_corner, probe_grids, probe_place, probe_texel,
    probe_weight,
};

// What red, green and blue of a probe's colour are. White is brighter, and stands for what no probe lights.
const PROBE_DARK: f32 = 0.2;
const PROBE_BRIGHT: f32 = 0.8;

// Red is bright where the number of a probe along X is odd, green and blue by those along Y and Z: the eight around a
// place differ.
fn probe_color(at: vec3f) -> vec3f {
    return select(vec3f(PROBE_DARK), vec3f(PROBE_BRIGHT), (vec3u(at) & vec3u(1u)) != vec3u(0u));
}

// The mean of a grid's colours at a place of a surface; 0 where all probes around are off, else 1.
fn grid_color(grid: ProbeGrid, position_world: vec3f, normal: vec3f) -> vec4f {
    let around = around_place(grid, position_world);
    var weights = OfCorners(vec4f(0.0), vec4f(0.0));
    var all = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let corner = corner_of(around, i);
        let place = probe_place(probe_texel(grid, corner.cell));
        let weight = probe_weight(grid, place, corner.at, corner.cell, position_world, normal) * corner.share;
        let only = only_corner(i);
        weights.near += weight * only.near;
        weights.far += weight * only.far;
        all += weight;
    }
    var sum = vec4f(0.0);
    for (var i = 0u; i < 8u; i++) {
        let only = only_corner(i);
        let weight = max(dot(weights.near, only.near) + dot(weights.far, only.far) - LEAST * all, 0.0);
        sum += weight * vec4f(probe_color(corner_of(around, i).at), 1.0);
    }
    return vec4f(sum.rgb / max(sum.a, 1e-20), select(0.0, 1.0, sum.a > 0.0));
}

// The colours of all grids by their shares.
fn probe_weights_color(position_world: vec3f, normal: vec3f) -> vec3f {
    var color = vec4f(0.0);
    for (var i = 0u; i < probe_grids; i++) {
        let grid = environment.probes[i];
        let found = grid_color(grid, position_world, normal);
        color += vec4f(found.rgb, 1.0) * ((1.0 - color.a) * grid_share(grid, position_world) * found.a);
    }
    return color.rgb + vec3f(1.0 - color.a);
}
