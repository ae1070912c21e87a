// tone_map: from the mean over the samples to the picture: tone curve (unless the samples have it already), background
// colour, sRGB, dithering.
// Source of the noise: Jimenez 2014. Reads: the mean (associated alpha; negative alpha marks clamped pixels). Writes:
// display colour, unassociated alpha; opaque over a background colour.
// Program: tone_map. Axes: curve_0, curve_1, curve_2, over_color.

import package::shaders::colour::srgb_from_linear;
import package::shaders::tone_curve::display_linear;

struct ToneMap {
    // The background colour in linear light.
    background_linear: vec3f,
    // Amplitude of the dither in steps of 1/255.
    dither: f32,
    // The background colour as it shall come out.
    background_srgb: vec3f,
    // Multiplies radiance; 1 where the samples went through the curve already.
    exposure: f32,
}

@group(1) @binding(0) var<uniform> tone_map: ToneMap;
@group(1) @binding(1) var radiance: texture_2d<f32>;

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
    let texel = textureLoad(radiance, vec2i(position.xy), 0);
    let coverage = abs(texel.a);
    let color = display_linear(texel.rgb / max(coverage, 1e-6) * tone_map.exposure);
    @if(over_color) {
        // Alpha in steps of 1/255, and so much less dither: the same as the transparent picture laid over the colour.
        let alpha = round(min(coverage, 1.0) * 255.0) / 255.0;
        let over = mix(tone_map.background_linear, color, alpha);
        let display = encoded(over, position.xy, tone_map.dither * alpha);
        return vec4f(select(display, tone_map.background_srgb, alpha == 0.0), 1.0);
    }
    @if(!over_color) {
        return vec4f(encoded(color, position.xy, tone_map.dither), min(coverage, 1.0));
    }
}
