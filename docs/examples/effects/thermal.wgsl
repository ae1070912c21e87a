//! effect thermal
//! reads: radiance
//! pixel: heat

// Colours by how bright a place is, as a thermal camera has by how warm it is. Shows `reads: radiance`: light before the
// tone curve, of which 0.18 becomes middle grey, and a table of colours in the file.

struct Thermal {
    /// What has the coldest colour, stops from middle grey
    // = -6 in -20..20
    coldest_ev: f32,
    /// What has the warmest colour, stops from middle grey
    // = 3 in -20..20
    warmest_ev: f32,
}

@group(2) @binding(0) var<uniform> thermal: Thermal;

const WARMTH = array(vec3f(0.0, 0.0, 0.02), vec3f(0.1, 0.0, 0.3), vec3f(0.6, 0.02, 0.2), vec3f(1.0, 0.25, 0.0), vec3f(1.0, 0.9, 0.5));

fn heat(color: vec4f, position: vec2f) -> vec4f {
    let ev = log2(max(dot(color.rgb, vec3f(0.2126, 0.7152, 0.0722)), 1e-6) / 0.18);
    let span = max(thermal.warmest_ev - thermal.coldest_ev, 1e-3);
    let place = 4.0 * clamp((ev - thermal.coldest_ev) / span, 0.0, 1.0);
    let below = min(u32(place), 3u);
    return vec4f(mix(WARMTH[below], WARMTH[below + 1u], place - f32(below)) * color.a, color.a);
}
