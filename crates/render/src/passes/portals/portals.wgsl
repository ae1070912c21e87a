// portals: what is seen through a flat place, from the view that looks out of the place that it leads to.
// Source: portals as windows into other cells (Luebke & Georges 1995, "Portals and Mirrors"). That view has the same
// projection: each pixel shows what is there at the same place.
// Reads: radiance of the view. Writes: radiance, and depth of the place.
// Program: portals.

import package::view::view;
import package::shaders::outline_fan::corner_of_vertex;

struct Portal {
    // The outline in world space, one corner after the other; w is 1.
    corners: array<vec4f, 32>,
}

@group(1) @binding(0) var<uniform> portal: Portal;
@group(1) @binding(1) var seen_through: texture_2d<f32>;
@group(1) @binding(2) var linear_clamp: sampler;

@vertex
fn vs_portals(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return view.clip_from_world * portal.corners[corner_of_vertex(vertex)];
}

@fragment
fn fs_portals(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return textureSampleLevel(seen_through, linear_clamp, position.xy * view.inverse_size_px, 0.0);
}
