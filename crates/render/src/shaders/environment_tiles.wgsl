// Where the tiles of a picture of the environment lie: octahedral maps of all directions with a border of one texel, one for each
// level of roughness. The mirror's comes first; below it two by three fine ones, below them four by two coarse ones.

import package::constants::{ENVIRONMENT_LEVEL_COARSE, ENVIRONMENT_LEVEL_HALF, ENVIRONMENT_ROUGHNESS_FIRST};

// The level of a perceptual roughness; `lobe.rs` has the inverse.
fn environment_level(roughness: f32) -> f32 {
    let ratio = roughness / ENVIRONMENT_ROUGHNESS_FIRST;
    let middle = 1.0 + 3.0 * log2(max(ratio, 1.0));
    let high = ENVIRONMENT_LEVEL_HALF + (roughness - 0.5) * 8.0;
    return select(select(high, middle, roughness < 0.5), ratio, ratio < 1.0);
}

// The place of a direction on the tile of a level, a whole number, in texels of the texture. `place` is the direction as an octahedral
// map has it, from -1 to 1; `sides` are those of the mirror's tile, of fine and of coarse ones.
fn environment_texel(place: vec2f, level: f32, sides: vec4f) -> vec2f {
    let fine = level - 1.0;
    let coarse = level - ENVIRONMENT_LEVEL_COARSE;
    let fine_row = floor(0.5 * fine);
    let coarse_row = floor(0.25 * coarse);
    let steps = sides.xyz + 2.0;
    let fine_corner = vec2f(fine - 2.0 * fine_row, fine_row) * steps.y;
    let coarse_corner = vec2f(coarse - 4.0 * coarse_row, coarse_row) * steps.z + vec2f(0.0, 3.0 * steps.y);
    let corner = select(fine_corner, coarse_corner, coarse >= 0.0) + vec2f(0.0, steps.x);
    let side = select(sides.y, sides.z, coarse >= 0.0);
    let is_mirror = level < 0.5;
    return select(corner, vec2f(0.0), is_mirror) + 1.0 + (0.5 * place + 0.5) * select(side, sides.x, is_mirror);
}
