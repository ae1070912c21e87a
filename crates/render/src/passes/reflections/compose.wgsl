// reflections.compose: what the picture shows of a surface's reflection takes the place of the environment's, with the
// same shares of both.
// Reads: found_reflections, G-buffer, linear_depth, occlusion, the environment. Writes: the difference, to be added to
// radiance.
// Program: reflections_compose.

import package::view::{position_world_from_pixel, view};
import package::constants::{DISTANCE_BACKGROUND_M, RADIANCE_MAX};
import package::gbuffer::is_lit_deferred;
import package::shaders::ambient::{LEFT_SHARE, mirrored_environment};
import package::shaders::coarse_occlusion::seen_by_sample;
import package::shaders::coarse_reflections::reflected_at;
import package::shaders::drawn_tiles::tile_corner;
import package::shaders::colour::half_float_clamped;
import package::shaders::gbuffer_textures::{surface_at, distance_at, normal_world_at};
import package::shaders::shaded_place::shading_at;

@vertex
fn vs_reflections_compose(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
) -> @builtin(position) vec4f {
    return tile_corner(vertex, instance, view.size_px);
}

@fragment
fn fs_reflections_compose(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = distance_at(pixel);
    if distance_m >= DISTANCE_BACKGROUND_M {
        return vec4f(0.0);
    }
    let found = reflected_at(position.xy, distance_m, normal_world_at(pixel));
    let surface = surface_at(pixel);
    if found.a <= 0.0 || !is_lit_deferred(surface) {
        return vec4f(0.0);
    }
    let position_world = position_world_from_pixel(position.xy, distance_m);
    let shading = shading_at(surface, position_world);
    let seen = seen_by_sample(position.xy, distance_m, surface, shading);
    let mirrored = mirrored_environment(shading);
    let of_environment = mirrored.radiance * mirrored.albedo * (surface.occlusion * seen.specular);
    let taken = min(of_environment, vec3f(RADIANCE_MAX)) * (found.a * (1.0 - LEFT_SHARE));
    let added = half_float_clamped(found.rgb * mirrored.albedo * surface.occlusion);
    return vec4f(added - taken, 0.0);
}
