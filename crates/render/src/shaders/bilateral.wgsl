// What was found at a smaller size, or with noise, as the mean of texels by which of them lie on the same surface: near
// the tangent plane.

import package::view::view;
import package::shaders::coarse::turn_in_square;
import package::shaders::hash::plastic_turn;
import package::shaders::samplers::nearest_clamp;
import package::shaders::screen_space::{TangentPlane, likeness_of_distance, likeness_to};

// Where all of the texels lie on other surfaces, something must count.
const LIKENESS_MIN: f32 = 1e-4;
// A texel that is as like as that is looked no further for.
const LIKENESS_ENOUGH: f32 = 0.5;

// The middle of the pixel that a texel is of, where texels have so many pixels along a side.
fn middle_of_texel(texel: vec2f, side: u32) -> vec2f {
    return min(texel * f32(side) + vec2f(turn_in_square(i32(side))) + 0.5, view.size_px - 0.5);
}

// How much a texel of a value is of the same surface.
fn likeness_of_texel(value: vec4f, has_distances: bool, middle_px: vec2f, plane: TangentPlane, reach_m: f32) -> f32 {
    if has_distances {
        return likeness_of_distance(plane, middle_px, value.g, reach_m);
    }
    return likeness_to(plane, middle_px, reach_m);
}

struct Upsampled {
    value: vec4f,
    // From 0 to 1, how much of it is the same surface's.
    trust: f32,
}

// At a place of the picture, the four nearest texels of a smaller one, by how near they lie and by which of them lie on
// the same surface, of which others are off by `reach_m` and more (Kopf et al. 2007, "Joint Bilateral Upsampling", by
// the distance from the tangent plane). `shift` is by how much of a texel's side the smaller picture is moved. With
// `has_distances` it says itself how far away surfaces are, in its second channel.
fn upsampled(
    coarse: texture_2d<f32>,
    has_distances: bool,
    position_px: vec2f,
    side: u32,
    shift: f32,
    plane: TangentPlane,
    reach_m: f32,
) -> Upsampled {
    let first_middle = vec2f(turn_in_square(i32(side))) + 0.5;
    let place = (position_px - first_middle) / f32(max(side, 1u)) + shift;
    let first = floor(place);
    let between = place - first;
    let size = vec2f(textureDimensions(coarse));
    let texel_size = 1.0 / size;
    var sum = vec4f(0.0);
    var weights = 0.0;
    var trust = 0.0;
    for (var y = 0; y < 2; y++) {
        for (var x = 0; x < 2; x++) {
            let step = vec2f(vec2i(x, y));
            let texel = clamp(first + step, vec2f(0.0), size - 1.0);
            let near = mix(1.0 - between, between, step);
            let value = textureSampleLevel(coarse, nearest_clamp, (texel + 0.5) * texel_size, 0.0);
            let likeness = likeness_of_texel(value, has_distances, middle_of_texel(texel, side), plane, reach_m);
            let weight = (near.x * near.y + LIKENESS_MIN) * (likeness + LIKENESS_MIN);
            sum += value * weight;
            weights += weight;
            trust += near.x * near.y * likeness;
        }
    }
    return Upsampled(sum / weights, clamp(trust, 0.0, 1.0));
}

// 1 in the samples that follow the one which found it.
override takes_one_texel: u32 = 0u;

// As `upsampled`, of a smaller picture that the first sample of a still leaves, of the first pixel of each texel's square.
// Its second channel says how far away surfaces were. Samples that follow take one of the four texels: each is the one in
// as many samples as it has weight, those that look at the side of the pixel where it lies, so that their mean is the same
// (Pharr et al. 2024, "Filtering After Shading With Stochastic Texture Filtering"); where it lies on another surface, the
// one across from it may be the one.
fn upsampled_by_distances(
    coarse: texture_2d<f32>,
    position_px: vec2f,
    side: u32,
    shift: f32,
    plane: TangentPlane,
    reach_m: f32,
) -> Upsampled {
    let place = (position_px - 0.5) / f32(max(side, 1u)) + shift;
    let corner = floor(place);
    if takes_one_texel != 0u {
        let turn = fract(plastic_turn(view.sample_index) + 0.5);
        let chosen = floor(place + turn);
        let first = texel_at(coarse, chosen, side, plane, reach_m);
        let across = 2.0 * corner + 1.0 - chosen;
        let other = texel_at(coarse, across, side, plane, reach_m);
        let is_first = first.trust >= min(other.trust, LIKENESS_ENOUGH);
        return Upsampled(select(other.value, first.value, is_first), select(other.trust, first.trust, is_first));
    }
    let between = place - corner;
    var sum = vec4f(0.0);
    var weights = 0.0;
    var trust = 0.0;
    for (var y = 0; y < 2; y++) {
        for (var x = 0; x < 2; x++) {
            let step = vec2f(vec2i(x, y));
            let texel = texel_at(coarse, corner + step, side, plane, reach_m);
            let near = mix(1.0 - between, between, step);
            let weight = (near.x * near.y + LIKENESS_MIN) * (texel.trust + LIKENESS_MIN);
            sum += texel.value * weight;
            weights += weight;
            trust += near.x * near.y * texel.trust;
        }
    }
    return Upsampled(sum / weights, clamp(trust, 0.0, 1.0));
}

// One texel of it, and how much it is of the same surface.
fn texel_at(
    coarse: texture_2d<f32>,
    index: vec2f,
    side: u32,
    plane: TangentPlane,
    reach_m: f32,
) -> Upsampled {
    let size = vec2f(textureDimensions(coarse));
    let texel = clamp(index, vec2f(0.0), size - 1.0);
    let uv = (texel + 0.5) / size;
    let value = textureSampleLevel(coarse, nearest_clamp, uv, 0.0);
    let middle_px = min(texel * f32(side) + 0.5, view.size_px - 0.5);
    return Upsampled(value, likeness_of_distance(plane, middle_px, value.g, reach_m));
}

// The mean over 4 × 4 texels, from 2 before a texel's middle to 1 after, of those that lie on the same surface (Tomasi
// & Manduchi 1998, "Bilateral Filtering", by the distance from the tangent plane in place of one of colours).
// `has_distances` is as for `upsampled`.
fn mean_of_square(
    noisy: texture_2d<f32>,
    has_distances: bool,
    middle: vec2f,
    side: u32,
    plane: TangentPlane,
    reach_m: f32,
) -> vec4f {
    let size = vec2f(textureDimensions(noisy));
    let texel_size = 1.0 / size;
    // The texel itself counts in any case.
    var sum = textureSampleLevel(noisy, nearest_clamp, middle * texel_size, 0.0) * 1e-3;
    var weights = 1e-3;
    for (var y = -2; y < 2; y++) {
        for (var x = -2; x < 2; x++) {
            let other = middle + vec2f(vec2i(x, y));
            let inside = all(other > vec2f(0.0)) && all(other < size);
            let value = textureSampleLevel(noisy, nearest_clamp, other * texel_size, 0.0);
            let middle_px = middle_of_texel(max(other - 0.5, vec2f(0.0)), side);
            let likeness = likeness_of_texel(value, has_distances, middle_px, plane, reach_m);
            let weight = select(0.0, likeness, inside);
            sum += value * weight;
            weights += weight;
        }
    }
    return sum / weights;
}
