// meter: radiance in a format that every backend can read back; or, with `reduces`, how bright it is on the average, and
// with `adapts` what exposure comes to of that.
// Source of the average: Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images", eq. 1.
// Reads: radiance (pre-exposed, associated alpha), or what the pass wrote before; what the last frame left. Writes: meter
// (rgba32float, as radiance is); means over squares of 8 × 8 texels of the weighted binary logarithm of luminance (r) and
// of its weight (g); stops (r).
// Program: meter.

import package::constants::{METERED_SIDE, MID_GREY_LEVEL};
import package::shaders::scrub::scrubbed;

struct Meter {
    // The size of radiance.
    size_px: vec2f,
    // The standard deviation of weights around the middle, or the radius of the spot.
    radius_px: f32,
    // What radiance was multiplied by, as a power of 2.
    pre_exposure_stops: f32,
    // Between these is what comes out.
    stops_min: f32,
    stops_max: f32,
    // What is left of the difference from what is wanted, where the picture becomes darker, and where brighter.
    keep_to_light: f32,
    keep_to_dark: f32,
    // 1 if there is no frame before.
    begins: f32,
    // Zero.
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

@group(1) @binding(0) var radiance: texture_2d<f32>;
@group(1) @binding(1) var<uniform> meter: Meter;
// Looked at with `adapts` alone.
@group(1) @binding(2) var previous: texture_2d<f32>;

// 1 if luminance of radiance is averaged, 2 if what such a pass wrote is averaged again.
override reduces: u32 = 0u;
// 1 if the middle weighs more, 2 if nothing else does.
override pattern: u32 = 0u;
// 1 if it is the last average, of which exposure follows.
override adapts: u32 = 0u;

// How much a place counts.
fn weight_at(position_px: vec2f) -> f32 {
    let from_middle = (position_px - 0.5 * meter.size_px) / meter.radius_px;
    let distance_squared = dot(from_middle, from_middle);
    if pattern == 1u {
        return exp(-0.5 * distance_squared);
    }
    if pattern == 2u {
        return select(0.0, 1.0, distance_squared <= 1.0);
    }
    return 1.0;
}

// Weighted logarithm and weight of a texel. What is black, and what nothing covers, does not count.
fn metered_at(texel: vec2i) -> vec2f {
    let found = scrubbed(textureLoad(radiance, texel, 0));
    if reduces == 2u {
        return textureLoad(radiance, texel, 0).rg;
    }
    let luminance = dot(found.rgb, vec3f(0.2126, 0.7152, 0.0722)) / max(found.a, 1e-6);
    let weight = select(0.0, min(found.a, 1.0) * weight_at(vec2f(texel) + 0.5), luminance > 0.0);
    return vec2f(weight * log2(max(luminance, 1e-30)), weight);
}

fn mean_from(first: vec2i) -> vec2f {
    let size = vec2i(textureDimensions(radiance));
    var sum = vec2f(0.0);
    for (var y = 0; y < METERED_SIDE; y++) {
        for (var x = 0; x < METERED_SIDE; x++) {
            let texel = first + vec2i(x, y);
            sum += select(vec2f(0.0), metered_at(min(texel, size - 1)), all(texel < size));
        }
    }
    return sum / f32(METERED_SIDE * METERED_SIDE);
}

// The stops after this frame: where nothing counts, those before it.
fn adapted(mean: vec2f) -> f32 {
    let level = mean.x / max(mean.y, 1e-30) - MID_GREY_LEVEL - meter.pre_exposure_stops;
    let before = mix(textureLoad(previous, vec2i(0), 0).r, 0.0, meter.begins);
    let wanted = clamp(select(before, -level, mean.y > 0.0), meter.stops_min, meter.stops_max);
    let keep = select(meter.keep_to_dark, meter.keep_to_light, wanted < before);
    return clamp(wanted + (before - wanted) * keep, meter.stops_min, meter.stops_max);
}

@fragment
fn fs_meter(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = vec2i(position.xy);
    if reduces == 0u {
        return textureLoad(radiance, texel, 0);
    }
    let mean = mean_from(texel * METERED_SIDE);
    if adapts != 0u {
        return vec4f(adapted(mean), 0.0, 0.0, 1.0);
    }
    return vec4f(mean, 0.0, 1.0);
}
