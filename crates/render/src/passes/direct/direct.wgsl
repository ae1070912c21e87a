// direct: every light that reaches a pixel, added to `radiance`.
// Source: clustered shading (Olsson et al. 2012) with lists in data textures. Reads: G-buffer, linear_depth, the tables
// of lights and clusters. Writes: radiance; with `counting` the numbers of pairs instead.
// Program: direct. Axes: counting, shadowed.

import package::view::{view, position_world_from_pixel, direction_to_eye_world};
import package::constants::DISTANCE_BACKGROUND_M;
import package::gbuffer::SHADING_MODEL_UNLIT;
import package::shaders::gbuffer_textures::{surface_at, distance_at, facet_normal_at};
import package::shaders::shading::shading_from_surface;
import package::shaders::lights::light_sums;
import package::shaders::colour::half_float_clamped;

@fragment
fn fs_direct(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = distance_at(pixel);
    let surface = surface_at(pixel);
    if distance_m >= DISTANCE_BACKGROUND_M || surface.shading_model == SHADING_MODEL_UNLIT {
        return vec4f(0.0);
    }
    let position_world = position_world_from_pixel(position.xy, distance_m);
    var shading = shading_from_surface(surface, direction_to_eye_world(position_world));
    @if(shadowed) {
        shading.facet_normal = facet_normal_at(pixel, distance_m, surface.normal_world);
    }
    let sums = light_sums(position.xy, distance_m, position_world, shading);
    @if(counting) {
        return vec4f(sums.visited, sums.shaded, sums.in_range, 1.0);
    }
    @if(!counting) {
        return vec4f(half_float_clamped(sums.radiance), 0.0);
    }
}
