// The G-buffer's only pack and unpack: 12 bytes a pixel beside radiance and depth.
//   base_color rgba8unorm-srgb   base colour; occlusion of the material
//   normal     rg16uint          world normal, octahedral, 16 + 16 bits
//   material   rgba8unorm        metallic, perceptual roughness, reflectance, shading model
// Reflectance is the dielectric's f0 divided by 0.2, so that the 0.04 of glTF is exactly 51/255.

import package::shaders::octahedral::{octahedral_from_direction, direction_from_octahedral};

const REFLECTANCE_SCALE: f32 = 0.2;
const SHADING_MODEL_UNLIT: f32 = 0.0;
// Between them lie those that are shaded where they are drawn, because the material has more than this holds: light
// passes leave them alone. `constants.rs` has some, which `shaders/traced_lobe.wgsl` tells apart.
// Standard, but diffuse light of the environment is in what was baked.
const SHADING_MODEL_BAKED: f32 = 0.8;
const SHADING_MODEL_STANDARD: f32 = 1.0;

struct Surface {
    base_color: vec3f,
    occlusion: f32,
    normal_world: vec3f,
    metallic: f32,
    roughness_perceptual: f32,
    f0_dielectric: f32,
    shading_model: f32,
}

struct GbufferTexels {
    base_color: vec4f,
    normal: vec2u,
    material: vec4f,
}

// Whether passes that read the G-buffer light a surface.
fn is_lit_deferred(surface: Surface) -> bool {
    return surface.shading_model > 0.75;
}

// How much of the environment's diffuse light a surface takes.
fn diffuse_environment_share(surface: Surface) -> f32 {
    return select(1.0, 0.0, abs(surface.shading_model - SHADING_MODEL_BAKED) < 0.05);
}

fn gbuffer_pack(surface: Surface) -> GbufferTexels {
    var texels: GbufferTexels;
    texels.base_color = vec4f(surface.base_color, surface.occlusion);
    texels.normal = vec2u(round((octahedral_from_direction(surface.normal_world) * 0.5 + 0.5) * 65535.0));
    texels.material = vec4f(
        surface.metallic,
        surface.roughness_perceptual,
        surface.f0_dielectric / REFLECTANCE_SCALE,
        surface.shading_model,
    );
    return texels;
}

fn normal_unpack(texel: vec2u) -> vec3f {
    return direction_from_octahedral(vec2f(texel) / 65535.0 * 2.0 - 1.0);
}

fn gbuffer_unpack(texels: GbufferTexels) -> Surface {
    var surface: Surface;
    surface.base_color = texels.base_color.rgb;
    surface.occlusion = texels.base_color.a;
    surface.normal_world = normal_unpack(texels.normal);
    surface.metallic = texels.material.r;
    surface.roughness_perceptual = texels.material.g;
    surface.f0_dielectric = texels.material.b * REFLECTANCE_SCALE;
    surface.shading_model = texels.material.a;
    return surface;
}
