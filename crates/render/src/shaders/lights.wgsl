// What the lights of the scene add to the radiance of a surface, one by one, and those that are in no list. Sums over
// lists are those of `light_lists.wgsl`. The first `global_count` lights have no range or are directional; they are in
// no list and every pixel visits them.

import package::constants::{
    CASTING_POINTS, CASTING_SPOTS, DIRECTIONAL_LIGHTS, GLOBAL_LIGHTS, QUIET_POINTS, QUIET_SPOTS,
};
import package::shaders::brdf::{Shading, reflectance};
@if(contact) import package::shaders::contact::{contact_steps, contact_visibility};
@if(layered) import package::shaders::layers::layered_reflectance;
import package::shaders::light_table::{
    LIGHT_AXIS, LIGHT_COLOR, LIGHT_POSITION, TableRows, cluster_grid, light_part, light_place,
};
@if(relief) import package::shaders::relief::relief_visibility;
import package::shaders::shadows::{directional_visibility, punctual_visibility, shadowed};

// The classes of lights that there are, of which each has a loop: software adapters run the body of a loop once at
// least.
override light_classes: u32 = DIRECTIONAL_LIGHTS | GLOBAL_LIGHTS | QUIET_POINTS | CASTING_POINTS | CASTING_SPOTS | QUIET_SPOTS;
// 1 if the only light that is in no list is a directional one: software adapters pay for what lives across a loop.
override one_directional: u32 = 0u;
// 1 if pairs of light and what it may reach are counted in place of light.
override counts_pairs: u32 = 0u;
// 1 if `specular` is wanted beside `radiance`.
override splits_specular: u32 = 0u;
const LIGHTS_WITH_CONES: u32 = GLOBAL_LIGHTS | CASTING_SPOTS | QUIET_SPOTS;
const LIGHTS_WITH_SHADOWS: u32 = GLOBAL_LIGHTS | CASTING_POINTS | CASTING_SPOTS;

// The cosine between the normal of a triangle and the direction to a light below which the smooth surface over it takes
// its place, wholly at 0.
const TURNED_COSINE: f32 = 0.1;

struct LightSums {
    radiance: vec3f,
    // The specular part of radiance.
    specular: vec3f,
    visited: f32,
    shaded: f32,
    // Within the light's range and cone; counted only where pairs are.
    in_range: f32,
    // Visited, but spared by the bounds of a tile.
    passed_over: f32,
}

// What targets of counters take.
fn pair_counts(sums: LightSums) -> vec4f {
    return vec4f(sums.visited, sums.shaded, sums.in_range, sums.passed_over);
}

// Adds what the surface reflects of a light of so much irradiance on a plane across its direction.
fn add_reflected(
    shading: Shading,
    to_light: vec3f,
    n_dot_l: f32,
    irradiance: vec3f,
    sums: ptr<function, LightSums>,
) {
    @if(layered) {
        let layered = layered_reflectance(shading, to_light);
        (*sums).radiance += (layered.diffuse + layered.specular + layered.coat) * irradiance;
    }
    @if(!layered) {
        let parts = reflectance(shading, to_light, n_dot_l);
        (*sums).radiance += ((parts.diffuse + parts.specular) * n_dot_l) * irradiance;
        if splits_specular != 0u {
            (*sums).specular += (parts.specular * n_dot_l) * irradiance;
        }
    }
}

// The normal of the side of a surface on which shadows fall. Light that comes through reaches the other one.
fn lit_side(facet_normal: vec3f, to_light: vec3f) -> vec3f {
    @if(layered) {
        return select(-facet_normal, facet_normal, dot(facet_normal, to_light) >= 0.0);
    }
    @if(!layered) {
        return facet_normal;
    }
}

// Where a surface is compared with shadow maps.
struct ShadowReceiver {
    position_world: vec3f,
    normal: vec3f,
    is_flat: bool,
}

// The triangle itself, unless it is turned away from a light that the smooth surface over it faces. Its own body hides
// it there, and lines between light and dark would follow triangles. So it gives way to the smooth surface, on a plane
// that just faces the light; what is before that still casts its shadow. `to_light` is a unit vector.
fn shadow_receiver(position_world: vec3f, shading: Shading, to_light: vec3f) -> ShadowReceiver {
    let turned = max(TURNED_COSINE - dot(shading.facet_normal, to_light), 0.0);
    var is_lifted = (shading.lift_m > 0.0) & (turned > 0.0);
    // Light that comes through falls on the other side.
    @if(layered) {
        is_lifted = is_lifted & (dot(shading.normal, to_light) > 0.0);
    }
    let leaning = shading.facet_normal + to_light * turned;
    let normal = leaning * inverseSqrt(max(dot(leaning, leaning), 1e-30));
    let lift = normal * (shading.lift_m * min(turned / TURNED_COSINE, 1.0));
    return ShadowReceiver(
        position_world + select(vec3f(0.0), lift, is_lifted),
        select(lit_side(shading.facet_normal, to_light), normal, is_lifted),
        shading.is_flat & !is_lifted,
    );
}

// Adds a light at a place, which is of one of `classes` and lies at `table_uv` in the table. Classes are known when the
// shader is compiled, which spares lights that have no cone, or cast no shadow, what it costs others. The falloff is
// that of KHR_lights_punctual: (1 - (d/range)^4) / d², never below zero.
fn add_light(
    classes: u32,
    table_uv: vec2f,
    position_world: vec3f,
    shading: Shading,
    sums: ptr<function, LightSums>,
) {
    let has_cone = (classes & LIGHTS_WITH_CONES) != 0u;
    let place = light_part(table_uv, LIGHT_POSITION);
    let towards = place.xyz - position_world;
    let distance_squared = dot(towards, towards);
    let ratio_squared = distance_squared * place.w;
    let normal_towards = dot(shading.normal, towards);
    (*sums).visited += 1.0;
    if counts_pairs != 0u {
        let to_light = towards * inverseSqrt(max(distance_squared, 1e-12));
        let axis = light_part(table_uv, LIGHT_AXIS);
        let is_in_cone = axis.w - dot(axis.xyz, to_light) * light_part(table_uv, LIGHT_COLOR).w > 0.0;
        (*sums).in_range += select(0.0, 1.0, is_in_cone & (ratio_squared <= 1.0));
    }
    // In range, and before the surface, as one condition. Layers have normals of their own, and light may come through.
    @if(layered) let reaches = 1.0 - ratio_squared;
    @if(!layered) let reaches = min(1.0 - ratio_squared, normal_towards);
    if reaches > 0.0 {
        let inverse_distance = inverseSqrt(max(distance_squared, 1e-12));
        let to_light = towards * inverse_distance;
        let color = light_part(table_uv, LIGHT_COLOR);
        var attenuation = (1.0 - ratio_squared * ratio_squared) * min(inverse_distance * inverse_distance, 1e6);
        if has_cone {
            // Point lights have a scale of 0 and an offset of 1.
            let axis = light_part(table_uv, LIGHT_AXIS);
            let cone = clamp(axis.w - dot(axis.xyz, to_light) * color.w, 0.0, 1.0);
            attenuation *= cone * cone;
        }
        if !has_cone | (attenuation > 0.0) {
            (*sums).shaded += 1.0;
            if shadowed != 0u {
                if (classes & LIGHTS_WITH_SHADOWS) != 0u {
                    let at = shadow_receiver(position_world, shading, to_light);
                    attenuation *= punctual_visibility(table_uv, place.xyz, at.position_world, at.normal);
                    @if(contact) {
                        if contact_steps != 0u {
                            // Only half of the way, because bulbs around lights cast none of their shadows.
                            let reach_m = 0.5 * distance_squared * inverse_distance;
                            attenuation *= contact_visibility(shading.contact, table_uv, to_light, reach_m);
                        }
                    }
                }
            }
            @if(relief) {
                attenuation *= relief_visibility(shading.relief, to_light);
            }
            add_reflected(shading, to_light, normal_towards * inverse_distance, color.rgb * attenuation, sums);
        }
    }
}

// As a surface looks whose lobes are wider by `blur`, of the same light.
fn widened(shading: Shading, blur: f32) -> Shading {
    var wide = shading;
    let alpha = min(shading.roughness_alpha + blur, 1.0);
    let square = alpha * alpha;
    // Exactly 1 where nothing is widened.
    let share = square / max(shading.roughness_alpha * shading.roughness_alpha, 1e-12);
    wide.roughness_alpha = alpha;
    wide.alpha_squared = square;
    wide.eye_masking = sqrt(shading.n_dot_v * shading.n_dot_v * (1.0 - square) + square);
    wide.specular *= share;
    wide.specular_grazing *= share;
    @if(layered) {
        wide.layers.alpha_along = min(shading.layers.alpha_along + blur, 1.0);
        wide.layers.coat_alpha = min(shading.layers.coat_alpha + blur, 1.0);
    }
    return wide;
}

fn directional_radiance(
    index: u32,
    position_world: vec3f,
    shading: Shading,
    rows: TableRows,
    sums: ptr<function, LightSums>,
) {
    let table_uv = light_place(index, rows);
    let color = light_part(table_uv, LIGHT_COLOR);
    let to_light = -light_part(table_uv, LIGHT_AXIS).xyz;
    let n_dot_l = max(dot(shading.normal, to_light), 0.0);
    (*sums).visited += 1.0;
    (*sums).in_range += 1.0;
    (*sums).shaded += 1.0;
    var irradiance = color.rgb;
    if shadowed != 0u {
        @if(layered) let is_before = true;
        @if(!layered) let is_before = n_dot_l > 0.0;
        if is_before {
            let at = shadow_receiver(position_world, shading, to_light);
            irradiance *= directional_visibility(table_uv, at.position_world, at.normal, at.is_flat);
            @if(contact) {
                if contact_steps != 0u {
                    irradiance *= contact_visibility(shading.contact, table_uv, to_light, cluster_grid.contact.x);
                }
            }
        }
    }
    @if(relief) {
        irradiance *= relief_visibility(shading.relief, to_light);
    }
    // Of parallel light this is half the tangent of half the angle that its source takes.
    add_reflected(widened(shading, color.w), to_light, n_dot_l, irradiance, sums);
}

// Adds the lights that are in no list, from the number `first` on: directional ones up to one number, and others up to
// another.
fn add_global_lights(
    first: u32,
    directional_end: u32,
    end: u32,
    rows: TableRows,
    position_world: vec3f,
    shading: Shading,
    sums: ptr<function, LightSums>,
) {
    if (light_classes & DIRECTIONAL_LIGHTS) != 0u {
        for (var i = first; i < directional_end; i++) {
            directional_radiance(i, position_world, shading, rows, sums);
        }
    }
    if (light_classes & GLOBAL_LIGHTS) != 0u {
        for (var i = max(first, directional_end); i < end; i++) {
            add_light(GLOBAL_LIGHTS, light_place(i, rows), position_world, shading, sums);
        }
    }
}

// All lights that are in no list.
fn global_light_sums(position_px: vec2f, position_world: vec3f, shading: Shading, rows: TableRows) -> LightSums {
    var sums: LightSums;
    if one_directional != 0u {
        directional_radiance(0u, position_world, shading, rows, &sums);
        return sums;
    }
    // How long loops are depends on more than uniforms, see docs/decisions/006.
    let directional_count = select(0u, cluster_grid.directional_count, position_px.x >= 0.0);
    let global_count = select(0u, cluster_grid.global_count, position_px.x >= 0.0);
    add_global_lights(0u, directional_count, global_count, rows, position_world, shading, &sums);
    return sums;
}
