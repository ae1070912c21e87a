//! effect fxaa
//! reads: display

// Anti-aliasing of a finished picture of few samples. It searches both ends of each edge. Then it blends with the pixel
// across the edge, by the area that a straight edge would cover.
// Source: Lottes 2009, "FXAA", in the form with a search for ends ("quality"). Differs from it: tones are the square
// root of linear colours.

struct Fxaa {
    /// The contrast below which there is no edge, of the brightest neighbour, share
    // = 0.125 in 0.03..1
    threshold: f32,
    /// The contrast below which there is no edge in dark areas, share
    // = 0.03 in 0..1
    threshold_dark: f32,
    /// The strength of subpixel anti-aliasing, share
    // = 0.75 in 0..1
    subpixel: f32,
    padding: f32,
}

@group(2) @binding(0) var<uniform> fxaa: Fxaa;

// So many steps along an edge, which reach 30 pixels.
const STEPS: u32 = 12u;

fn tone(color: vec4f) -> f32 {
    return dot(sqrt(max(color.rgb, vec3f(0.0))), vec3f(0.299, 0.587, 0.114));
}

fn tone_of(pixel: vec2i) -> f32 {
    return tone(display_at(pixel));
}

fn tone_at(uv: vec2f) -> f32 {
    return tone(textureSampleLevel(display, linear_clamp, uv, 0.0));
}

// How far the search goes on in a step, in pixels.
fn stride(i: u32) -> f32 {
    if i < 5u {
        return 1.0;
    }
    return select(select(2.0, 4.0, i > 8u), 8.0, i > 10u);
}

// How far an edge goes on from `uv` in steps of `along`, and how its tone differs from `middle` at its end: more than
// `end`.
fn end_of_edge(uv: vec2f, along: vec2f, middle: f32, end: f32) -> vec2f {
    var way = 1.0;
    var change = tone_at(uv + along) - middle;
    for (var i = 0u; i < STEPS; i++) {
        if abs(change) >= end {
            break;
        }
        way += stride(i);
        change = tone_at(uv + along * way) - middle;
    }
    return vec2f(way, change);
}

@fragment
fn fs_fxaa(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = display_at(pixel);
    let m = tone(here);
    let n = tone_of(pixel + vec2i(0, -1));
    let s = tone_of(pixel + vec2i(0, 1));
    let w = tone_of(pixel + vec2i(-1, 0));
    let e = tone_of(pixel + vec2i(1, 0));
    let brightest = max(m, max(max(n, s), max(w, e)));
    let contrast = brightest - min(m, min(min(n, s), min(w, e)));
    if contrast <= max(fxaa.threshold_dark, fxaa.threshold * brightest) {
        return here;
    }
    let nw = tone_of(pixel + vec2i(-1, -1));
    let ne = tone_of(pixel + vec2i(1, -1));
    let sw = tone_of(pixel + vec2i(-1, 1));
    let se = tone_of(pixel + vec2i(1, 1));
    let across_rows = abs(nw + sw - 2.0 * w) + 2.0 * abs(n + s - 2.0 * m) + abs(ne + se - 2.0 * e);
    let across_columns = abs(nw + ne - 2.0 * n) + 2.0 * abs(w + e - 2.0 * m) + abs(sw + se - 2.0 * s);
    let is_row = across_rows >= across_columns;
    // The side on which the edge lies.
    let before = select(w, n, is_row);
    let after = select(e, s, is_row);
    let is_before = abs(before - m) >= abs(after - m);
    let other = select(after, before, is_before);
    let size = select(vec2f(drawn.inverse_size_px.x, 0.0), vec2f(0.0, drawn.inverse_size_px.y), is_row);
    let across = select(size, -size, is_before);
    let along = select(vec2f(0.0, drawn.inverse_size_px.y), vec2f(drawn.inverse_size_px.x, 0.0), is_row);
    let uv = uv_at(position.xy);
    let middle = 0.5 * (m + other);
    let end = 0.25 * abs(other - m);
    let one = end_of_edge(uv + 0.5 * across, -along, middle, end);
    let two = end_of_edge(uv + 0.5 * across, along, middle, end);
    // Half of the edge lies on this side of the pixels' middles: that at whose end the tone goes away from this pixel's.
    let nearest = select(two, one, one.x < two.x);
    let is_this_side = (nearest.y < 0.0) != (m < middle);
    let by_edge = select(0.0, 0.5 - nearest.x / (one.x + two.x), is_this_side);
    // What is thinner than a pixel differs from all that is around it.
    let around = (2.0 * (n + s + w + e) + nw + ne + sw + se) / 12.0;
    let apart = smoothstep(0.0, 1.0, abs(around - m) / contrast);
    let share = max(by_edge, apart * apart * fxaa.subpixel);
    return textureSampleLevel(display, linear_clamp, uv + share * across, 0.0);
}
