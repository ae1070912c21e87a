// The G-buffer's only pack and unpack: 12 bytes a pixel beside radiance and depth.
//   base_color rgba8unorm-srgb   base colour; occlusion of the material
//   normal     rg16uint          world normal, octahedral, 16 + 16 bits
//   material   rgba8unorm        metallic, perceptual roughness, reflectance, shading model with lift
// Reflectance is the dielectric's f0 divided by 0.2, so that the 0.04 of glTF is exactly 51/255. Bytes from 218 to 254
// of the shading model are the standard one with a lift: its logarithm, the smallest at 254.

import package::shaders::octahedral::{octahedral_from_direction, direction_from_octahedral};

const REFLECTANCE_SCALE: f32 = 0.2;
const SHADING_MODEL_UNLIT: f32 = 0.0;
// Between them lie those that are shaded where they are drawn, because the material has more than this holds: light
// passes leave them alone. `constants.rs` has some, which `shaders/traced_lobe.wgsl` tells apart.
// Standard, but diffuse light of the environment is in what was baked.
const SHADING_MODEL_BAKED: f32 = 0.8;
const SHADING_MODEL_STANDARD: f32 = 1.0;
// The least lift that is held, in pixels, octaves between two bytes (so the greatest is 1,350 pixels), and how many
// bytes there are.
const LIFT_LEAST_PX: f32 = 0.0625;
const LIFT_OCTAVES: f32 = 0.4;
const LIFT_BYTES: f32 = 37.0;

struct Surface {
    base_color: vec3f,
    occlusion: f32,
    normal_world: vec3f,
    metallic: f32,
    roughness_perceptual: f32,
    f0_dielectric: f32,
    shading_model: f32,
    // How far the smooth surface that vertex normals describe lies over the triangle that was drawn; 0 where that is
    // not held. Pixels.
    lift_px: f32,
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

// The fourth channel of `material`.
fn model_with_lift(surface: Surface) -> f32 {
    let step = round(log2(max(surface.lift_px, LIFT_LEAST_PX) / LIFT_LEAST_PX) / LIFT_OCTAVES);
    let byte = 254.0 - min(step, LIFT_BYTES - 1.0);
    let has_lift = (surface.lift_px >= LIFT_LEAST_PX) & (surface.shading_model == SHADING_MODEL_STANDARD);
    return select(surface.shading_model, byte / 255.0, has_lift);
}

fn gbuffer_pack(surface: Surface) -> GbufferTexels {
    var texels: GbufferTexels;
    texels.base_color = vec4f(surface.base_color, surface.occlusion);
    texels.normal = vec2u(round((octahedral_from_direction(surface.normal_world) * 0.5 + 0.5) * 65535.0));
    texels.material = vec4f(
        surface.metallic,
        surface.roughness_perceptual,
        surface.f0_dielectric / REFLECTANCE_SCALE,
        model_with_lift(surface),
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
    let step = 254.0 - round(texels.material.a * 255.0);
    let has_lift = (step >= 0.0) & (step < LIFT_BYTES);
    surface.shading_model = select(texels.material.a, SHADING_MODEL_STANDARD, has_lift);
    surface.lift_px = select(0.0, LIFT_LEAST_PX * exp2(step * LIFT_OCTAVES), has_lift);
    return surface;
}
