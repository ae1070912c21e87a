// Light from the environment on a surface with layers, what is found in the picture in its place, and what is seen
// through the surface.

import package::gbuffer::Surface;
import package::constants::{
    LAYER_ANISOTROPY, LAYER_CLEARCOAT, LAYER_DIFFUSE_TRANSMISSION, LAYER_LIGHT_MAP, LAYER_SHEEN, RADIANCE_MAX,
};
import package::view::view;
import package::shaders::brdf::{PI, Shading};
import package::shaders::ambient::{LEFT_SHARE, Seen, suns_radiance};
import package::shaders::colour::half_float_clamped;
import package::shaders::environment::{
    environment_irradiance_about, environment_reflection, grazing_share, lobe_direction, outside_probes, sun_count,
};
import package::shaders::layer_maps::has_layer;
import package::shaders::layers::{STRETCHED_LOOKUPS, below_coat};
import package::shaders::traced_lobe::{share_of_roughness, traced_roughness};

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

// What a surface with layers sends back of light from everywhere, by the lobes that get it from elsewhere: each is what
// the layers above it and the material's own occlusion leave.
struct LayeredShares {
    // Of diffuse light from the side of the normal, and from the other one.
    diffuse: vec3f,
    behind: vec3f,
    // Of what comes to the fibres of sheen.
    sheen: vec3f,
    // Of what is mirrored below a clear coat, and by that.
    mirrored: vec3f,
    coat: f32,
}

// Baked light takes the place of diffuse light.
fn diffuse_share() -> f32 {
    return select(1.0, 0.0, has_layer(LAYER_LIGHT_MAP));
}

fn layered_shares(surface: Surface, shading: Shading) -> LayeredShares {
    let terms = shading.layers;
    let below = terms.through * below_coat(terms) * surface.occlusion;
    var out: LayeredShares;
    out.mirrored = (shading.f0 * shading.dfg.x + terms.f90 * shading.dfg.y) * shading.energy_compensation * below;
    let entering = (1.0 - dielectric_albedo(shading)) * (1.0 - terms.transmission) * diffuse_share() * below;
    out.diffuse = shading.albedo * entering;
    if has_layer(LAYER_DIFFUSE_TRANSMISSION) {
        let passed = terms.diffuse_transmission.rgb * exp(-terms.absorption * terms.thickness_m) * (1.0 - terms.metallic);
        out.behind = passed * (entering * terms.diffuse_transmission.a);
        out.diffuse *= 1.0 - terms.diffuse_transmission.a;
    }
    if has_layer(LAYER_SHEEN) {
        out.sheen = terms.sheen_color * (terms.sheen_albedo * below_coat(terms) * surface.occlusion);
    }
    if has_layer(LAYER_CLEARCOAT) {
        out.coat = terms.coat_albedo * surface.occlusion;
    }
    return out;
}

// What the environment sends to each of these lobes.
fn light_of_environment(direction: vec3f, normal: vec3f) -> vec3f {
    return environment_irradiance_about(direction, normal) * (1.0 / PI);
}

fn light_of_fibres(shading: Shading) -> vec3f {
    // The lobe of fibres is as wide as that of irradiance, and leans towards the eye: a fit of its mean direction.
    let leaning = 0.35 + 1.8 * (1.0 - sqrt(shading.layers.sheen_alpha));
    return light_of_environment(normalize(shading.normal + shading.to_eye * leaning), shading.normal);
}

fn mirrored_below_coat(shading: Shading) -> vec3f {
    let grazing = grazing_share(shading.f0, shading.layers.f90, shading.dfg);
    if has_layer(LAYER_ANISOTROPY) {
        return stretched_reflection(shading, grazing);
    }
    let mirrored = reflect(-shading.to_eye, shading.normal);
    let reflected = lobe_direction(mirrored, shading.normal, shading.n_dot_v, shading.roughness_alpha, grazing);
    return environment_reflection(reflected, shading.roughness_alpha);
}

fn mirrored_by_coat(shading: Shading) -> vec3f {
    let terms = shading.layers;
    let mirrored = reflect(-shading.to_eye, terms.coat_normal);
    // Of a coat the split sum is added up already, and most are smooth: the lobe's direction stands for both.
    let of_coat = lobe_direction(mirrored, terms.coat_normal, terms.coat_n_dot_v, terms.coat_alpha, 0.0);
    return environment_reflection(of_coat, terms.coat_alpha);
}

// The setting `reflections.roughness_max`, as the bits of a number.
override reflected_roughness_max: u32 = 0u;

// How much of what rays brought, which follow the lobe that mirrors most sharply, is shown by what lies below a clear
// coat, and by that.
fn traced_shares(surface: Surface, shading: Shading) -> vec2f {
    let roughness_max = bitcast<f32>(reflected_roughness_max);
    var shares = vec2f(share_of_roughness(surface.roughness_perceptual, roughness_max), 0.0);
    if has_layer(LAYER_CLEARCOAT) {
        shares.y = share_of_roughness(sqrt(shading.layers.coat_alpha), roughness_max);
    }
    let followed = share_of_roughness(traced_roughness(surface), roughness_max);
    return min(shares / max(followed, 1e-3), vec2f(1.0));
}

fn layered_ambient(surface: Surface, shading: Shading, seen: Seen) -> vec3f {
    let shares = layered_shares(surface, shading);
    let traced = traced_shares(surface, shading);
    let left = 1.0 - seen.reflected.a * traced;
    var radiance = light_of_environment(seen.direction, shading.normal) * shares.diffuse * seen.diffuse;
    if has_layer(LAYER_DIFFUSE_TRANSMISSION) {
        radiance += light_of_environment(-shading.normal, -shading.normal) * shares.behind;
    }
    let mirrored = mirrored_below_coat(shading) * (seen.specular * left.x) + seen.reflected.rgb * traced.x;
    radiance += mirrored * shares.mirrored;
    if has_layer(LAYER_SHEEN) {
        radiance += light_of_fibres(shading) * shares.sheen * seen.diffuse;
    }
    if has_layer(LAYER_CLEARCOAT) {
        let of_coat = mirrored_by_coat(shading) * (seen.coat * left.y) + seen.reflected.rgb * traced.y;
        radiance += of_coat * shares.coat;
    }
    if sun_count > 0u {
        radiance += suns_radiance(shading, diffuse_share() * outside_probes) * seen.diffuse * surface.occlusion;
    }
    return radiance;
}

// The difference that what rays brought (`seen.reflected`) makes in the place of the environment's mirrored light.
fn reflected_in_place(surface: Surface, shading: Shading, seen: Seen) -> vec3f {
    let shares = layered_shares(surface, shading);
    let traced = traced_shares(surface, shading);
    let kept = traced * (seen.reflected.a * (1.0 - LEFT_SHARE));
    let below = mirrored_below_coat(shading) * shares.mirrored * seen.specular;
    var taken = min(below, vec3f(RADIANCE_MAX)) * kept.x;
    var lobes = shares.mirrored * traced.x;
    if has_layer(LAYER_CLEARCOAT) {
        let of_coat = mirrored_by_coat(shading) * (shares.coat * seen.coat);
        taken += min(of_coat, vec3f(RADIANCE_MAX)) * kept.y;
        lobes += vec3f(shares.coat * traced.y);
    }
    return half_float_clamped(seen.reflected.rgb * lobes) - taken;
}

// 1 if light that surfaces send each other takes the place of the environment's, which no occlusion takes away.
override takes_environment: u32 = 0u;

// The difference that light makes which surfaces send each other: its radiance times the share of directions from which
// it comes, and that share.
fn light_in_place(surface: Surface, shading: Shading, found: vec4f) -> vec3f {
    let shares = layered_shares(surface, shading);
    var taken = vec3f(0.0);
    if takes_environment != 0u {
        var of_environment = light_of_environment(shading.normal, shading.normal) * shares.diffuse;
        if has_layer(LAYER_SHEEN) {
            of_environment += light_of_fibres(shading) * shares.sheen;
        }
        taken = min(of_environment, vec3f(RADIANCE_MAX)) * (clamp(found.a, 0.0, 1.0) * (1.0 - LEFT_SHARE));
    }
    return half_float_clamped(max(found.rgb, vec3f(0.0)) * (shares.diffuse + shares.sheen)) - taken;
}
