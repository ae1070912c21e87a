// What reaches a surface of the environment's light past what the picture shows beside it.
// Sources: light that white surfaces reflect to each other, Jimenez et al. 2016, "Practical Realtime Strategies for
// Accurate Indirect Occlusion"; of lobes, Lagarde & de Rousiers 2014, "Moving Frostbite to Physically Based Rendering";
// diffuse light around the mean direction from which it still comes, Landis 2002, "Production-Ready Global
// Illumination".

import package::gbuffer::Surface;
import package::shaders::ambient::{Seen, all_seen};
import package::shaders::brdf::Shading;
@if(layered) import package::constants::LAYER_CLEARCOAT;
@if(layered) import package::shaders::layer_maps::has_layer;
@if(layered) import package::shaders::transparency::glass_distances;

// The share of diffuse light (r) and its mean direction (gba); a texel that means nothing where `occluded` is 0. With
// layers a stage has no texture left for it on WebGL 2: it lies in the place of distances that no opaque surface needs.
@if(!layered) @group(1) @binding(6) var screen_occlusion: texture_2d<f32>;

override occluded: u32 = 0u;
override multi_bounce: u32 = 0u;
override bent_normals: u32 = 0u;

// What is left of what the material's own occlusion leaves. The lesser of the two is left in all, because both may know
// of the same crevice.
fn seen_at(pixel: vec2i, surface: Surface, shading: Shading) -> Seen {
    if occluded == 0u {
        return all_seen(shading);
    }
    @if(layered) {
        return seen_of(textureLoad(glass_distances, pixel, 0), surface, shading);
    }
    @if(!layered) {
        return seen_of(textureLoad(screen_occlusion, pixel, 0), surface, shading);
    }
}

// The share of what a lobe mirrors that is left where so much of diffuse light is.
fn specular_visibility(visibility: f32, n_dot_v: f32, roughness_alpha: f32) -> f32 {
    let exponent = exp2(-16.0 * roughness_alpha - 1.0);
    return clamp(pow(n_dot_v + visibility, exponent) - 1.0 + visibility, 0.0, 1.0);
}

// The same of what a texel of `screen_occlusion` says.
fn seen_of(texel: vec4f, surface: Surface, shading: Shading) -> Seen {
    var seen = all_seen(shading);
    // A sample of few directions may lie beyond the range, while the mean of them does not.
    let visibility = clamp(texel.r, 0.0, 1.0);
    var diffuse = vec3f(visibility);
    if multi_bounce != 0u {
        let a = 2.0404 * shading.albedo - 0.3324;
        let b = -4.7951 * shading.albedo + 0.6417;
        let c = 2.7552 * shading.albedo + 0.6903;
        diffuse = max(diffuse, ((visibility * a + b) * visibility + c) * visibility);
    }
    let specular = specular_visibility(visibility, shading.n_dot_v, shading.roughness_alpha);
    let own = max(surface.occlusion, 1e-3);
    seen.diffuse = min(diffuse / own, vec3f(1.0));
    seen.specular = min(specular / own, 1.0);
    @if(layered) {
        if has_layer(LAYER_CLEARCOAT) {
            let of_coat = specular_visibility(visibility, shading.layers.coat_n_dot_v, shading.layers.coat_alpha);
            seen.coat = min(of_coat / own, 1.0);
        }
    }
    if bent_normals != 0u {
        // Hardly anything is left where the mean of directions has no length.
        let bent = texel.gba + 1e-3 * shading.normal;
        seen.direction = bent * inverseSqrt(max(dot(bent, bent), 1e-12));
    }
    return seen;
}
