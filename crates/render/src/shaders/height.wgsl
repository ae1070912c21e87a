// Heights of a surface, from 0 to 1. They have 16 bits: the upper eight in red, the lower in green. What puts them
// together is linear, so that filters may come before it; but software adapters round what they filter to the eight
// bits of its texels.

import package::shaders::layer_maps::{MAP_HEIGHT, layer_data, layer_data_sampler, map_layer};
import package::view::view;

// To about eight bits, between texels.
fn height_at(uv: vec2f, level: f32) -> f32 {
    let parts = textureSampleLevel(layer_data, layer_data_sampler, uv, map_layer(MAP_HEIGHT), level).rg;
    return dot(parts, vec2f(65280.0 / 65535.0, 255.0 / 65535.0));
}

// To all bits, of the nearest mip: texels where their middles are, which no filter rounds.
fn exact_height_at(uv: vec2f, level: f32) -> f32 {
    let mip = round(level);
    let size = vec2f(textureDimensions(layer_data, i32(mip)));
    let place = uv * size - 0.5;
    let first = floor(place);
    let share = place - first;
    let corner = (first + 0.5) / size;
    let step = 1.0 / size;
    let above = mix(height_at(corner, mip), height_at(corner + vec2f(step.x, 0.0), mip), share.x);
    let below = mix(height_at(corner + vec2f(0.0, step.y), mip), height_at(corner + step, mip), share.x);
    return mix(above, below, share.y);
}

// The mip whose texels are as large as a pixel, by area: where the surface is seen at a slant, finer ones than samplers
// take.
fn height_level(uv_dx: vec2f, uv_dy: vec2f) -> f32 {
    let size = vec2f(textureDimensions(layer_data));
    let dx = uv_dx * size;
    let dy = uv_dy * size;
    let area = abs(dx.x * dy.y - dx.y * dy.x);
    return max(0.5 * log2(max(area, 1e-12)) - view.mip_gain, 0.0);
}
