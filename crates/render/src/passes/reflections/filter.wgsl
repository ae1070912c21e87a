// reflections.filter: takes the pattern of noise of 4 × 4 texels out of a picture of few samples, by the mean over five
// by five texels, of which the outer ones count half, so that each of the sixteen counts as much; of what lies on the
// same surface (Tomasi & Manduchi 1998, by the distance from the tangent plane). Mirrors have no noise and stay sharp.
// Reads: noisy_reflections, G-buffer, linear_depth. Writes: reflections.
// Program: reflections_filter.

import package::constants::DISTANCE_BACKGROUND_M;
import package::passes::reflections::rays::{LIKENESS_REACH, reflections, side};
import package::shaders::bilateral::middle_of_texel;
import package::shaders::coarse::pixel_of_texel;
import package::shaders::gbuffer_textures::{distance_at, surface_at};
import package::shaders::screen_space::{likeness_to, nearest_clamp, tangent_plane_at};

@group(1) @binding(5) var noisy_reflections: texture_2d<f32>;

// Surfaces of this roughness are filtered whole, and smoother ones less.
const FILTERED_ROUGHNESS: f32 = 0.1;
// How much less texels count that are as bright as `radiance_max` (Karis 2013, "Tone Mapping").
const BRIGHT_WEIGHT: f32 = 0.25;

@fragment
fn fs_reflections_filter(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = pixel_of_texel(vec2i(position.xy), i32(side));
    let distance_m = distance_at(pixel);
    let size = vec2f(textureDimensions(noisy_reflections));
    let texel_size = 1.0 / size;
    let rough = smoothstep(0.0, FILTERED_ROUGHNESS, surface_at(pixel).roughness_perceptual);
    if distance_m >= DISTANCE_BACKGROUND_M || rough <= 0.0 {
        return textureSampleLevel(noisy_reflections, nearest_clamp, position.xy * texel_size, 0.0);
    }
    let plane = tangent_plane_at(pixel, distance_m);
    var sum = vec4f(0.0);
    var weights = 0.0;
    for (var y = -2; y < 3; y++) {
        for (var x = -2; x < 3; x++) {
            let step = vec2f(vec2i(x, y));
            let middle = position.xy + step;
            let is_inside = all(middle > vec2f(0.0)) && all(middle < size);
            let middle_px = middle_of_texel(max(middle - 0.5, vec2f(0.0)), side);
            let likeness = likeness_to(plane, middle_px, LIKENESS_REACH * distance_m);
            let halves = select(vec2f(1.0), vec2f(0.5), abs(step) > vec2f(1.5));
            let is_own = x == 0 && y == 0;
            let others = select(0.0, likeness * halves.x * halves.y * rough, is_inside);
            let whole = select(others, 1.0, is_own);
            let texel = textureSampleLevel(noisy_reflections, nearest_clamp, middle * texel_size, 0.0);
            let brightest = max(texel.r, max(texel.g, texel.b));
            let weight = whole / (1.0 + BRIGHT_WEIGHT * brightest / reflections.radiance_max);
            sum += texel * weight;
            weights += weight;
        }
    }
    return sum / weights;
}
