//! effect toon
//! reads: radiance, depth, normal, base_color, material
//! passes: fs_light -> light, fs_rows -> rows, fs_toon

// Toon shading: light in a few even steps. Light is separated from the surface's base colour, smoothed within the surface
// and quantised. Then the surface takes the brightness of the step and keeps its colour.
// Sources: Lake et al. 2000, "Stylized Rendering Techniques for Scalable Real-Time 3D Animation"; Winnemöller et al.
// 2006, "Real-Time Video Abstraction" (soft steps).

struct Toon {
    /// The number of steps from dark to bright.
    // = 4 in 2..16
    steps: f32,
    /// The share of a step that is a transition to the next one, share
    // = 0.15 in 0.01..1
    softness: f32,
    /// The radius over which light is smoothed first, px
    // = 4 in 0..16
    smooth_px: f32,
    /// The share of the original shading that is left, share
    // = 0 in 0..1
    realism: f32,
    /// The saturation of the result, share
    // = 1.15 in 0..2
    saturation: f32,
    padding_a: f32,
    padding_b: f32,
    padding_c: f32,
}

@group(2) @binding(0) var<uniform> toon: Toon;

const LUMINANCE = vec3f(0.2126, 0.7152, 0.0722);

fn inside(pixel: vec2i) -> vec2i {
    return clamp(pixel, vec2i(0), vec2i(view.size_px) - 1);
}

// From 0 to 1, steps of which look even: 0.5 is a third of a white surface's light in the sun.
fn tone_of_light(light: f32) -> f32 {
    return sqrt(light / (1.0 + light));
}

fn light_of_tone(tone: f32) -> f32 {
    return tone * tone / max(1.0 - tone * tone, 1e-4);
}

// The tone of the light on a surface; the normal, to know where it goes on. Nothing (below 0) where there is no surface.
@fragment
fn fs_light(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let surface = surface_at(pixel);
    // Metals reflect their colour, and all else some light as it is.
    let albedo = max(dot(surface.base_color, LUMINANCE), 0.04);
    let light = max(dot(radiance_at(pixel).rgb, LUMINANCE), 0.0) / albedo;
    let tone = select(-1.0, tone_of_light(light), distance_at(pixel) < DISTANCE_BACKGROUND_M);
    return vec4f(tone, surface.normal_world);
}

// How much a neighbour counts: less the farther, and less the more its normal or tone differ.
fn weight(here: vec4f, there: vec4f, steps: i32) -> f32 {
    let distance = f32(steps) / max(toon.smooth_px, 0.1);
    let likeness = smoothstep(0.6, 0.95, dot(here.yzw, there.yzw));
    let is_near = 1.0 - smoothstep(0.15, 0.35, abs(here.x - there.x));
    return exp(-2.0 * distance * distance) * likeness * is_near * step(0.0, there.x);
}

fn reach() -> i32 {
    return i32(ceil(toon.smooth_px));
}

@fragment
fn fs_rows(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = textureLoad(light, pixel, 0);
    var sum = vec2f(here.x, 1.0);
    for (var i = 1; i <= reach(); i++) {
        for (var side = -1; side <= 1; side += 2) {
            let there = textureLoad(light, inside(pixel + vec2i(side * i, 0)), 0);
            sum += weight(here, there, i) * vec2f(there.x, 1.0);
        }
    }
    return vec4f(sum.x / sum.y, here.yzw);
}

@fragment
fn fs_toon(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = radiance_at(pixel);
    let found = textureLoad(rows, pixel, 0);
    var sum = vec2f(found.x, 1.0);
    for (var i = 1; i <= reach(); i++) {
        for (var side = -1; side <= 1; side += 2) {
            let there = textureLoad(rows, inside(pixel + vec2i(0, side * i)), 0);
            sum += weight(found, there, i) * vec2f(there.x, 1.0);
        }
    }
    if found.x < 0.0 {
        return here;
    }
    let count = floor(toon.steps);
    let place = sum.x / sum.y * count;
    // Up to the middle of the next step's edge, and over it smoothly.
    let edge = round(place);
    let up = smoothstep(-0.5, 0.5, (place - edge) / toon.softness);
    let tone = clamp((edge - 0.5 + up) / count, 0.5 / count, 1.0 - 0.5 / count);
    let surface = surface_at(pixel);
    let albedo = max(dot(surface.base_color, LUMINANCE), 0.04);
    let bright = max(dot(here.rgb, LUMINANCE), 1e-6);
    let stepped = here.rgb * (light_of_tone(tone) * albedo / bright);
    let grey = vec3f(dot(stepped, LUMINANCE));
    let color = max(mix(grey, stepped, toon.saturation), vec3f(0.0));
    return vec4f(half_float_clamped(mix(color, here.rgb, toon.realism)), here.a);
}
