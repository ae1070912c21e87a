// Light from the environment on a surface with layers, and what is seen through it.

import package::gbuffer::Surface;
import package::constants::{
    LAYER_ANISOTROPY, LAYER_CLEARCOAT, LAYER_DIFFUSE_TRANSMISSION, LAYER_LIGHT_MAP, LAYER_SHEEN,
};
import package::view::view;
import package::shaders::brdf::{PI, Shading};
import package::shaders::ambient::suns_radiance;
import package::shaders::environment::{
    environment_irradiance, environment_irradiance_about, environment_reflection, grazing_share, lobe_direction,
    outside_probes, sun_count,
};
import package::shaders::layer_maps::has_layer;
import package::shaders::layers::{STRETCHED_LOOKUPS, below_coat};

// Radiance averaged over a stretched lobe: several round lobes as wide as it is across, along where half vectors that
// the eye sees lie in the plane of the tangent and the normal. Of the visible normals of GGX (Heitz 2018) a share in
// that plane is even by the cut through the disc on which they are even, so that each lobe stands for as many. Samples
// of a picture have theirs between each other.
fn stretched_reflection(shading: Shading, grazing: f32) -> vec3f {
    let terms = shading.layers;
    let alpha = terms.alpha_lookup;
    let spread = sqrt(max(terms.alpha_along * terms.alpha_along - alpha * alpha, 0.0));
    let eye_along = dot(terms.tangent, shading.to_eye);
    let eye = normalize(vec2f(spread * eye_along, shading.n_dot_v));
    let side = vec2f(-eye.y, eye.x) * select(1.0, -1.0, eye.x < 0.0);
    let visible = 0.5 + 0.5 * eye.y;
    let shift = fract(0.5 + f32(view.sample_index) * 0.618034);
    let eye_length = length(vec2f(spread * eye_along, shading.n_dot_v));
    var sum = vec4f(0.0);
    for (var i = 0u; i < STRETCHED_LOOKUPS; i++) {
        let place = (f32(i) + shift) * (2.0 / f32(STRETCHED_LOOKUPS)) - 1.0;
        let cut = 1.0 - visible + visible * place;
        let found = side * cut + eye * sqrt(max(1.0 - cut * cut, 0.0));
        let halfway = normalize(terms.tangent * (spread * found.x) + shading.normal * max(found.y, 1e-4));
        let mirrored = reflect(-shading.to_eye, halfway);
        // What of it other facets hide from light (Heitz 2014).
        let n_dot_l = max(dot(shading.normal, mirrored), 0.0);
        let light_length = length(vec2f(spread * dot(terms.tangent, mirrored), n_dot_l));
        let open = n_dot_l * (shading.n_dot_v + eye_length)
            / max(n_dot_l * eye_length + shading.n_dot_v * light_length, 1e-6);
        let v_dot_half = max(dot(shading.to_eye, halfway), 1e-4);
        let direction = lobe_direction(mirrored, halfway, v_dot_half, alpha, grazing);
        sum += vec4f(environment_reflection(direction, alpha), 1.0) * max(open, 1e-3);
    }
    return sum.rgb / sum.a;
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
    let grazing = grazing_share(shading.f0, terms.f90, shading.dfg);
    var specular = vec3f(0.0);
    if has_layer(LAYER_ANISOTROPY) {
        specular = stretched_reflection(shading, grazing) * specular_albedo;
    } else {
        let mirrored = reflect(-shading.to_eye, shading.normal);
        let reflected = lobe_direction(mirrored, shading.normal, shading.n_dot_v, shading.roughness_alpha, grazing);
        specular = environment_reflection(reflected, shading.roughness_alpha) * specular_albedo;
    }
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
        let sheen = environment_irradiance_about(axis, shading.normal) * (terms.sheen_color * (terms.sheen_albedo / PI));
        radiance = radiance * terms.through + sheen;
    }
    if has_layer(LAYER_CLEARCOAT) {
        let mirrored_by_coat = reflect(-shading.to_eye, terms.coat_normal);
        // Of a coat the split sum is added up already, and most are smooth: the lobe's direction stands for both.
        let of_coat = lobe_direction(mirrored_by_coat, terms.coat_normal, terms.coat_n_dot_v, terms.coat_alpha, 0.0);
        radiance = radiance * below_coat(terms) + environment_reflection(of_coat, terms.coat_alpha) * terms.coat_albedo;
    }
    if sun_count > 0u {
        radiance += suns_radiance(shading, diffuse_share * outside_probes);
    }
    return radiance * surface.occlusion;
}
