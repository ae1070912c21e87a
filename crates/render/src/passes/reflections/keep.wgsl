// reflections.keep: what samples of a still keep for those that follow them: how far away the surfaces are that texels
// are of; or with `averages` the mean of what was found of each pixel so far.
// Reads: found_reflections, previous_reflections, G-buffer, linear_depth. Writes: metres (r); or radiance and share.
// Program: reflections_keep.

import package::view::view;
import package::constants::DISTANCE_BACKGROUND_M;
import package::shaders::coarse::pixel_of_texel;
import package::shaders::coarse_reflections::{reflected_at, reflections_side};
import package::shaders::gbuffer_textures::{distance_at, normal_world_at};

@group(1) @binding(6) var previous_reflections: texture_2d<f32>;

override averages: u32 = 0u;

@fragment
fn fs_reflections_keep(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = vec2i(position.xy);
    if averages == 0u {
        return vec4f(distance_at(pixel_of_texel(texel, i32(reflections_side))), 0.0, 0.0, 0.0);
    }
    var mean = vec4f(0.0);
    if view.sample_index > 0u {
        mean = textureLoad(previous_reflections, texel, 0);
    }
    let distance_m = distance_at(texel);
    var found = vec4f(0.0);
    if distance_m < DISTANCE_BACKGROUND_M {
        found = reflected_at(position.xy, distance_m, normal_world_at(texel));
    }
    return mean + (found - mean) / f32(view.sample_index + 1u);
}
