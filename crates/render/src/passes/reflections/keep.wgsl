// reflections.mean: what samples of a still keep for those that follow them: the mean of what was found of each pixel.
// reflections.upsample: what was found of each pixel, for surfaces that are shaded where they are drawn.
// Reads: found_reflections, previous_reflections, G-buffer, linear_depth. Writes: radiance and share.
// Program: reflections_keep.

import package::view::view;
import package::constants::DISTANCE_BACKGROUND_M;
import package::shaders::coarse_reflections::reflected_at;
import package::shaders::gbuffer_textures::{distance_at, normal_world_at};

@group(1) @binding(6) var previous_reflections: texture_2d<f32>;

// 1 if it is the mean of this sample and of those before it.
override takes_mean: u32 = 1u;

@fragment
fn fs_reflections_keep(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = distance_at(pixel);
    var found = vec4f(0.0);
    if distance_m < DISTANCE_BACKGROUND_M {
        found = reflected_at(position.xy, distance_m, normal_world_at(pixel));
    }
    if takes_mean == 0u {
        return found;
    }
    var mean = vec4f(0.0);
    // Depends on more than uniforms, see docs/decisions/006.
    if (view.sample_index > 0u) & (position.x > -1.0) {
        mean = textureLoad(previous_reflections, pixel, 0);
    }
    return mean + (found - mean) / f32(view.sample_index + 1u);
}
