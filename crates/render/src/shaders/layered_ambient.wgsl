// Light from the environment on a surface with layers, and what is seen through it.

import package::gbuffer::Surface;
import package::constants::{
    LAYER_ANISOTROPY, LAYER_CLEARCOAT, LAYER_DIFFUSE_TRANSMISSION, LAYER_LIGHT_MAP, LAYER_SHEEN,
};
import package::shaders::brdf::{PI, Shading};
import package::shaders::ambient::suns_radiance;
import package::shaders::environment::{
    environment_irradiance, environment_reflection, grazing_share, lobe_direction, sun_count,
};
import package::shaders::layer_maps::has_layer;
import package::shaders::layers::below_coat;

// The normal about which stretched highlights are mirrored, in place of several samples along them (Revie 2012, GPU Pro 2, in the
// form of KHR_materials_anisotropy).
fn reflection_normal(shading: Shading) -> vec3f {
    if !has_layer(LAYER_ANISOTROPY) {
        return shading.normal;
    }
    let terms = shading.layers;
    let across = cross(terms.bitangent, shading.to_eye);
    let stretched = cross(across, terms.bitangent);
    let keep = 1.0 - terms.anisotropy * (1.0 - sqrt(shading.roughness_alpha));
    let keep_squared = keep * keep;
    let bent = mix(stretched, shading.normal, keep_squared * keep_squared);
    return bent * inverseSqrt(max(dot(bent, bent), 1e-12));
}

// How much of the light that is seen through a surface its layers leave.
fn transmitted_share(shading: Shading) -> vec3f {
    let terms = shading.layers;
    let entering = 1.0 - dielectric_albedo(shading);
    return terms.base_color * (entering * terms.transmission * (1.0 - terms.metallic) * terms.through * below_coat(terms));
}

// How much of all light what is not metal reflects at once.
fn dielectric_albedo(shading: Shading) -> f32 {
    let terms = shading.layers;
    let single = terms.f0_dielectric * shading.dfg.x + terms.f90_dielectric * shading.dfg.y;
    let compensation = 1.0 + terms.f0_dielectric * (1.0 / max(shading.dfg.x + shading.dfg.y, 1e-3) - 1.0);
    return min(single * compensation, 1.0);
}

fn layered_ambient(surface: Surface, shading: Shading) -> vec3f {
    let terms = shading.layers;
    let specular_albedo = (shading.f0 * shading.dfg.x + terms.f90 * shading.dfg.y) * shading.energy_compensation;
    let normal = reflection_normal(shading);
    let mirrored = reflect(-shading.to_eye, normal);
    let grazing = grazing_share(shading.f0, terms.f90, shading.dfg);
    let reflected = lobe_direction(mirrored, normal, shading.n_dot_v, shading.roughness_alpha, grazing);
    let specular = environment_reflection(reflected, shading.roughness_alpha) * specular_albedo;
    let entering = 1.0 - dielectric_albedo(shading);
    var diffuse = environment_irradiance(shading.normal) * shading.albedo;
    if has_layer(LAYER_DIFFUSE_TRANSMISSION) {
        let passed = terms.diffuse_transmission.rgb * exp(-terms.absorption * terms.thickness_m) * (1.0 - terms.metallic);
        diffuse = mix(diffuse, environment_irradiance(-shading.normal) * passed, terms.diffuse_transmission.a);
    }
    // Baked light takes its place.
    let diffuse_share = select(1.0, 0.0, has_layer(LAYER_LIGHT_MAP));
    diffuse *= diffuse_share;
    var radiance = diffuse * (entering * (1.0 - terms.transmission) / PI) + specular;
    if has_layer(LAYER_SHEEN) {
        // The lobe of fibres is as wide as that of irradiance, and leans towards the eye: a fit of its mean direction.
        let leaning = 0.35 + 1.8 * (1.0 - sqrt(terms.sheen_alpha));
        let axis = normalize(shading.normal + shading.to_eye * leaning);
        let sheen = environment_irradiance(axis) * (terms.sheen_color * (terms.sheen_albedo / PI));
        radiance = radiance * terms.through + sheen;
    }
    if has_layer(LAYER_CLEARCOAT) {
        let mirrored_by_coat = reflect(-shading.to_eye, terms.coat_normal);
        // Of a coat the split sum is added up already, and most are smooth: the lobe's direction stands for both.
        let of_coat = lobe_direction(mirrored_by_coat, terms.coat_normal, terms.coat_n_dot_v, terms.coat_alpha, 0.0);
        radiance = radiance * below_coat(terms) + environment_reflection(of_coat, terms.coat_alpha) * terms.coat_albedo;
    }
    if sun_count > 0u {
        radiance += suns_radiance(shading, diffuse_share);
    }
    return radiance * surface.occlusion;
}
