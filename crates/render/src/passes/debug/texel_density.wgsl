// debug.texel_density: how many texels of the base colour texture lie along a side of a pixel, the longer one.
// Writes: the number in red; 0 where there is no texture.
// Program: debug_texel_density, also for points. Axes: textured, masked, deformed.

import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, surface_varying};
import package::shaders::surface_material::material_uv;
@if(textured) import package::shaders::surface_material::base_color_texture;
import package::passes::debug::fragment::is_dropped;

// What is less than this is no texture.
const DENSITY_MIN: f32 = 0.001;

@vertex
fn vs_debug_texel_density(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

fn texels_per_pixel(in: SurfaceVarying) -> f32 {
    @if(textured) {
        let size = vec2f(textureDimensions(base_color_texture));
        let texel = material_uv(in.uv, 0u) * size;
        let density = max(max(length(dpdx(texel)), length(dpdy(texel))), DENSITY_MIN);
        // A single texel stands for no texture.
        return select(density, 0.0, max(size.x, size.y) < 1.5);
    }
    @if(!textured) {
        return 0.0;
    }
}

@fragment
fn fs_debug_texel_density(in: SurfaceVarying) -> @location(0) vec4f {
    let density = texels_per_pixel(in);
    if is_dropped(in) {
        discard;
    }
    return vec4f(density, 0.0, 0.0, 1.0);
}
