// tone_map: from the mean over the samples, or from the only one, to the picture: tone curve (unless the samples have
// it already), background colour, sRGB, dithering. Source of the noise: Jimenez 2014. Reads: the mean (associated
// alpha; negative alpha marks clamped pixels) or the frame's radiance, which is filtered linearly where it was shaded
// at another size than the picture's (`scaled`). Writes: display colour, unassociated alpha; opaque over a background
// colour. With `has_glow` there is a mean of display colours beside the mean of radiance, each of its own part of every
// sample. Where effects on display colours follow it is drawn twice: before them without sRGB and dithering, after them
// for these alone.
// Program: tone_map.

import package::shaders::colour::{linear_from_srgb, srgb_from_linear};
import package::shaders::scrub::scrubbed;
import package::shaders::tone_curve::display_linear;

struct ToneMap {
    // The background colour in linear light, if it is one.
    background_linear: vec3f,
    // Amplitude of the dither in steps of 1/255.
    dither: f32,
    // The background colour at the upper edge of the picture as it shall come out.
    background_srgb: vec3f,
    // Multiplies radiance; 1 where the samples went through the curve already.
    exposure: f32,
    // 1 / width and height of the picture.
    inverse_size_px: vec2f,
    // How much of an alpha below 0 counts, turned positive: 1 in a mean, whose sign is a mark; 0 in radiance.
    negative_alpha: f32,
    // 1 if the background goes from one colour to another, else 0.
    is_gradient: f32,
    // What is to be added to the background colour down to the lower edge.
    background_step_srgb: vec3f,
    // Zero.
    padding: f32,
}

@group(1) @binding(0) var<uniform> tone_map: ToneMap;
@group(1) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var linear_clamp: sampler;
// Looked at with `has_glow` alone.
@group(1) @binding(2) var glow: texture_2d<f32>;
// Radiance again, looked at with `scaled` alone: not every format of means can be filtered.
@group(1) @binding(3) var filtered: texture_2d<f32>;

// Stops of an exposure that adapts, in one texel; looked at with `adapts` alone.
@group(1) @binding(4) var adapted: texture_2d<f32>;

// What comes through glass of the background beside what alpha says, by channel, plus 1; looked at with `has_tint` alone.
@group(1) @binding(5) var tint: texture_2d<f32>;

// 1 if there is glass before a background that is none of radiance.
override has_tint: u32 = 0u;
// 1 if the picture comes over a background colour.
override over_color: u32 = 0u;
// 1 if radiance has another size than the picture.
override scaled: u32 = 0u;
// 1 if there is a mean of display colours as well.
override has_glow: u32 = 0u;
// 1 if exposure goes on from frame to frame.
override adapts: u32 = 0u;
// 0 if colours stay linear, multiplied by alpha, because effects go on with them.
override encodes: u32 = 1u;

fn radiance_at(position_px: vec2f) -> vec4f {
    if scaled != 0u {
        return textureSampleLevel(filtered, linear_clamp, position_px * tone_map.inverse_size_px, 0.0);
    }
    return textureLoad(radiance, vec2i(position_px), 0);
}

// What radiance is multiplied by.
fn exposure() -> f32 {
    if adapts != 0u {
        return tone_map.exposure * exp2(textureLoad(adapted, vec2i(0), 0).r);
    }
    return tone_map.exposure;
}

// It may be of another size than the picture, and not every format of means can be filtered.
fn tint_at(position_px: vec2f) -> vec3f {
    let size = vec2i(textureDimensions(tint));
    let place = position_px * tone_map.inverse_size_px * vec2f(size) - 0.5;
    let first = vec2i(floor(place + 1e-3));
    let between = clamp(place - vec2f(first), vec2f(0.0), vec2f(1.0));
    var sum = vec3f(0.0);
    for (var i = 0; i < 4; i++) {
        let step = vec2i(i & 1, i >> 1u);
        let near = select(1.0 - between, between, step == vec2i(1));
        sum += textureLoad(tint, clamp(first + step, vec2i(0), size - 1), 0).rgb * (near.x * near.y);
    }
    // What rounding leaves of nothing is nothing.
    return select(sum - 1.0, vec3f(0.0), abs(sum - 1.0) < vec3f(1e-4));
}

// Interleaved gradient noise (Jimenez 2014): the same for the same pixel on every run.
fn dither_noise(pixel: vec2f) -> f32 {
    return fract(52.9829189 * fract(dot(pixel, vec2f(0.06711056, 0.00583715))));
}

// Encodes and dithers; black and white stay as they are.
fn encoded(color_linear: vec3f, position_px: vec2f, amplitude: f32) -> vec3f {
    let display = srgb_from_linear(color_linear);
    let noise = (dither_noise(floor(position_px)) - 0.5) * amplitude / 255.0;
    let is_between = (display > vec3f(0.0)) & (display < vec3f(1.0));
    return select(display, clamp(display + noise, vec3f(0.0), vec3f(1.0)), is_between);
}

@fragment
fn fs_tone_map(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let found = radiance_at(position.xy);
    let alpha = max(found.a, 0.0) - tone_map.negative_alpha * min(found.a, 0.0);
    let texel = scrubbed(vec4f(found.rgb, alpha));
    var coverage = texel.a;
    var color = display_linear(texel.rgb / max(texel.a, 1e-6) * exposure());
    if has_glow != 0u {
        let beside = textureLoad(glow, vec2i(position.xy), 0);
        coverage += beside.a;
        color = min((color * texel.a + beside.rgb) / max(coverage, 1e-6), vec3f(1.0));
    }
    var beyond_alpha = vec3f(0.0);
    if has_tint != 0u {
        beyond_alpha = tint_at(position.xy);
    }
    if over_color != 0u {
        // Alpha in steps of 1/255, and so much less dither: the same as the transparent picture laid over the colour.
        let alpha = round(min(coverage, 1.0) * 255.0) / 255.0;
        let place = position.y * tone_map.inverse_size_px.y;
        let behind_srgb = tone_map.background_srgb + tone_map.background_step_srgb * place;
        let behind = mix(tone_map.background_linear, linear_from_srgb(behind_srgb), tone_map.is_gradient);
        var over = mix(behind, color, alpha);
        if has_tint != 0u {
            over = clamp(over + behind * beyond_alpha, vec3f(0.0), vec3f(1.0));
        }
        if encodes == 0u {
            return vec4f(over, 1.0);
        }
        let display = encoded(over, position.xy, tone_map.dither * alpha);
        // Steps of a gradient are wider than pixels.
        let noise = (dither_noise(floor(position.xy)) - 0.5) * tone_map.dither * tone_map.is_gradient / 255.0;
        return vec4f(select(display, behind_srgb + noise, (alpha == 0.0) & all(beyond_alpha == vec3f(0.0))), 1.0);
    }
    if has_tint != 0u {
        // Alpha lets through what channels do on average, and the picture is right over white, as far as it can be.
        let mean = dot(beyond_alpha, vec3f(1.0 / 3.0));
        let left = clamp(min(coverage, 1.0) - mean, 0.0, 1.0);
        let own = max(color * min(coverage, 1.0) + beyond_alpha - mean, vec3f(0.0));
        if any(beyond_alpha != vec3f(0.0)) {
            color = min(own / max(left, 1e-6), vec3f(1.0));
            coverage = left;
        }
    }
    if encodes == 0u {
        return vec4f(color, 1.0) * min(coverage, 1.0);
    }
    return vec4f(encoded(color, position.xy, tone_map.dither), min(coverage, 1.0));
}
