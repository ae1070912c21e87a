// Where the tiles of a picture of the environment lie: octahedral maps of all directions with a border of one texel,
// one for each level of roughness. The mirror's comes first; below it two by three fine ones, below them four by two of
// medium size, below them a row of coarse ones.

import package::constants::{
    ENVIRONMENT_LEVEL_COARSE, ENVIRONMENT_LEVEL_HALF, ENVIRONMENT_LEVEL_MEDIUM, ENVIRONMENT_ROUGHNESS_FIRST,
};

// The level of a perceptual roughness; `lobe.rs` has the inverse.
fn environment_level(roughness: f32) -> f32 {
    let ratio = roughness / ENVIRONMENT_ROUGHNESS_FIRST;
    let middle = 1.0 + 4.0 * log2(max(ratio, 1.0));
    let high = ENVIRONMENT_LEVEL_HALF + (roughness - 0.5) * 16.0;
    return select(select(high, middle, roughness < 0.5), ratio, ratio < 1.0);
}

// The place of a direction on the tile of a level, a whole number, in texels of the texture. `place` is the direction
// as an octahedral map has it, from -1 to 1; `sides` are those of the mirror's tile, of fine, of medium and of coarse
// ones.
fn environment_texel(place: vec2f, level: f32, sides: vec4f) -> vec2f {
    let steps = sides + 2.0;
    let is_medium = level >= ENVIRONMENT_LEVEL_MEDIUM;
    let is_coarse = level >= ENVIRONMENT_LEVEL_COARSE;
    // Those of its size are counted from the first one, and stand in rows.
    let first = select(select(1.0, ENVIRONMENT_LEVEL_MEDIUM, is_medium), ENVIRONMENT_LEVEL_COARSE, is_coarse);
    let columns = select(select(2.0, 4.0, is_medium), 16.0, is_coarse);
    let step = select(select(steps.y, steps.z, is_medium), steps.w, is_coarse);
    let above = select(select(0.0, 3.0 * steps.y, is_medium), 3.0 * steps.y + 2.0 * steps.z, is_coarse);
    let row = floor((level - first) / columns);
    let corner = vec2f(level - first - row * columns, row) * step + vec2f(0.0, steps.x + above);
    let is_mirror = level < 0.5;
    return select(corner, vec2f(0.0), is_mirror) + 1.0 + (0.5 * place + 0.5) * select(step - 2.0, sides.x, is_mirror);
}
