// direct: every light that reaches a pixel, added to `radiance`; with `adds_ambient` that of the environment, too.
// Source: clustered shading (Olsson et al. 2012) with lists in data textures; with `tiled` the lists are those of
// tiles, and what lies before or behind all of the tile's surfaces is passed over; with `without_lists` only lights
// that are in none. Reads: G-buffer, linear_depth, the tables of lights and clusters, of tiles their bounds, occlusion,
// reflections that an earlier sample of a still found, and the environment. Writes: radiance; with `counts_pairs` the numbers of pairs instead.
// Program: direct. Features: contact. Axes: tiled.

import package::view::{view, pixel_height_m, position_world_from_pixel};
import package::constants::DISTANCE_BACKGROUND_M;
import package::gbuffer::is_lit_deferred;
import package::shaders::gbuffer_textures::surface_at;
import package::shaders::lit_distance::{facet_normal_at, lit_distance_at};
import package::shaders::shading::FLAT_LIKENESS_MIN;
import package::shaders::shaded_place::shading_at;
import package::shaders::ambient::ambient_radiance_seen;
import package::shaders::coarse_occlusion::seen_by_sample;
import package::shaders::coarse_reflections::reflected_at;
import package::shaders::contact::contact_origin;
import package::shaders::light_lists::light_sums;
import package::shaders::light_table::cluster_grid;
import package::shaders::lights::{counts_pairs, pair_counts};
import package::shaders::shadows::shadowed;
import package::shaders::colour::half_float_clamped;

// 1 if light of the environment is added here, where no pass of its own does it.
override adds_ambient: u32 = 0u;

@fragment
fn fs_direct(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = lit_distance_at(pixel);
    let surface = surface_at(pixel);
    if distance_m >= DISTANCE_BACKGROUND_M || !is_lit_deferred(surface) {
        return vec4f(0.0);
    }
    let position_world = position_world_from_pixel(position.xy, distance_m);
    var shading = shading_at(surface, position_world);
    if shadowed != 0u {
        let leaves_out = cluster_grid.contact.z > 0.0;
        let facet = facet_normal_at(pixel, distance_m, surface.normal_world, leaves_out);
        shading.facet_normal = facet.xyz;
        shading.is_flat = facet.w > FLAT_LIKENESS_MIN;
        shading.lift_m = surface.lift_px * pixel_height_m(distance_m);
        shading.contact = contact_origin(position.xy, distance_m, shading.facet_normal);
    }
    let sums = light_sums(position.xy, distance_m, position_world, shading);
    if counts_pairs != 0u {
        return pair_counts(sums);
    }
    var radiance = sums.radiance;
    if adds_ambient != 0u {
        var seen = seen_by_sample(position.xy, distance_m, surface, shading);
        seen.reflected = reflected_at(position.xy, distance_m, surface.normal_world);
        radiance += ambient_radiance_seen(surface, shading, seen);
    }
    return vec4f(half_float_clamped(radiance), 0.0);
}
