// reflections.compose: what the picture shows of a surface's reflection takes the place of the environment's, with the
// same shares of both; of a smaller picture by `shaders/bilateral.wgsl`.
// Reads: found_reflections, G-buffer, linear_depth, occlusion, the environment. Writes: the difference, to be added to
// radiance.
// Program: reflections_compose.

import package::view::{position_world_from_pixel, direction_to_eye_world};
import package::constants::{DISTANCE_BACKGROUND_M, RADIANCE_MAX};
import package::gbuffer::is_lit_deferred;
import package::passes::reflections::rays::{LIKENESS_REACH, side};
import package::shaders::ambient::mirrored_environment;
import package::shaders::bilateral::upsampled;
import package::shaders::colour::half_float_clamped;
import package::shaders::gbuffer_textures::{surface_at, distance_at};
import package::shaders::occlusion::seen_at;
import package::shaders::screen_space::tangent_plane_at;
import package::shaders::shading::shading_from_surface;

@group(1) @binding(5) var found_reflections: texture_2d<f32>;

// Radiance is rounded to half floats: so much is left of what is taken away, that nothing is below 0.
const LEFT_SHARE: f32 = 0.002;

fn found_at(position_px: vec2f, pixel: vec2i, distance_m: f32) -> vec4f {
    if side == 1u {
        return textureLoad(found_reflections, pixel, 0);
    }
    let plane = tangent_plane_at(pixel, distance_m);
    return upsampled(found_reflections, position_px, side, 0.0, plane, LIKENESS_REACH * distance_m).value;
}

@fragment
fn fs_reflections_compose(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = distance_at(pixel);
    let surface = surface_at(pixel);
    if distance_m >= DISTANCE_BACKGROUND_M || !is_lit_deferred(surface) {
        return vec4f(0.0);
    }
    let found = found_at(position.xy, pixel, distance_m);
    let position_world = position_world_from_pixel(position.xy, distance_m);
    let shading = shading_from_surface(surface, direction_to_eye_world(position_world));
    let seen = seen_at(pixel, surface, shading);
    let mirrored = mirrored_environment(shading);
    let of_environment = mirrored.radiance * mirrored.albedo * (surface.occlusion * seen.specular);
    let taken = min(of_environment, vec3f(RADIANCE_MAX)) * (found.a * (1.0 - LEFT_SHARE));
    let added = half_float_clamped(found.rgb * mirrored.albedo * surface.occlusion);
    return vec4f(added - taken, 0.0);
}
