// Which fragments a mask drops; whatever draws a surface asks here, so that all passes drop the same ones.
// Source of the hash: Wyman & McGuire 2017, "Hashed Alpha Testing": a hash of the place on the object, in cells of
// about a pixel's size, so that the pattern moves with the object. Where it differs: it takes over from the cutoff as
// texels become as small as pixels; and it is that of a still's first sample, from which variables come, while the
// others divide the range of thresholds evenly among them, pixel by pixel.

import package::view::view;
import package::shaders::hash::{mixed, seed_of_pixel, stratified, unit_from_bits};
import package::shaders::surface_material::{material_factors, material_uv, textured};
@if(textures || masks) import package::shaders::surface_material::{base_color_sampler, base_color_texture};
@if(relief) import package::shaders::surface_material::{material_uv_dx, material_uv_dy};
import package::shaders::surface_vertex::SurfaceVarying;

// 1 if masks are hashed at a distance.
override hashed_masks: u32 = 0u;
// 1 if a pixel has several samples, and alpha says how many of them are covered.
override alpha_to_coverage: u32 = 0u;
const SAMPLES: f32 = 4.0;

// What has no alpha is dropped.
const THRESHOLD_MIN: f32 = 1e-6;

// What is read of a texture is even as far as its finest texels differ from it by less than this, as a share of how far
// it is from 0 or 1; from twice as much on it is not.
const EVEN_SHARE: f32 = 0.25;
// Alpha that differs by less from pixel to pixel is even.
const WIDTH_MIN: f32 = 1e-4;

// How far the four finest texels around a place, each at its middle, are from what was read of the texture.
@if((textures || masks) && !points)
fn unlike_finest(uv: vec2f, size: vec2f, read: f32) -> f32 {
    let first = floor(uv * size) + 0.5;
    var farthest = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let place = (first + vec2f(f32(i & 1u), f32(i >> 1u))) / size;
        farthest = max(farthest, abs(textureSampleLevel(base_color_texture, base_color_sampler, place, 0.0).a - read));
    }
    return farthest;
}

// How far the hash has taken over: not at all where a texel is two pixels wide, and wholly where it is one, or what is
// read of the texture is coarser, and its alpha so much as of it is there. Alpha that is even, or rises slowly, says
// nothing of how much is there: the cutoff goes on to hold.
@if((textures || masks) && !points)
fn hashed_share(in: SurfaceVarying, bias: f32) -> f32 {
    let size = vec2f(textureDimensions(base_color_texture));
    let uv = material_uv(in.uv, 0u);
    @if(!relief) let read = textureSampleBias(base_color_texture, base_color_sampler, uv, bias).a;
    @if(relief) let read = textureSampleGrad(base_color_texture, base_color_sampler, uv,
        material_uv_dx(0u, bias), material_uv_dy(0u, bias)).a;
    let unlike = unlike_finest(uv, size, read) / max(min(read, 1.0 - read), 1e-4);
    let uneven = clamp(unlike / EVEN_SHARE - 1.0, 0.0, 1.0);
    @if(!relief) let texel = uv * size;
    @if(!relief) let across = dpdx(texel);
    @if(!relief) let down = dpdy(texel);
    // As large as it is on the triangle, as for what is read of the texture.
    @if(relief) let across = material_uv_dx(0u, 0.0) * size;
    @if(relief) let down = material_uv_dy(0u, 0.0) * size;
    let mip = 0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-30)) + bias;
    return clamp(mip + 1.0, 0.0, 1.0) * uneven;
}

@if((textures || masks) && !points)
fn cell_hash(cell: vec3f) -> u32 {
    // What no whole number of 32 bits holds is one cell.
    let corner = bitcast<vec3u>(vec3i(clamp(floor(cell), vec3f(-1e9), vec3f(1e9))));
    return mixed(corner.x ^ mixed(corner.y ^ mixed(corner.z + 0x9e3779b9u)));
}

// Evenly spread over 0 to 1, and the same as long as the place on the object and the size of a pixel there stay what
// they are.
@if((textures || masks) && !points)
fn hashed_threshold(in: SurfaceVarying) -> f32 {
    let place = in.position_object;
    let across = dpdx(place);
    let down = dpdy(place);
    let octave = -0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-30));
    // Cells of the two nearest powers of two, mixed.
    let coarse = cell_hash(place * exp2(floor(octave)));
    let fine = cell_hash(place * exp2(floor(octave) + 1.0));
    let share = fract(octave);
    let x = mix(unit_from_bits(coarse), unit_from_bits(fine), share);
    // The mean of two even distributions is none: its own makes it even again.
    let a = min(share, 1.0 - share);
    let slope = 0.5 / max(a * (1.0 - a), 1e-6);
    let middle = (x - 0.5 * a) / (1.0 - a);
    let even = select(select(1.0 - (1.0 - x) * (1.0 - x) * slope, middle, x < 1.0 - a), x * x * slope, x < a);
    return clamp(even, THRESHOLD_MIN, 1.0);
}

// The hash of a fragment in a sample of a still.
@if((textures || masks) && !points)
fn hash_of_sample(in: SurfaceVarying, sample_index: u32) -> f32 {
    let of_pixel = stratified(sample_index, seed_of_pixel(in.position_clip.xy, in.object));
    return select(hashed_threshold(in), max(of_pixel, THRESHOLD_MIN), sample_index > 0u);
}

// The alpha below which fragments are dropped in a sample of a still.
fn mask_threshold(in: SurfaceVarying, bias: f32, sample_index: u32) -> f32 {
    var threshold = material_factors.alpha_cutoff;
    @if((textures || masks) && !points) {
        if (hashed_masks & textured) != 0u {
            let share = hashed_share(in, bias) * (1.0 - material_factors.blended);
            threshold = mix(threshold, hash_of_sample(in, sample_index), share);
        }
    }
    return threshold;
}

// Whether a fragment is dropped that has this alpha, of a texture with this bias of mips.
fn is_masked_out(in: SurfaceVarying, alpha: f32, bias: f32) -> bool {
    return alpha < mask_threshold(in, bias, view.sample_index);
}

// The share of a pixel's samples that a fragment covers: all or none, or with `alpha_to_coverage` a whole number of
// them, so that rasterizers, which are free in what they make of other shares, cover the same number.
// Source: Golus 2017, "Anti-aliased Alpha Test: The Esoteric Alpha To Coverage": alpha rises from 0 to 1 across a pixel
// about the place where it is the cutoff. Where masks are hashed it is alpha itself at a distance, and chance, by the
// same hash as without samples, decides between the two nearest numbers.
fn mask_coverage(in: SurfaceVarying, alpha: f32, bias: f32) -> f32 {
    if alpha_to_coverage == 0u {
        return select(1.0, 0.0, is_masked_out(in, alpha, bias));
    }
    let cutoff = material_factors.alpha_cutoff;
    let width = fwidth(alpha);
    // Even alpha is on one side, also if it is the cutoff.
    let sharp = clamp((alpha - cutoff) / max(width, WIDTH_MIN) + 0.5, 0.0, 1.0);
    var share = select(sharp, select(0.0, 1.0, alpha >= cutoff), width <= WIDTH_MIN);
    var rounding = 0.5;
    @if((textures || masks) && !points) {
        if (hashed_masks & textured) != 0u {
            let far = hashed_share(in, bias);
            share = mix(share, clamp(alpha, 0.0, 1.0), far);
            rounding = mix(rounding, 1.0 - hash_of_sample(in, view.sample_index), far);
        }
    }
    return floor(share * SAMPLES + rounding) / SAMPLES;
}
