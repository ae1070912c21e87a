// decals.mark: draws the boxes of decals for the stencil alone, which keeps the pixels where surfaces may lie within them.
// Writes: no colour.
// Program: decals_mark.

import package::constants::DECAL_TEXELS;
import package::shaders::light_table::{cluster_grid, table_texel};
import package::view::view;

// 1 if the near plane cuts the boxes.
override around: u32 = 0u;

// The first row of `world_from_box` among the texels of a decal.
const DECAL_BOX_X: u32 = 12u;

// Corners of a strip of triangles around a box, bit by bit from the first.
const STRIP_X: u32 = 0x287au;
const STRIP_Y: u32 = 0x02afu;
const STRIP_Z: u32 = 0x31e3u;

@vertex
fn vs_decals_mark(@builtin(vertex_index) vertex: u32, @builtin(instance_index) decal: u32) -> @builtin(position) vec4f {
    let bits = (vec3u(STRIP_X, STRIP_Y, STRIP_Z) >> vec3u(vertex)) & vec3u(1u);
    let first = decal * DECAL_TEXELS + DECAL_BOX_X;
    let first_row = cluster_grid.decal_rows.y;
    let row_x = table_texel(first, first_row);
    let row_y = table_texel(first + 1u, first_row);
    let row_z = table_texel(first + 2u, first_row);
    // A box that is mirrored is the same with its sides exchanged, and shows its fronts again.
    let handedness = select(-1.0, 1.0, dot(row_x.xyz, cross(row_y.xyz, row_z.xyz)) >= 0.0);
    let corner = vec4f((vec3f(bits) - 0.5) * vec3f(handedness, 1.0, 1.0), 1.0);
    let position_world = vec3f(dot(row_x, corner), dot(row_y, corner), dot(row_z, corner));
    var position_clip = view.clip_from_world * vec4f(position_world, 1.0);
    // Nothing of it is cut off where depth ends.
    position_clip.z = select(position_clip.z, 0.0, around != 0u);
    return position_clip;
}
