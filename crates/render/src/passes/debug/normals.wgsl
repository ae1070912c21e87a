// debug.normals: the world normal that is shaded with; each axis from -1 to 1 is a colour from 0 to 1.
// Writes: colour.
// Program: debug_normals, also for points. Axes: textured, normal_map, masked, deformed.

import package::view::view;
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, surface_varying};
import package::shaders::surface_material::shading_normal;
import package::passes::debug::fragment::is_dropped;

@vertex
fn vs_debug_normals(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

@fragment
fn fs_debug_normals(in: SurfaceVarying, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    let normal_world = shading_normal(in, -view.mip_gain, front_facing);
    if is_dropped(in) {
        discard;
    }
    return vec4f(normal_world * 0.5 + 0.5, 1.0);
}
