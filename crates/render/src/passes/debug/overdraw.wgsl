// debug.overdraw: one for every fragment; they are added up.
// Writes: the number in red.
// Program: debug_overdraw, also for points. Axes: textured, masked, deformed.

import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, surface_varying};
import package::passes::debug::fragment::is_dropped;

@vertex
fn vs_debug_overdraw(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

@fragment
fn fs_debug_overdraw(in: SurfaceVarying) -> @location(0) vec4f {
    if is_dropped(in) {
        discard;
    }
    return vec4f(1.0, 0.0, 0.0, 1.0);
}
