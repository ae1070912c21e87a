// How many texels of the base colour texture lie along a side of a pixel, the longer one; 0 where there is no texture.

import package::shaders::surface_vertex::SurfaceVarying;
import package::shaders::surface_material::{base_color_texture, material_uv, textured};

// What is less than this is no texture.
const DENSITY_MIN: f32 = 0.001;

fn texels_per_pixel(in: SurfaceVarying) -> f32 {
    if textured == 0u {
        return 0.0;
    }
    let size = vec2f(textureDimensions(base_color_texture));
    let texel = material_uv(in.uv, 0u) * size;
    let density = max(max(length(dpdx(texel)), length(dpdy(texel))), DENSITY_MIN);
    // A single texel stands for no texture.
    return select(density, 0.0, max(size.x, size.y) < 1.5);
}
