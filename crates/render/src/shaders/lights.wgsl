// The lights of the scene and the lists of lights for every cluster, in textures wrapped in two dimensions, reached only
// through `light_texel`, `cluster_at` and `cluster_light_at`, so that another storage can take their place here.
// The first `global_count` lights have no range or are directional; they are in no list and every pixel visits them.

import package::constants::{TABLE_WIDTH, LIST_WIDTH};
import package::view::view;
import package::shaders::brdf::{Shading, brdf_times_n_dot_l};
import package::shaders::light_table::{cluster_grid, light_texel, lights};
@if(shadowed) import package::shaders::shadows::{directional_visibility, punctual_visibility};

@group(0) @binding(5) var cluster_table: texture_2d<u32>;
@group(0) @binding(6) var cluster_lights: texture_2d<u32>;

struct LightSums {
    radiance: vec3f,
    visited: f32,
    shaded: f32,
    // Within the light's range and cone; counted only where pairs are.
    in_range: f32,
}

fn cluster_index_at(position_px: vec2f, distance_m: f32) -> u32 {
    let tile = min(vec2u(position_px) / cluster_grid.size.w, cluster_grid.size.xy - 1u);
    let slice_float = log2(distance_m) * cluster_grid.slice_from_log_distance.x + cluster_grid.slice_from_log_distance.y;
    let slice = u32(clamp(slice_float, 0.0, f32(cluster_grid.size.z - 1u)));
    return (slice * cluster_grid.size.y + tile.y) * cluster_grid.size.x + tile.x;
}

// Offset into the list, number of lights.
fn cluster_at(index: u32) -> vec2u {
    return textureLoad(cluster_table, vec2i(i32(index % TABLE_WIDTH), i32(index / TABLE_WIDTH)), 0).rg;
}

fn cluster_light_at(entry: u32) -> u32 {
    return textureLoad(cluster_lights, vec2i(i32(entry % LIST_WIDTH), i32(entry / LIST_WIDTH)), 0).r;
}

// The window of KHR_lights_punctual: (1 - (d/range)^4) / d², never below zero.
fn distance_attenuation(distance_squared: f32, inverse_range_squared: f32) -> f32 {
    let ratio_squared = distance_squared * inverse_range_squared;
    let window = clamp(1.0 - ratio_squared * ratio_squared, 0.0, 1.0);
    return window / max(distance_squared, 1e-6);
}

// What arrives from a light at a place, before anything blocks it.
struct Arriving {
    position_world: vec3f,
    to_light: vec3f,
    // Irradiance of a surface that faces the light; 0 if nothing arrives.
    irradiance: vec3f,
}

fn arriving_from(index: u32, position_world: vec3f, shading: Shading, sums: ptr<function, LightSums>) -> Arriving {
    var arriving: Arriving;
    let texel = light_texel(index);
    let place = textureLoad(lights, texel, 0);
    let towards = place.xyz - position_world;
    let distance_squared = dot(towards, towards);
    (*sums).visited += 1.0;
    if distance_squared * place.w > 1.0 {
        return arriving;
    }
    let to_light = towards * inverseSqrt(max(distance_squared, 1e-12));
    @if(counting) {
        let scale = textureLoad(lights, texel + vec2i(1, 0), 0).w;
        let axis = textureLoad(lights, texel + vec2i(2, 0), 0);
        (*sums).in_range += select(0.0, 1.0, dot(axis.xyz, -to_light) * scale + axis.w > 0.0);
    }
    if dot(shading.normal, to_light) <= 0.0 {
        return arriving;
    }
    let color = textureLoad(lights, texel + vec2i(1, 0), 0);
    var irradiance = distance_attenuation(distance_squared, place.w);
    // Point lights have no cone.
    if color.w != 0.0 {
        let axis = textureLoad(lights, texel + vec2i(2, 0), 0);
        let cone = clamp(dot(axis.xyz, -to_light) * color.w + axis.w, 0.0, 1.0);
        irradiance *= cone * cone;
        if irradiance <= 0.0 {
            return arriving;
        }
    }
    (*sums).shaded += 1.0;
    arriving.position_world = place.xyz;
    arriving.to_light = to_light;
    arriving.irradiance = color.rgb * irradiance;
    return arriving;
}

// A light at a place that casts no shadow.
fn unshadowed_radiance(index: u32, position_world: vec3f, shading: Shading, sums: ptr<function, LightSums>) {
    let arriving = arriving_from(index, position_world, shading, sums);
    if any(arriving.irradiance > vec3f(0.0)) {
        (*sums).radiance += brdf_times_n_dot_l(shading, arriving.to_light) * arriving.irradiance;
    }
}

// A light at a place, with its shadow if it casts one.
fn punctual_radiance(index: u32, position_world: vec3f, shading: Shading, sums: ptr<function, LightSums>) {
    @if(!shadowed) {
        unshadowed_radiance(index, position_world, shading, sums);
    }
    @if(shadowed) {
        let arriving = arriving_from(index, position_world, shading, sums);
        if any(arriving.irradiance > vec3f(0.0)) {
            let visibility = punctual_visibility(index, arriving.position_world, position_world, shading.facet_normal);
            (*sums).radiance += brdf_times_n_dot_l(shading, arriving.to_light) * arriving.irradiance * visibility;
        }
    }
}

fn directional_radiance(index: u32, position_world: vec3f, shading: Shading, sums: ptr<function, LightSums>) {
    let texel = light_texel(index);
    let color = textureLoad(lights, texel + vec2i(1, 0), 0);
    let to_light = -textureLoad(lights, texel + vec2i(2, 0), 0).xyz;
    (*sums).visited += 1.0;
    (*sums).in_range += 1.0;
    (*sums).shaded += 1.0;
    var irradiance = color.rgb;
    @if(shadowed) {
        if dot(shading.normal, to_light) > 0.0 {
            irradiance *= directional_visibility(index, position_world, shading.facet_normal);
        }
    }
    (*sums).radiance += brdf_times_n_dot_l(shading, to_light) * irradiance;
}

fn light_sums(position_px: vec2f, distance_m: f32, position_world: vec3f, shading: Shading) -> LightSums {
    var sums: LightSums;
    let directional_count = select(0u, cluster_grid.directional_count, position_px.x >= 0.0);
    let global_count = select(0u, cluster_grid.global_count, position_px.x >= 0.0);
    for (var i = 0u; i < directional_count; i++) {
        directional_radiance(i, position_world, shading, &sums);
    }
    for (var i = directional_count; i < global_count; i++) {
        punctual_radiance(i, position_world, shading, &sums);
    }
    let list = cluster_at(cluster_index_at(position_px, distance_m));
    let end = list.x + list.y;
    var entry = list.x;
    @if(shadowed) {
        // Lists are in the order of the lights, of which those that cast shadows are the last: a loop of their own spares the
        // others what shadows cost, where a processor runs both sides of a branch.
        for (; entry < end; entry++) {
            let light = cluster_light_at(entry);
            if light >= cluster_grid.first_caster.x {
                break;
            }
            unshadowed_radiance(light, position_world, shading, &sums);
        }
    }
    for (; entry < end; entry++) {
        punctual_radiance(cluster_light_at(entry), position_world, shading, &sums);
    }
    return sums;
}
