// Light from the environment on a surface: split-sum specular (Karis 2013) with multiple scattering, and Lambert. Suns of a picture are
// lights without shadows.

import package::gbuffer::{Surface, diffuse_environment_share};
import package::shaders::brdf::{Shading, PI, reflectance};
@if(layered) import package::constants::{LAYER_ANISOTROPY, LAYER_CLEARCOAT};
@if(layered) import package::shaders::layer_maps::has_layer;
@if(layered) import package::shaders::layers::layered_reflectance;
import package::shaders::environment::{
    environment, environment_irradiance, environment_reflection, grazing_share, lobe_direction, sun_count,
};
import package::shaders::environment_tiles::environment_level;
import package::shaders::environment_suns::disc_share;

// `shares` are what of the lobes, of the surface and of a clear coat, is not the mirror's, whose tile has the suns; and what of
// diffuse light.
fn sun_radiance(direction: vec4f, irradiance: vec4f, shading: Shading, shares: vec3f) -> vec3f {
    let n_dot_h = dot(shading.normal, normalize(shading.to_eye + direction.xyz));
    let disc = disc_share(shading.roughness_alpha, n_dot_h * n_dot_h, direction.w);
    @if(layered) {
        let layered = layered_reflectance(shading, direction.xyz);
        let coat_n_dot_h = dot(shading.layers.coat_normal, normalize(shading.to_eye + direction.xyz));
        let coat_disc = disc_share(shading.layers.coat_alpha, coat_n_dot_h * coat_n_dot_h, direction.w);
        return (layered.diffuse * shares.z + layered.specular * (shares.x * disc)
            + layered.coat * (shares.y * coat_disc)) * irradiance.rgb;
    }
    let n_dot_l = max(dot(shading.normal, direction.xyz), 0.0);
    let parts = reflectance(shading, direction.xyz, n_dot_l);
    return (parts.diffuse * shares.z + parts.specular * (shares.x * disc)) * (irradiance.rgb * n_dot_l);
}

fn suns_radiance(shading: Shading, diffuse_share: f32) -> vec3f {
    var share = vec3f(min(environment_level(sqrt(shading.roughness_alpha)), 1.0), 1.0, diffuse_share);
    @if(layered) {
        if has_layer(LAYER_ANISOTROPY) {
            share.x = min(environment_level(sqrt(shading.layers.alpha_lookup)), 1.0);
        }
        if has_layer(LAYER_CLEARCOAT) {
            share.y = min(environment_level(sqrt(shading.layers.coat_alpha)), 1.0);
        }
    }
    var sum = sun_radiance(environment.sun_directions[0], environment.sun_irradiances[0], shading, share);
    if sun_count > 1u {
        sum += sun_radiance(environment.sun_directions[1], environment.sun_irradiances[1], shading, share);
    }
    if sun_count > 2u {
        sum += sun_radiance(environment.sun_directions[2], environment.sun_irradiances[2], shading, share);
    }
    if sun_count > 3u {
        sum += sun_radiance(environment.sun_directions[3], environment.sun_irradiances[3], shading, share);
    }
    return sum;
}

fn ambient_radiance(surface: Surface, shading: Shading) -> vec3f {
    let specular_albedo = (shading.f0 * shading.dfg.x + shading.dfg.y) * shading.energy_compensation;
    let mirrored = reflect(-shading.to_eye, shading.normal);
    let grazing = grazing_share(shading.f0, 1.0, shading.dfg);
    let reflected = lobe_direction(mirrored, shading.normal, shading.n_dot_v, shading.roughness_alpha, grazing);
    let specular = environment_reflection(reflected, shading.roughness_alpha) * specular_albedo;
    let diffuse = environment_irradiance(shading.normal) * (1.0 / PI) * shading.albedo * (1.0 - specular_albedo);
    let diffuse_share = diffuse_environment_share(surface);
    var radiance = diffuse * diffuse_share + specular;
    if sun_count > 0u {
        radiance += suns_radiance(shading, diffuse_share);
    }
    return radiance * surface.occlusion;
}
