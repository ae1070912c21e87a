// Which pixel a texel is of, in textures of a half or a quarter of the picture's width and height: one of its square,
// another one in every sample, so that all have their turn.

import package::view::view;

fn turn_of_four(turn: i32) -> vec2i {
    return vec2i((turn + (turn >> 1u)) & 1, turn & 1);
}

// `side` is that of the square: 1, 2 or 4.
fn turn_in_square(side: i32) -> vec2i {
    let index = i32(view.sample_index & 15u);
    return turn_of_four(index & 3) * (side / 2) + turn_of_four(index >> 2u) * (side / 4);
}

fn pixel_of_texel(texel: vec2i, side: i32) -> vec2i {
    return min(texel * side + turn_in_square(side), vec2i(view.size_px) - 1);
}
