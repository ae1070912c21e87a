// Two levels of detail that fade into each other: each draws its own pixels of a pattern, so that together they draw
// every pixel once. Squares of two by two pixels stay together, because passes find the planes of triangles from
// neighbours.

import package::view::view;
import package::constants::{FADE_COARSER, FADE_SHIFT, FADE_STEPS};

// 1 where what is drawn fades, so that all else pays nothing.
override fades: u32 = 0u;

// The thresholds of an ordered pattern (Bayer 1973) of eight by eight squares, 0 ≤ x < 1; each sample of a picture goes
// on by the golden ratio.
fn fade_threshold(position_px: vec2f) -> f32 {
    let x = (u32(position_px.x) >> 1u) & 7u;
    let y = (u32(position_px.y) >> 1u) & 7u;
    let odd = x ^ y;
    let coarse = ((odd & 1u) << 5u) | ((y & 1u) << 4u);
    let middle = ((odd & 2u) << 2u) | ((y & 2u) << 1u);
    let fine = ((odd & 4u) >> 1u) | ((y & 4u) >> 2u);
    return fract((f32(coarse | middle | fine) + 0.5) / 64.0 + f32(view.sample_index & 1023u) * 0.61803398875);
}

// Whether the pixel is the other level's. Beside the id of its object stand the coarser level's share of the pixels,
// and which of the two this is.
fn is_faded(position_px: vec2f, object: u32) -> bool {
    let code = object >> FADE_SHIFT;
    let coarser_share = f32(code & (FADE_STEPS - 1u)) / f32(FADE_STEPS);
    return (fade_threshold(position_px) < coarser_share) != ((code & FADE_COARSER) != 0u);
}
