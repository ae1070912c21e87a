// gi.compose: what surfaces reflect diffusely of the light that was found, by the same shares as of the environment's;
// of a smaller picture by `shaders/bilateral.wgsl`. With `takes_environment` it takes the place of the environment's
// light from the same directions, which nothing else has taken away.
// With `only_found` it is drawn as gi.upsample: what was found of each pixel, for surfaces that are shaded where they
// are drawn.
// Reads: found_light, G-buffer, linear_depth, the environment. Writes: the difference, to be added to radiance; or
// light.
// Program: gi_compose.

import package::view::position_world_from_pixel;
import package::constants::{DISTANCE_BACKGROUND_M, RADIANCE_MAX};
import package::gbuffer::{diffuse_environment_share, is_lit_deferred};
import package::passes::gi::gathered::{LIKENESS_REACH, patterned, side};
import package::shaders::ambient::{LEFT_SHARE, mirrored_albedo};
import package::shaders::bilateral::upsampled;
import package::shaders::brdf::PI;
import package::shaders::colour::half_float_clamped;
import package::shaders::environment::environment_irradiance;
import package::shaders::gbuffer_textures::{surface_at, distance_at};
import package::shaders::screen_space::tangent_plane_at;
import package::shaders::shaded_place::shading_at;

@group(1) @binding(5) var found_light: texture_2d<f32>;

// 1 if no occlusion takes the environment's light away.
override takes_environment: u32 = 0u;
override only_found: u32 = 0u;

fn found_at(position_px: vec2f, pixel: vec2i, distance_m: f32) -> vec4f {
    if side == 1u && patterned == 0u {
        return textureLoad(found_light, pixel, 0);
    }
    let plane = tangent_plane_at(pixel, distance_m);
    // A filtered texel is the mean of a square whose middle lies half a texel before its own.
    let shift = select(0.0, 0.5, patterned != 0u);
    return upsampled(found_light, false, position_px, side, shift, plane, LIKENESS_REACH * distance_m).value;
}

@fragment
fn fs_gi_compose(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = distance_at(pixel);
    if distance_m >= DISTANCE_BACKGROUND_M {
        return vec4f(0.0);
    }
    let found = found_at(position.xy, pixel, distance_m);
    if only_found != 0u {
        return found;
    }
    let surface = surface_at(pixel);
    if !is_lit_deferred(surface) {
        return vec4f(0.0);
    }
    let position_world = position_world_from_pixel(position.xy, distance_m);
    let shading = shading_at(surface, position_world);
    let share = diffuse_environment_share(surface) * surface.occlusion;
    let reflected = shading.albedo * (1.0 - mirrored_albedo(shading)) * share;
    var taken = vec3f(0.0);
    if takes_environment != 0u {
        let of_environment = environment_irradiance(shading.normal) * (1.0 / PI) * reflected;
        taken = min(of_environment, vec3f(RADIANCE_MAX)) * (clamp(found.a, 0.0, 1.0) * (1.0 - LEFT_SHARE));
    }
    return vec4f(half_float_clamped(max(found.rgb, vec3f(0.0)) * reflected) - taken, 0.0);
}
