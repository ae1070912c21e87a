// Where the tiles of a picture of the environment lie: octahedral maps of all directions with a border of one texel, one for each
// level of roughness. The mirror's comes first; below it two by three fine ones, below them four by two coarse ones.

import package::constants::{
    ENVIRONMENT_COARSE_SIDE, ENVIRONMENT_FINE_SIDE, ENVIRONMENT_LEVEL_COARSE, ENVIRONMENT_LEVEL_HALF,
    ENVIRONMENT_ROUGHNESS_FIRST,
};

const FINE_SIDE: f32 = f32(ENVIRONMENT_FINE_SIDE);
const COARSE_SIDE: f32 = f32(ENVIRONMENT_COARSE_SIDE);

// The level of a perceptual roughness; `lobe.rs` has the inverse.
fn environment_level(roughness: f32) -> f32 {
    let ratio = roughness / ENVIRONMENT_ROUGHNESS_FIRST;
    let middle = 1.0 + 3.0 * log2(max(ratio, 1.0));
    let high = ENVIRONMENT_LEVEL_HALF + (roughness - 0.5) * 8.0;
    return select(select(high, middle, roughness < 0.5), ratio, ratio < 1.0);
}

// The place of a direction on the tile of a level, a whole number, in texels of the texture. `place` is the direction as an octahedral
// map has it, from -1 to 1.
fn environment_texel(place: vec2f, level: f32, mirror_side: f32) -> vec2f {
    let fine = level - 1.0;
    let coarse = level - ENVIRONMENT_LEVEL_COARSE;
    let fine_row = floor(0.5 * fine);
    let coarse_row = floor(0.25 * coarse);
    let fine_corner = vec2f(fine - 2.0 * fine_row, fine_row) * (FINE_SIDE + 2.0);
    let coarse_corner = vec2f(coarse - 4.0 * coarse_row, coarse_row) * (COARSE_SIDE + 2.0)
        + vec2f(0.0, 3.0 * (FINE_SIDE + 2.0));
    let corner = select(fine_corner, coarse_corner, coarse >= 0.0) + vec2f(0.0, mirror_side + 2.0);
    let side = select(FINE_SIDE, COARSE_SIDE, coarse >= 0.0);
    let is_mirror = level < 0.5;
    return select(corner, vec2f(0.0), is_mirror) + 1.0 + (0.5 * place + 0.5) * select(side, mirror_side, is_mirror);
}
