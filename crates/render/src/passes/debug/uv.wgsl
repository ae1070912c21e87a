// The coordinates of the base colour texture: u in red, v in green, with eight squares to either side.

import package::shaders::surface_vertex::SurfaceVarying;
import package::shaders::surface_material::material_uv;

const SQUARES: f32 = 8.0;
const DARKER: f32 = 0.6;

fn uv_color(in: SurfaceVarying) -> vec3f {
    let uv = material_uv(in.uv, 0u);
    let square = floor(uv * SQUARES);
    let is_odd = fract((square.x + square.y) * 0.5) > 0.25;
    return vec3f(fract(uv), 0.25) * select(1.0, DARKER, is_odd);
}
