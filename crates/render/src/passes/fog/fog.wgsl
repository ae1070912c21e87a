// fog: distance fog over opaque surfaces. Blended ones have the same function where they are shaded.
// Reads: linear_depth. Writes: radiance, blended by the share that does not come through; coverage stays, and the mark
// of what glows (`shaders/glow.wgsl`) is covered as the glow is.
// Program: fog.

import package::view::position_world_from_pixel;
import package::shaders::fog::{fog, fog_transmittance};

@group(1) @binding(1) var linear_depth: texture_2d<f32>;

@fragment
fn fs_fog(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let distance_m = textureLoad(linear_depth, vec2i(position.xy), 0).r;
    let transmittance = fog_transmittance(position_world_from_pixel(position.xy, distance_m));
    return vec4f(fog.radiance * (1.0 - transmittance), 1.0 - transmittance);
}
