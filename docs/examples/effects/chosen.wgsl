//! effect chosen
//! reads: radiance, ids
//! passes: fs_pick -> halo 1/2, fs_spread -> halo 1/2 x rounds, fs_mix

// A line around chosen objects, and light around them. Shows `ids`, the number of a node plus 1, or 0 where there is
// nothing; and passes at half the size.

struct Chosen {
    /// The colour of the line and of the light, linear Rec. 709, of white as it is exposed
    // = 1, 0.45, 0.05 in 0..
    color: vec3f,
    /// How bright the light around is, share of the line
    // = 0.7 in 0..8
    glow: f32,
    /// The first of the chosen nodes and the last, as `manypass info --json` counts them
    // = 0, 0 in 0..
    nodes: vec2u,
    /// How often the light is spread; the more, the wider.
    // = 6 in 1..16
    rounds: u32,
}

@group(2) @binding(0) var<uniform> chosen: Chosen;

fn is_chosen(pixel: vec2i) -> bool {
    let id = textureLoad(ids, clamp(pixel, vec2i(0), vec2i(view.size_px) - 1), 0).r;
    return id > chosen.nodes.x && id <= chosen.nodes.y + 1u;
}

@fragment
fn fs_pick(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(select(0.0, 1.0, is_chosen(2 * vec2i(position.xy))));
}

@fragment
fn fs_spread(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = uv_at(position.xy);
    let step = (f32(drawn.round) + 0.5) * drawn.inverse_size_px;
    let above = textureSampleLevel(halo, linear_clamp, uv - step, 0.0)
        + textureSampleLevel(halo, linear_clamp, uv + step * vec2f(1.0, -1.0), 0.0);
    let below = textureSampleLevel(halo, linear_clamp, uv + step, 0.0)
        + textureSampleLevel(halo, linear_clamp, uv + step * vec2f(-1.0, 1.0), 0.0);
    return 0.25 * (above + below);
}

@fragment
fn fs_mix(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = radiance_at(pixel);
    if is_chosen(pixel) {
        return here;
    }
    let beside = is_chosen(pixel + vec2i(1, 0)) || is_chosen(pixel - vec2i(1, 0));
    if beside || is_chosen(pixel + vec2i(0, 1)) || is_chosen(pixel - vec2i(0, 1)) {
        return vec4f(chosen.color, 1.0);
    }
    let around = chosen.glow * textureSampleLevel(halo, linear_clamp, uv_at(position.xy), 0.0).r;
    return vec4f(half_float_clamped(here.rgb + around * chosen.color), max(here.a, min(around, 1.0)));
}
