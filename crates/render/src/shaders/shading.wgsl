// From a surface to what the reflectance model needs.

import package::gbuffer::Surface;
import package::constants::{DIRECTIONAL_ALBEDO_SIZE, ROUGHNESS_PERCEPTUAL_MIN};
import package::shaders::brdf::{Shading, set_lamp_terms};

// The least cosine between the normals of a surface and of its facet where the surface is flat.
const FLAT_LIKENESS_MIN: f32 = 0.9998;

// Scale and bias of f0 in the directional albedo of GGX (Karis 2013), and the directional albedo of sheen, over n.v (u)
// and perceptual roughness (v); integrated by `resources/directional_albedo.rs`. They are the lowest rows of a texture
// that may hold the images of decals above, because a stage on WebGL 2 has no texture to spare.
@group(0) @binding(1) var directional_albedo: texture_2d<f32>;
@group(0) @binding(2) var linear_clamp: sampler;

fn dfg_at(n_dot_v: f32, roughness_perceptual: f32) -> vec3f {
    let size = f32(DIRECTIONAL_ALBEDO_SIZE);
    let texels = vec2f(textureDimensions(directional_albedo));
    let place = vec2f(n_dot_v, roughness_perceptual) * (size - 1.0) + 0.5;
    let uv = (place + vec2f(0.0, texels.y - size)) / texels;
    return textureSampleLevel(directional_albedo, linear_clamp, uv, 0.0).rgb;
}

fn shading_from_surface(surface: Surface, to_eye: vec3f) -> Shading {
    var shading: Shading;
    let roughness = max(surface.roughness_perceptual, ROUGHNESS_PERCEPTUAL_MIN);
    shading.normal = surface.normal_world;
    shading.facet_normal = surface.normal_world;
    shading.is_flat = false;
    shading.lift_m = 0.0;
    shading.to_eye = to_eye;
    // A normal map can turn the normal away from the eye; 1e-4 keeps visibility finite there.
    shading.n_dot_v = max(dot(surface.normal_world, to_eye), 1e-4);
    shading.roughness_alpha = roughness * roughness;
    shading.albedo = surface.base_color * (1.0 - surface.metallic);
    shading.f0 = mix(vec3f(surface.f0_dielectric), surface.base_color, surface.metallic);
    shading.dfg = dfg_at(shading.n_dot_v, roughness).xy;
    shading.energy_compensation = 1.0 + shading.f0 * (1.0 / max(shading.dfg.x + shading.dfg.y, 1e-3) - 1.0);
    set_lamp_terms(&shading);
    return shading;
}
