// volumes: the light of one lamp on the pixels of its volume, added to `radiance`.
// Source: light volumes (Hargreaves & Harris 2004, "Deferred Shading"). Reads: G-buffer, linear_depth, the table of
// lights, the volumes. Writes: radiance; with `counts_pairs` the numbers of pairs instead.
// Program: volumes. Features: contact.

import package::view::{pixel_height_m, position_world_from_pixel};
import package::constants::DISTANCE_BACKGROUND_M;
import package::gbuffer::is_lit_deferred;
import package::shaders::gbuffer_textures::{surface_at, distance_at};
import package::shaders::lit_distance::facet_normal_at;
import package::shaders::shading::FLAT_LIKENESS_MIN;
import package::shaders::shaded_place::shading_at;
import package::shaders::lights::{counts_pairs, pair_counts};
import package::shaders::shadows::shadowed;
import package::shaders::contact::contact_origin;
import package::shaders::light_lists::single_light_sums;
import package::shaders::light_table::cluster_grid;
import package::shaders::colour::half_float_clamped;
import package::passes::volumes::volume_vertex::{VolumeVarying, volume_varying};

@vertex
fn vs_volumes(@location(0) corner: vec3f, @builtin(instance_index) instance: u32) -> VolumeVarying {
    return volume_varying(corner, instance);
}

@fragment
fn fs_volumes(in: VolumeVarying) -> @location(0) vec4f {
    let pixel = vec2i(in.position_clip.xy);
    let distance_m = distance_at(pixel);
    let surface = surface_at(pixel);
    if distance_m >= DISTANCE_BACKGROUND_M || !is_lit_deferred(surface) {
        return vec4f(0.0);
    }
    let position_world = position_world_from_pixel(in.position_clip.xy, distance_m);
    var shading = shading_at(surface, position_world);
    if shadowed != 0u {
        let leaves_out = cluster_grid.contact.z > 0.0;
        let facet = facet_normal_at(pixel, distance_m, surface.normal_world, leaves_out);
        shading.facet_normal = facet.xyz;
        shading.is_flat = facet.w > FLAT_LIKENESS_MIN;
        shading.lift_m = surface.lift_px * pixel_height_m(distance_m);
        shading.contact = contact_origin(in.position_clip.xy, distance_m, shading.facet_normal);
    }
    let sums = single_light_sums(in.light, position_world, shading);
    if counts_pairs != 0u {
        return pair_counts(sums);
    }
    return vec4f(half_float_clamped(sums.radiance), 0.0);
}
