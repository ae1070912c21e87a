// probe_capture.face: one side of what is to be seen around a probe, beside the others.
// Reads: view_radiance, linear_depth. Writes: radiance, and the distance along the ray in metres, -1 where nothing is.
// Program: probe_face.

import package::constants::DISTANCE_BACKGROUND_M;
import package::shaders::colour::half_float_clamped;

struct ProbeFace {
    // The first texel of the side; one divided by half its length in texels; the largest distance that counts.
    corner: vec4f,
}

@group(1) @binding(0) var view_radiance: texture_2d<f32>;
@group(1) @binding(1) var linear_depth: texture_2d<f32>;
@group(1) @binding(2) var<uniform> probe_face: ProbeFace;

@fragment
fn fs_probe_face(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = position.xy - probe_face.corner.xy;
    let radiance = half_float_clamped(textureLoad(view_radiance, vec2i(px), 0).rgb);
    let ahead_m = textureLoad(linear_depth, vec2i(px), 0).r;
    let place = px * probe_face.corner.z - 1.0;
    let distance_m = min(ahead_m * sqrt(1.0 + dot(place, place)), probe_face.corner.w);
    return vec4f(radiance, select(distance_m, -1.0, ahead_m >= DISTANCE_BACKGROUND_M));
}
