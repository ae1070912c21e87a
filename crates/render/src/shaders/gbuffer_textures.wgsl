// The G-buffer as passes after the geometry pass read it.

import package::gbuffer::{GbufferTexels, Surface, gbuffer_unpack, normal_unpack};

@group(1) @binding(0) var base_color: texture_2d<f32>;
@group(1) @binding(1) var normal: texture_2d<u32>;
@group(1) @binding(2) var material: texture_2d<f32>;
@group(1) @binding(3) var linear_depth: texture_2d<f32>;

fn surface_at(pixel: vec2i) -> Surface {
    var texels: GbufferTexels;
    texels.base_color = textureLoad(base_color, pixel, 0);
    texels.normal = textureLoad(normal, pixel, 0).rg;
    texels.material = textureLoad(material, pixel, 0);
    return gbuffer_unpack(texels);
}

fn normal_world_at(pixel: vec2i) -> vec3f {
    return normal_unpack(textureLoad(normal, pixel, 0).rg);
}

// Metres along the view axis; at least DISTANCE_BACKGROUND_M where there is no surface.
fn distance_at(pixel: vec2i) -> f32 {
    return textureLoad(linear_depth, pixel, 0).r;
}
