// What the lights of the scene, and those in the lists of clusters, add to the radiance of a surface.
// The first `global_count` lights have no range or are directional; they are in no list and every pixel visits them.

import package::view::view;
import package::shaders::brdf::{Shading, brdf_times_n_dot_l};
import package::shaders::light_table::{
    TableRows, cluster_at, cluster_grid, cluster_light_place, light_part, light_place, table_rows,
};
@if(shadowed) import package::shaders::shadows::{directional_visibility, punctual_visibility};

// The classes of lights that there are, of which each has a loop: software adapters run the body of a loop once at least.
override light_classes: u32 = 63u;
const DIRECTIONAL_LIGHTS: u32 = 1u;
const GLOBAL_LIGHTS: u32 = 2u;
const QUIET_POINTS: u32 = 4u;
const CASTING_POINTS: u32 = 8u;
const CASTING_SPOTS: u32 = 16u;
const QUIET_SPOTS: u32 = 32u;

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

// Adds a light at a place, which lies at `table_uv` in the table. What is known of it when the shader is compiled spares others
// what it costs: whether it may have a cone, and whether it may cast a shadow.
// The falloff is that of KHR_lights_punctual: (1 - (d/range)^4) / d², never below zero.
fn add_light(
    table_uv: vec2f,
    may_have_cone: bool,
    may_cast: bool,
    position_world: vec3f,
    shading: Shading,
    sums: ptr<function, LightSums>,
) {
    let place = light_part(table_uv, 0.0);
    let towards = place.xyz - position_world;
    let distance_squared = dot(towards, towards);
    let ratio_squared = distance_squared * place.w;
    let normal_towards = dot(shading.normal, towards);
    (*sums).visited += 1.0;
    @if(counting) {
        let to_light = towards * inverseSqrt(max(distance_squared, 1e-12));
        let axis = light_part(table_uv, 2.0);
        let is_in_cone = axis.w - dot(axis.xyz, to_light) * light_part(table_uv, 1.0).w > 0.0;
        (*sums).in_range += select(0.0, 1.0, is_in_cone & (ratio_squared <= 1.0));
    }
    // In range, and before the surface, as one condition.
    if min(1.0 - ratio_squared, normal_towards) > 0.0 {
        let inverse_distance = inverseSqrt(max(distance_squared, 1e-12));
        let to_light = towards * inverse_distance;
        let color = light_part(table_uv, 1.0);
        var attenuation = (1.0 - ratio_squared * ratio_squared) * min(inverse_distance * inverse_distance, 1e6);
        if may_have_cone {
            // Point lights have a scale of 0 and an offset of 1.
            let axis = light_part(table_uv, 2.0);
            let cone = clamp(axis.w - dot(axis.xyz, to_light) * color.w, 0.0, 1.0);
            attenuation *= cone * cone;
        }
        if !may_have_cone | (attenuation > 0.0) {
            (*sums).shaded += 1.0;
            @if(shadowed) {
                if may_cast {
                    attenuation *= punctual_visibility(table_uv, place.xyz, position_world, shading.facet_normal);
                }
            }
            let reflected = brdf_times_n_dot_l(shading, to_light, normal_towards * inverse_distance);
            (*sums).radiance += reflected * (color.rgb * attenuation);
        }
    }
}

// A light at a place of which nothing is known.
fn punctual_radiance(
    index: u32,
    position_world: vec3f,
    shading: Shading,
    rows: TableRows,
    sums: ptr<function, LightSums>,
) {
    add_light(light_place(index, rows), true, true, position_world, shading, sums);
}

fn directional_radiance(
    index: u32,
    position_world: vec3f,
    shading: Shading,
    rows: TableRows,
    sums: ptr<function, LightSums>,
) {
    let table_uv = light_place(index, rows);
    let color = light_part(table_uv, 1.0);
    let to_light = -light_part(table_uv, 2.0).xyz;
    let n_dot_l = max(dot(shading.normal, to_light), 0.0);
    (*sums).visited += 1.0;
    (*sums).in_range += 1.0;
    (*sums).shaded += 1.0;
    var irradiance = color.rgb;
    @if(shadowed) {
        if n_dot_l > 0.0 {
            irradiance *= directional_visibility(table_uv, position_world, shading.facet_normal);
        }
    }
    (*sums).radiance += brdf_times_n_dot_l(shading, to_light, n_dot_l) * irradiance;
}

// The lights that are in no list: directional ones, and those without a range.
fn global_light_sums(position_px: vec2f, position_world: vec3f, shading: Shading, rows: TableRows) -> LightSums {
    var sums: LightSums;
    // How long loops are depends on more than uniforms, see ARCHITECTURE.md.
    let directional_count = select(0u, cluster_grid.directional_count, position_px.x >= 0.0);
    let global_count = select(0u, cluster_grid.global_count, position_px.x >= 0.0);
    if (light_classes & DIRECTIONAL_LIGHTS) != 0u {
        for (var i = 0u; i < directional_count; i++) {
            directional_radiance(i, position_world, shading, rows, &sums);
        }
    }
    if (light_classes & GLOBAL_LIGHTS) != 0u {
        for (var i = directional_count; i < global_count; i++) {
            punctual_radiance(i, position_world, shading, rows, &sums);
        }
    }
    return sums;
}

fn light_sums(position_px: vec2f, distance_m: f32, position_world: vec3f, shading: Shading) -> LightSums {
    let rows = table_rows();
    var sums = global_light_sums(position_px, position_world, shading, rows);
    // Each class of lights has a loop of its own, so that the others are spared what it costs where a processor runs both
    // sides of a branch.
    let list = cluster_at(cluster_index_at(position_px, distance_m));
    var entry = list.first;
    @if(shadowed) {
        if (light_classes & QUIET_POINTS) != 0u {
            for (; entry < list.quiet_points_end; entry++) {
                add_light(cluster_light_place(entry, rows), false, false, position_world, shading, &sums);
            }
        }
        if (light_classes & CASTING_POINTS) != 0u {
            for (; entry < list.points_end; entry++) {
                add_light(cluster_light_place(entry, rows), false, true, position_world, shading, &sums);
            }
        }
        if (light_classes & CASTING_SPOTS) != 0u {
            for (; entry < list.casters_end; entry++) {
                add_light(cluster_light_place(entry, rows), true, true, position_world, shading, &sums);
            }
        }
        if (light_classes & QUIET_SPOTS) != 0u {
            for (; entry < list.end; entry++) {
                add_light(cluster_light_place(entry, rows), true, false, position_world, shading, &sums);
            }
        }
    }
    @if(!shadowed) {
        if (light_classes & (QUIET_POINTS | CASTING_POINTS)) != 0u {
            for (; entry < list.points_end; entry++) {
                add_light(cluster_light_place(entry, rows), false, false, position_world, shading, &sums);
            }
        }
        if (light_classes & (CASTING_SPOTS | QUIET_SPOTS)) != 0u {
            for (; entry < list.end; entry++) {
                add_light(cluster_light_place(entry, rows), true, false, position_world, shading, &sums);
            }
        }
    }
    return sums;
}
