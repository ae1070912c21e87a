// indirect: light from the environment, added to `radiance`.
// Source: split sum (Karis 2013) of the environment. Reads: G-buffer, linear_depth or depth, occlusion. Writes: radiance.
// Program: indirect.

import package::view::{view, position_world_from_pixel};
import package::constants::DISTANCE_BACKGROUND_M;
import package::gbuffer::is_lit_deferred;
import package::shaders::gbuffer_textures::surface_at;
import package::shaders::lit_distance::lit_distance_at;
import package::shaders::shaded_place::shading_at;
import package::shaders::ambient::ambient_radiance_seen;
import package::shaders::coarse_occlusion::seen_by_sample;
import package::shaders::coarse_reflections::reflected_at;
import package::shaders::colour::half_float_clamped;

@fragment
fn fs_indirect(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = lit_distance_at(pixel);
    let surface = surface_at(pixel);
    if distance_m >= DISTANCE_BACKGROUND_M || !is_lit_deferred(surface) {
        return vec4f(0.0);
    }
    let position_world = position_world_from_pixel(position.xy, distance_m);
    let shading = shading_at(surface, position_world);
    var seen = seen_by_sample(position.xy, distance_m, surface, shading);
    seen.reflected = reflected_at(position.xy, distance_m, surface.normal_world);
    return vec4f(half_float_clamped(ambient_radiance_seen(surface, shading, seen)), 0.0);
}
