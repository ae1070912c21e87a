// Colours as they are averaged and filtered in linear light: radiance whose brightness is compressed by a curve that is
// straight up to 0.76 of white, as the default tone curve is, so that what is made of several is nearly that of display
// colours, and what is far brighter than the display does not outweigh all that lies beside it.
// Source: Karis 2013, "Tone mapping", of weights by brightness; the curve is that of Khronos PBR Neutral.

import package::constants::HALF_FLOAT_MAX;
import package::shaders::scrub::scrubbed;

// Where the curve of compression bends, as Khronos PBR Neutral does, and what is left from there to 1.
const KNEE: f32 = 0.76;
const ROOM: f32 = 0.24;
// So that what is far brighter than the display has a way back.
const ROOM_MIN: f32 = 4e-6;

// Colours as they are averaged: radiance whose brightest channel ends below 1, with coverage.
fn compressed(texel: vec4f, gain: f32) -> vec4f {
    let color = min(scrubbed(texel).rgb * gain, vec3f(HALF_FLOAT_MAX));
    let peak = max(color.r, max(color.g, color.b));
    let over = max(peak - KNEE, 0.0);
    let limited = min(peak, KNEE) + ROOM * over / (over + ROOM);
    return vec4f(color * (limited / max(peak, 1e-20)), texel.a);
}

fn expanded(texel: vec4f, gain: f32) -> vec4f {
    let peak = max(texel.r, max(texel.g, texel.b));
    let over = max(peak - KNEE, 0.0);
    let unlimited = min(peak, KNEE) + ROOM * over / max(ROOM - over, ROOM_MIN);
    return scrubbed(vec4f(texel.rgb * (unlimited / max(peak, 1e-20)) / gain, texel.a));
}
