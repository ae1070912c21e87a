// reflections.filter: takes the pattern of noise of 4 × 4 texels out of a picture of few samples, by the mean over seven
// by seven texels with the weights 1, 2, 3, 4, 3, 2, 1 in each direction: each of the sixteen counts as much, and what a
// ray brings comes and goes evenly, without the edges of squares; of what lies on the same surface (Tomasi & Manduchi
// 1998, by the distance from the tangent plane). Near hits, whose lobe is as wide as few texels, count fewer of them.
// Mirrors have no noise and stay sharp, but for dots that nothing beside them agrees with: few hits among many misses,
// and hits that are brighter than white and than all beside them.
// reflections.sharpen: of a picture of half the size, puts what rays of each pixel brought in its place where surfaces are
// smooth, without such dots.
// Reads: noisy_reflections, found_reflections, G-buffer, linear_depth. Writes: reflections.
// Program: reflections_filter.

import package::constants::DISTANCE_BACKGROUND_M;
import package::passes::reflections::rays::{
    NARROW_STEPS, filtered_share, patterned, reflections, sharp_share, side, steps_narrower_of,
};
import package::shaders::bilateral::middle_of_texel;
import package::shaders::coarse::pixel_of_texel;
import package::shaders::drawn_tiles::tile_corner;
import package::shaders::coarse_reflections::{LIKENESS_REACH, reflected_at, reflections_side};
import package::shaders::gbuffer_textures::{distance_at, normal_world_at, surface_at};
import package::shaders::samplers::nearest_clamp;
import package::shaders::screen_space::{likeness_to, tangent_plane_at};
import package::shaders::traced_lobe::traced_roughness;

@group(1) @binding(5) var noisy_reflections: texture_2d<f32>;

// So many texels to each side count.
const REACH: i32 = 3;
// Half of a row at its widest: from there on nothing counts.
const WIDEST: f32 = 4.0;
// How much less texels count that are as bright as `radiance_max` (Karis 2013, "Tone Mapping").
const BRIGHT_WEIGHT: f32 = 0.1;

// What mirrors show of the picture where the share of texels beside a hit that hit as well is below the first is dots,
// of rays that graze what they meet; from the second on it is the edge of something.
const LONELY: f32 = 0.25;
const AGREED: f32 = 0.5;
// In a smaller picture each such dot is of several pixels: below the second share mirrors show the mean beside them, with
// the weights 1, 2, 1 in each direction.
const ALIKE_NONE: f32 = 0.75;
const ALIKE_ALL: f32 = 0.98;
// Dots there are what has so few hits around it, by the weights of seven texels in each direction: one alone is 1 / 16,
// four in a square are 3 / 16, and the edge of something is more than 3 / 8.
const DOTS: f32 = 0.08;
const NO_DOTS: f32 = 0.2;

// What a ray brought, and how far the filter reaches there.
struct Texel {
    found: vec4f,
    reach: f32,
}

fn texel_at(uv: vec2f) -> Texel {
    let packed = textureSampleLevel(noisy_reflections, nearest_clamp, uv, 0.0);
    let narrower = steps_narrower_of(packed.a);
    let reach = WIDEST - (WIDEST - 1.0) * narrower / NARROW_STEPS;
    return Texel(vec4f(packed.rgb, packed.a - narrower), reach);
}

@vertex
fn vs_reflections_filter(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
) -> @builtin(position) vec4f {
    return tile_corner(vertex, instance, vec2f(textureDimensions(noisy_reflections)));
}

@fragment
fn fs_reflections_filter(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = pixel_of_texel(vec2i(position.xy), i32(side));
    let distance_m = distance_at(pixel);
    let size = vec2f(textureDimensions(noisy_reflections));
    let texel_size = 1.0 / size;
    let own_texel = texel_at(position.xy * texel_size);
    let own = own_texel.found;
    if distance_m >= DISTANCE_BACKGROUND_M {
        return own;
    }
    let roughness = traced_roughness(surface_at(pixel));
    // What there is of a smaller picture where this is of smooth surfaces.
    let normal_world = normal_world_at(pixel);
    let coarse = reflected_at(position.xy, distance_m, normal_world);
    let sharp = select(1.0, sharp_share(pixel, normal_world, roughness), reflections_side != 0u);
    if sharp <= 0.0 {
        return coarse;
    }
    // Over a smaller picture, a ray that brings nothing is shown as such, whatever is beside it.
    if patterned == 0u || (reflections_side != 0u && own.a <= 0.0) {
        return mix(coarse, own, sharp);
    }
    let rough = select(filtered_share(roughness), 0.0, reflections_side != 0u);
    // Smooth surfaces need the nine texels beside alone.
    let reach = select(REACH, 1, reflections_side != 0u);
    let plane = tangent_plane_at(pixel, distance_m);
    var sum = vec4f(0.0);
    var weights = 0.0;
    // How many of all texels hit, and how many of the nine beside.
    var around = vec2f(0.0);
    var beside = vec2f(0.0);
    // Of the nine the brightest, the others, and how bright the brightest of these is.
    var first = vec4f(0.0);
    var others = vec4f(0.0);
    var others_weight = 0.0;
    var first_brightness = 0.0;
    var second_brightness = 0.0;
    var most_trusted = 0.0;
    let across = u32(2 * reach + 1);
    for (var y = 0u; y < across; y++) {
        for (var x = 0u; x < across; x++) {
            let step = vec2f(vec2u(x, y)) - f32(reach);
            let middle = position.xy + step;
            let is_inside = all(middle > vec2f(0.0)) && all(middle < size);
            let middle_px = middle_of_texel(max(middle - 0.5, vec2f(0.0)), side);
            let likeness = likeness_to(plane, middle_px, LIKENESS_REACH * distance_m);
            let tent = vec2f(1.0) - abs(step) / WIDEST;
            let is_own = all(step == vec2f(0.0));
            let like = select(select(0.0, likeness, is_inside), 1.0, is_own);
            let evenly = like * tent.x * tent.y;
            let other = texel_at(middle * texel_size);
            let texel = other.found;
            let brightest = max(texel.r, max(texel.g, texel.b));
            // Two texels share light only within the smaller of their reaches. All weights of a reach add up to its square:
            // divided by that, light that one texel gives is what another gets.
            let shared_reach = min(own_texel.reach, other.reach);
            let narrow = max(vec2f(1.0) - abs(step) / shared_reach, vec2f(0.0));
            let whole = select(like * narrow.x * narrow.y * rough, 1.0, is_own) / (shared_reach * shared_reach);
            let weight = whole / (1.0 + BRIGHT_WEIGHT * brightest / reflections.radiance_max);
            sum += texel * weight;
            weights += weight;
            around += vec2f(texel.a, 1.0) * evenly;
            let near = max(vec2f(2.0) - abs(step), vec2f(0.0));
            let is_beside = near.x * near.y > 0.0;
            beside += vec2f(texel.a, 1.0) * select(0.0, like, is_beside);
            let counts = like * near.x * near.y;
            let brightness = select(0.0, brightest, counts > 0.0);
            let is_first = brightness > first_brightness;
            others += select(texel * counts, first, is_first);
            first = select(first, texel * counts, is_first);
            others_weight += counts;
            second_brightness = max(second_brightness, min(brightness, first_brightness));
            first_brightness = max(first_brightness, brightness);
            most_trusted = max(most_trusted, select(0.0, texel.a, counts > 0.0));
        }
    }
    // What is cut of a hit leaves as much of the environment's light.
    let brightness_max = max(reflections.radiance_max, second_brightness);
    let mean_beside = (others + first * min(brightness_max / max(first_brightness, 1e-6), 1.0)) / others_weight;
    let own_brightness = max(own.r, max(own.g, own.b));
    let own_cut = own * min(brightness_max / max(own_brightness, 1e-6), 1.0);
    let agreed = select(0.0, beside.x / beside.y / max(own.a, 1e-6), own.a > 1e-3);
    let of_pixels = own_cut * smoothstep(LONELY, AGREED, agreed);
    let of_something = smoothstep(DOTS, NO_DOTS, around.x / around.y / max(most_trusted, 1e-3));
    let of_several_pixels = mix(mean_beside, own_cut, smoothstep(ALIKE_NONE, ALIKE_ALL, agreed)) * of_something;
    let mirrored = select(of_pixels, of_several_pixels, side > 1u);
    return mix(coarse, mix(mirrored, sum / weights, rough), sharp);
}
