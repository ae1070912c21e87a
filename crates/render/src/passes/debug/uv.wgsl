// debug.uv: the coordinates of the base colour texture: u in red, v in green, with eight squares to either side.
// Writes: colour.
// Program: debug_uv, also for points. Axes: textured, masked, deformed.

import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, surface_varying};
import package::shaders::surface_material::material_uv;
import package::passes::debug::fragment::is_dropped;

const SQUARES: f32 = 8.0;
const DARKER: f32 = 0.6;

@vertex
fn vs_debug_uv(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

@fragment
fn fs_debug_uv(in: SurfaceVarying) -> @location(0) vec4f {
    if is_dropped(in) {
        discard;
    }
    let uv = material_uv(in.uv, 0u);
    let square = floor(uv * SQUARES);
    let is_odd = fract((square.x + square.y) * 0.5) > 0.25;
    return vec4f(vec3f(fract(uv), 0.25) * select(1.0, DARKER, is_odd), 1.0);
}
