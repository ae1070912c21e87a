// Light from the environment on a surface: split-sum specular (Karis 2013) with multiple scattering, and Lambert. Suns
// of a picture are lights without shadows.

import package::gbuffer::{Surface, diffuse_environment_share};
import package::shaders::brdf::{Shading, PI, reflectance, reflectance_model};
@if(layered) import package::constants::{LAYER_ANISOTROPY, LAYER_CLEARCOAT};
@if(layered) import package::shaders::layer_maps::has_layer;
@if(layered) import package::shaders::layers::layered_reflectance;
import package::shaders::environment::{
    environment_irradiance_about, environment_reflection, grazing_share, lobe_direction, outside_share,
    outside_probes, sun_count,
};
import package::shaders::environment_tiles::environment_level;
import package::shaders::environment_uniform::environment;
import package::shaders::environment_suns::{disc_share, strip_share};

// What a round lobe of GGX about `normal` has of a sun's disc, see `disc_share`.
fn sun_share(normal: vec3f, to_eye: vec3f, alpha: f32, direction: vec4f) -> f32 {
    let sum = to_eye + direction.xyz;
    let n_dot_sum = dot(normal, sum);
    return disc_share(alpha, n_dot_sum * n_dot_sum / max(dot(sum, sum), 1e-8), direction.w);
}

// `shares` are what of the lobes, of the surface and of a clear coat, is not the mirror's, whose tile has the suns; and
// what of diffuse light.
fn sun_radiance(direction: vec4f, irradiance: vec4f, shading: Shading, shares: vec3f) -> vec3f {
    @if(layered) {
        var disc = 1.0;
        var widened = shading;
        if has_layer(LAYER_ANISOTROPY) {
            // Half vectors as slopes, and how far the disc spreads them: along the lobe, which is as much lower in its
            // middle as if it were wider by the disc, and across it, where it is narrow.
            let sum = shading.to_eye + direction.xyz;
            let scale = 1.0 / max(dot(shading.normal, sum), 1e-2);
            let slope = vec2f(dot(shading.layers.tangent, sum), dot(shading.layers.bitangent, sum)) * scale;
            let tilted_along = shading.layers.tangent - slope.x * shading.normal;
            let tilted_across = shading.layers.bitangent - slope.y * shading.normal;
            let away = vec2f(dot(tilted_along, direction.xyz), dot(tilted_across, direction.xyz));
            let spread = (1.0 + slope * slope - away * away) * (4.0 * scale * scale * direction.w);
            let along_squared = shading.layers.alpha_along * shading.layers.alpha_along + min(spread.x, 1.0);
            let height = shading.roughness_alpha * shading.roughness_alpha * (1.0 + slope.x * slope.x / along_squared);
            widened.layers.alpha_along = sqrt(along_squared);
            disc = strip_share(slope.y, height, spread.y);
        } else {
            disc = sun_share(shading.normal, shading.to_eye, shading.roughness_alpha, direction);
        }
        let layered = layered_reflectance(widened, direction.xyz);
        let coat_disc = sun_share(shading.layers.coat_normal, shading.to_eye, shading.layers.coat_alpha, direction);
        return (layered.diffuse * shares.z + layered.specular * (shares.x * disc)
            + layered.coat * (shares.y * coat_disc)) * irradiance.rgb;
    }
    @if(!layered) {
        // Phong's and Blinn's lobes have other shapes, for which the share of a disc is not known here.
        let of_ggx = sun_share(shading.normal, shading.to_eye, shading.roughness_alpha, direction);
        let disc = select(1.0, of_ggx, reflectance_model == 0u);
        let n_dot_l = max(dot(shading.normal, direction.xyz), 0.0);
        let parts = reflectance(shading, direction.xyz, n_dot_l);
        return (parts.diffuse * shares.z + parts.specular * (shares.x * disc)) * (irradiance.rgb * n_dot_l);
    }
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
    return sum * outside_share();
}

// What nothing in the picture hides: the shares of diffuse and of specular light, the direction around which diffuse
// light comes, and the share of what a clear coat mirrors. And what the picture shows of mirrored light in the
// environment's place, with the share of it.
struct Seen {
    diffuse: vec3f,
    specular: f32,
    direction: vec3f,
    coat: f32,
    reflected: vec4f,
}

// Radiance is rounded to half floats: so much is left of what something else takes the place of, that nothing is below
// 0.
const LEFT_SHARE: f32 = 0.002;

// Where nothing is hidden.
fn all_seen(shading: Shading) -> Seen {
    return Seen(vec3f(1.0), 1.0, shading.normal, 1.0, vec4f(0.0));
}

fn ambient_radiance(surface: Surface, shading: Shading) -> vec3f {
    return ambient_radiance_seen(surface, shading, all_seen(shading));
}

// What is not shown of mirrored light, and is diffuse light instead, as the bits of a number (`shading.reflectivity`).
override mirrored_lost: u32 = 0u;

// What a surface mirrors of the environment: the radiance of its lobe, and the share of it that is reflected.
struct MirroredLight {
    radiance: vec3f,
    albedo: vec3f,
}

// The share of even light from everywhere that a surface mirrors.
fn mirrored_albedo(shading: Shading) -> vec3f {
    let whole = (shading.f0 * shading.dfg.x + shading.dfg.y) * shading.energy_compensation;
    return whole * (1.0 - bitcast<f32>(mirrored_lost));
}

fn mirrored_environment(shading: Shading) -> MirroredLight {
    let albedo = mirrored_albedo(shading);
    let mirrored = reflect(-shading.to_eye, shading.normal);
    let grazing = grazing_share(shading.f0, 1.0, shading.dfg);
    let reflected = lobe_direction(mirrored, shading.normal, shading.n_dot_v, shading.roughness_alpha, grazing);
    return MirroredLight(environment_reflection(reflected, shading.roughness_alpha), albedo);
}

fn ambient_radiance_seen(surface: Surface, shading: Shading, seen: Seen) -> vec3f {
    let mirrored = mirrored_environment(shading);
    let specular = mirrored.radiance * mirrored.albedo * (seen.specular * (1.0 - seen.reflected.a))
        + seen.reflected.rgb * mirrored.albedo;
    let diffuse = environment_irradiance_about(seen.direction, shading.normal) * (1.0 / PI) * shading.albedo * (1.0 - mirrored.albedo);
    let diffuse_share = diffuse_environment_share(surface);
    // Probes hold the diffuse light of suns, as light maps do.
    var radiance = diffuse * diffuse_share * seen.diffuse + specular;
    if sun_count > 0u {
        radiance += suns_radiance(shading, diffuse_share * outside_probes) * seen.diffuse;
    }
    return radiance * surface.occlusion;
}
