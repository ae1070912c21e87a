// water.within: what the water takes of the light of what is in it, and what it scatters, where the eye is in the water, too.
// Source: Beer-Lambert, as in `water.wgsl`, whose surface has that itself where it is seen from below.
// Reads: linear_depth before and after the surface was drawn, the tables of lights, clusters and shadows, the environment.
// Writes: what radiance is multiplied by, or with `adds` what is added to it.
// Program: water_within.

import package::view::{view, position_view_from_pixel};
import package::gbuffer::{SHADING_MODEL_STANDARD, Surface};
import package::passes::water::uniform::{LETS_IN, water};
import package::shaders::brdf::PI;
import package::shaders::colour::half_float_clamped;
import package::shaders::environment::{enter_surroundings, environment_irradiance};
import package::shaders::gbuffer_textures::distance_at;
import package::shaders::light_lists::light_sums;
import package::shaders::screen_space::FARTHEST_M;
import package::shaders::shading::shading_from_surface;

@group(1) @binding(10) var surface_depth: texture_2d<f32>;

// 1 if what is scattered is added; else light is taken.
override adds: u32 = 0u;

// Nearer than this to the eye there is no cluster of lights.
const NEAR_M: f32 = 0.05;

@fragment
fn fs_water_within(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = min(distance_at(pixel), FARTHEST_M);
    // The surface is before what is there: it has all of this.
    let is_surface = textureLoad(surface_depth, pixel, 0).r < distance_m * 0.99999;
    let there = position_view_from_pixel(position.xy, distance_m);
    let way_m = min(mix(length(there), distance_m, view.orthographic), 1e6);
    let lost_per_m = water.absorption_per_m + water.scattering_per_m;
    let comes = select(exp(-lost_per_m * way_m), vec3f(1.0), is_surface);
    if adds == 0u {
        return vec4f(comes, 1.0);
    }
    let up = water.normal.xyz;
    let eye_world = view.world_from_view[3].xyz;
    enter_surroundings(eye_world);
    var surface: Surface;
    surface.base_color = vec3f(1.0);
    surface.occlusion = 1.0;
    surface.normal_world = up;
    surface.roughness_perceptual = 1.0;
    surface.f0_dielectric = 0.0;
    surface.shading_model = SHADING_MODEL_STANDARD;
    let shading = shading_from_surface(surface, up);
    // How long loops are depends on more than uniforms, see docs/decisions/006.
    let middle_px = select(vec2f(0.0), 0.5 * view.size_px, position.x > -1.0);
    let sums = light_sums(middle_px, NEAR_M, eye_world, shading);
    let light = sums.radiance + environment_irradiance(up) * (LETS_IN / PI);
    let deep_m = max(water.normal.w - dot(up, eye_world), 0.0);
    let scattered = 0.5 * light * exp(-lost_per_m * deep_m) * water.scattering_per_m / max(lost_per_m, vec3f(1e-9));
    return vec4f(half_float_clamped(scattered * (1.0 - comes)), 0.0);
}
