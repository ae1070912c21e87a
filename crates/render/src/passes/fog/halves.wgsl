// Which pixel a texel of half the width and height is of: one of its four, another one in every sample, so that all
// have their turn.

import package::view::view;

fn turn_in_square() -> vec2i {
    let turn = i32(view.sample_index & 3u);
    return vec2i((turn + (turn >> 1u)) & 1, turn & 1);
}

fn pixel_of_texel(texel: vec2i) -> vec2i {
    return min(texel * 2 + turn_in_square(), vec2i(view.size_px) - 1);
}

// How much a ray that ends at one distance tells of one that ends at another: a tenth of the distance farther off,
// hardly anything; but something must count.
fn likeness(distance_m: f32, other_m: f32) -> f32 {
    let unlike = abs(other_m - distance_m) / max(min(other_m, distance_m), 1e-6);
    return exp(-min(20.0 * unlike, 80.0)) + 1e-4;
}
