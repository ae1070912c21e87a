//! The files of the folders `reports` and `hostile` of the shared models, by name: what each is read as, warned of or
//! refused for. Their INDEX.md say what other programs made of them, and which value is right.
//!
//! What is packed (`.gz`) or made by a script is left out: `crates/offline/tests/growth.rs` makes as large ones. Where
//! the right value is one of pictures, [`DRAWN`] and [`SAME`] have it, or [`NOT_DRAWN`] has the reason why not.
//! One is not as INDEX.md has it, for a reason: of the eight joints a vertex in `eight_joints_a_vertex.glb` the strongest
//! four move it, which is warned of. `crates/render/tests/shadow_leaks.rs` looks into the box of
//! `sun_leaks_into_closed_two_sided_box.glb`.

use crate::common::watch::watch;
use crate::common::{Folder, has_adapter, run_in};
use exr::prelude::{FlatImage, FlatSamples, ReadChannels, ReadLayers, read};
use manypass_testkit::needs::assets;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// A name, its triangles, the corners of what is drawn, and a part of its warnings; none where there is no warning.
type Row = (&'static str, u32, &'static str, Option<&'static str>);

const READ: [Row; 65] = [
    ("cube_1e6_m_away_by_its_node.glb", 12, "max 1000000.5 1000000.5 1000000.5, min 999999.5 999999.5 999999.5", None),
    (
        "eight_joints_a_vertex.glb",
        12,
        "max 0.2 0.2 0.2, min -0.2 -0.2 -0.2",
        Some("some vertices have more than four joints; the strongest four move them"),
    ),
    ("glass_red_base_color_on_plain_background.glb", 2208, "max 0.5 0.5 0.5, min -0.5 -0.5 -0.5", None),
    ("normal_map_rotated_by_texture_transform.glb", 2, "max 0.9 0.9 0, min -0.9 -0.9 0", None),
    ("normal_map_rotated_in_uv.glb", 2, "max 0.9 0.9 0, min -0.9 -0.9 0", None),
    ("ok_cubicspline_one_key.glb", 2, "max 0.2 0.2 0, min -0.2 -0.2 0", None),
    ("ok_cubicspline_quaternion_normalised.glb", 12, "max 0.3 0.3 0.3, min -0.3 -0.3 -0.3", None),
    ("ok_index_255_of_u8.glb", 450, "max 0.9 0.9 0, min -0.9 -0.9 0", None),
    ("ok_infinite_far_plane.glb", 12, "max 10000 10000 -40000, min -10000 -10000 -60000", None),
    ("ok_instance_mirrored.glb", 2, "max 0.8 0.5 0, min -0.8 -0.5 0", None),
    ("ok_interleaved_offsets.glb", 2, "max 0.5 0.5 0, min -0.5 -0.5 0", None),
    ("ok_jpeg_cmyk_without_app14.glb", 2, "max 1 1 0, min -1 -1 0", None),
    ("ok_jpeg_exif_rotated_is_ignored.glb", 2, "max 1 1 0, min -1 -1 0", None),
    ("ok_jpeg_ycck.glb", 2, "max 1 1 0, min -1 -1 0", None),
    ("ok_keys_from_5_to_6_s.glb", 2, "max 0.2 0.2 0, min -0.2 -0.2 0", None),
    ("ok_layers_half_a_metre_apart_at_20_km.glb", 4, "max 6000 6000 -19999.5, min -6000 -6000 -20000", None),
    ("ok_morph_accessor_without_view.glb", 2, "max 0.5 0.5 0, min -0.5 -0.5 0", None),
    ("ok_morph_normal_alone.glb", 2, "max 0.5 0.5 0, min -0.5 -0.5 0", None),
    ("ok_normalised_weights_rotation_colours.glb", 24, "max 0.598 0.2 0.2, min -0.4 -0.8 -0.2", None),
    ("ok_panes_sorted.glb", 6, "max 0.8 0.8 0.4, min -0.8 -0.8 -0.4", None),
    ("ok_png_16_bit_maps.glb", 2, "max 1 1 0, min -1 -1 0", None),
    ("ok_png_grey_alpha_16_bit_blend.glb", 2, "max 1 1 0, min -1 -1 0", None),
    ("ok_png_grey_trns_mask.glb", 2, "max 1 1 0, min -1 -1 0", None),
    ("ok_png_palette_1_bit_trns_mask.glb", 2, "max 1 1 0, min -1 -1 0", None),
    ("ok_pointer_to_absent_texture_transform.glb", 2, "max 0.9 0.9 0, min -0.9 -0.9 0", None),
    ("ok_second_bin_chunk_behind_the_end.glb", 1, "max 1 1 0, min 0 0 0", None),
    ("ok_shadows_at_a_thousandth.glb", 2246, "max 0.004 0.002 0.004, min -0.004 0 -0.004", None),
    ("ok_sheared_node_normals.glb", 2, "max 0.4 0.4 0.32, min -0.4 -0.4 -0.32", None),
    ("ok_sparse_without_view_in_all_uses.glb", 2, "max 0.5 0.5 0, min -0.5 -0.5 0", None),
    ("ok_texture_transform_order.glb", 2, "max 1 1 0, min -1 -1 0", None),
    ("ok_texture_transform_order_baked.glb", 2, "max 1 1 0, min -1 -1 0", None),
    ("ortho_xmag_2_ymag_1.glb", 12, "max 0.5 0.5 0.5, min -0.5 -0.5 -0.5", None),
    ("red_glass_ball_behind_glass_ball.glb", 4418, "max 3 3 1.5, min -3 -3 -3", None),
    ("sampler_wrap_10242.glb", 2, "max 1 1 0, min -1 -1 0", Some("found 10242; the default is used")),
    ("skin_joint_in_no_scene.glb", 36, "max 0.55 0.45 0.15, min -0.55 -0.45 -0.15", None),
    ("skinned_1.8_m_under_scaled_armature.glb", 12, "max 0.3 1.8 0.3, min -0.3 0 -0.3", None),
    ("sun_leaks_into_closed_two_sided_box.glb", 12, "max 2 2 2, min -2 -2 -2", None),
    ("sun_shadow_posts_on_400_m_ground.glb", 146, "max 200 2 200, min -200 0 -200", None),
    ("sun_shadow_posts_on_4_km_ground.glb", 146, "max 2000 2 2000, min -2000 0 -2000", None),
    ("taa_moving_box_over_still_floor.glb", 14, "max 4 0.25 4, min -4 -0.5 -4", None),
    (
        "texture_16385_px_wide.glb",
        2,
        "max 1 1 0, min -1 -1 0",
        Some("it has 16385 by 4 texels, and 16384 a side are possible; it is halved to 8192 by 2"),
    ),
    ("comb_252_corners.obj", 250, "max 0.9 0.8 0, min -0.9 -0.8 0", None),
    ("comb_302_corners.obj", 300, "max 0.9 0.8 0, min -0.9 -0.8 0", None),
    ("comment_after_face.obj", 1, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    (
        "face_of_one_corner.obj",
        1,
        "max 0.8 0.8 0, min -0.8 -0.8 0",
        Some("line 5: a face of fewer than three corners is left out"),
    ),
    (
        "mtl_absolute_windows_path.obj",
        2,
        "max 0.8 0.8 0, min -0.8 -0.8 0",
        Some("is an absolute path; \"d6tex.png\" beside the model is taken"),
    ),
    ("mtl_d_1_tr_1.obj", 2, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("mtl_tr_1_alone.obj", 2, "max 0.8 0.8 0, min -0.8 -0.8 0", Some("Tr 1 without d makes it invisible")),
    ("ok_negative_indices_interleaved.obj", 4, "max 0.8 0.5 0, min -0.8 -0.5 0", None),
    ("ascii_end_loop.stl", 1, "max 0.8 0.8 0, min -0.8 -0.8 0", Some("line 7: ")),
    ("ascii_noendsolid.stl", 1, "max 0.8 0.8 0, min -0.8 -0.8 0", Some("line 8: the file ends before the solid does")),
    ("ascii_nul.stl", 1, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("ascii_semi.stl", 1, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("ok_ascii_name_of_380.stl", 1, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("ok_binary_solid_header.stl", 1, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("face_colours.ply", 2, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("gaussian_splat_header.ply", 0, "max 0.8 0.8 0, min -0.8 -0.8 0", Some("Gaussian splats are not drawn as such")),
    ("numbers_without_leading_zero.ply", 1, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("ok_big_endian.ply", 2, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("ok_float_colours.ply", 2, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("ok_list_uint_uchar.ply", 2, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("wedge_texcoord_texturefile.ply", 2, "max 0.8 0.8 0, min -0.8 -0.8 0", None),
    ("ok_base_material_of_triangles.3mf", 4, "max 0.01 0.01 0, min 0 0 -0.01", None),
    ("ok_inch_item_transform.3mf", 4, "max 0.076 0.025 0, min 0.051 0 -0.025", None),
    ("ok_mirrored_component_in_component.3mf", 4, "max 0 0.015 0, min -0.01 0.005 -0.01", None),
];

/// What is refused, and what the error says: the place and the value.
const REFUSED: [(&str, &str); 7] = [
    ("reports/ok_cycle_of_nodes_refused.glb", "at \"/nodes/0\": the node is its own ancestor"),
    ("hostile/items_1e5.3mf", "it shows 99999 objects, and 20000 are possible"),
    ("hostile/mesh_x1e5.3mf", "it shows 99999 objects, and 20000 are possible"),
    ("hostile/decals_positions.stage.toml", ":2:1: error: there are more decals than 4096: 40960000 of this entry"),
    ("hostile/environment_dev_zero.stage.toml", ":3:6: error: environment \"/dev/zero\": it is not a regular file"),
    ("hostile/particles_rate.stage.toml", ":5:9: error: `1000000` is not a value of `rate_hz`"),
    ("hostile/sim_rate.stage.toml", ":5:9: error: `1000000` is not a value of `rate_hz`"),
];

/// Effects, and why they are refused.
const EFFECTS: [(&str, &str); 4] = [
    ("hostile/effect_array_1e6.wgsl", "makes the variables of this shader larger than 16 KiB"),
    ("hostile/effect_array_1e8.wgsl", "makes the variables of this shader larger than 16 KiB"),
    ("hostile/effect_private_array.wgsl", "makes the variables of this shader larger than 16 KiB"),
    ("hostile/effect_calls_doubling.wgsl", "has more than 50000 expressions"),
];

/// What a file looks like.
enum Look {
    /// Channels of a layer at a place, in shares of the picture from its top left corner.
    At(&'static str, [f32; 2], &'static [f32]),
    /// Channels of a layer wherever there is a surface.
    All(&'static str, &'static [f32]),
    /// The pixels that surfaces of a base colour have, in the left half and in the right one.
    Pixels([f32; 3], [f32; 2]),
    /// The least and the greatest position along an axis of surfaces of a base colour, in metres.
    Span([f32; 3], usize, [f32; 2]),
    /// All surfaces face the eye: the least z of their normals in its space is above this.
    Facing(f32),
}

use Look::{All, At, Facing, Pixels, Span};

const WHITE: [f32; 3] = [1.0; 3];
const RED: [f32; 3] = [1.0, 0.0, 0.0];
/// The colour of formats without materials.
const PLAIN: [f32; 3] = [0.1912, 0.2195, 0.2582];
/// What clamps of 8 bits and the steps of sRGB take from a colour.
const STEP: f32 = 0.006;
/// A pixel of 2 m across 256, and across 64.
const PX: f32 = 0.008;
const PX_OF_64: f32 = 0.032;
/// The halves of 5,202 and 10,404 pixels of 128² (20,808 and 41,616 of 256²), and what edges may add to one.
const TRIANGLE: [f32; 2] = [2601.0; 2];
const QUAD: [f32; 2] = [5202.0; 2];
const EDGE: f32 = 2.0;
/// Places in shares of a picture.
const MIDDLE: [f32; 2] = [0.5, 0.5];
const LEFT: [f32; 2] = [0.25, 0.5];
const RIGHT: [f32; 2] = [0.75, 0.5];
const TOP: [f32; 2] = [0.5, 0.25];
const BOTTOM: [f32; 2] = [0.5, 0.75];

/// A file, the time in seconds if it moves (half seconds), what is right by INDEX.md, and how far off it may be. Those
/// with a time have 64² pixels and their own camera. Flat files are seen from the front in 128², others in 256².
const DRAWN: [(&str, Option<f32>, Look, f32); 79] = [
    ("ok_png_palette_1_bit_trns_mask.glb", None, At("rgba.A", LEFT, &[0.0]), 0.0),
    ("ok_png_palette_1_bit_trns_mask.glb", None, At("rgba.A", RIGHT, &[1.0]), 0.0),
    ("ok_png_grey_trns_mask.glb", None, At("rgba.A", LEFT, &[0.0]), 0.0),
    ("ok_png_grey_trns_mask.glb", None, At("rgba.A", RIGHT, &[1.0]), 0.0),
    ("ok_png_grey_alpha_16_bit_blend.glb", None, At("rgba.A", LEFT, &[0.0]), 1e-4),
    ("ok_png_grey_alpha_16_bit_blend.glb", None, At("rgba.A", RIGHT, &[1.0]), 1e-4),
    ("ok_jpeg_ycck.glb", None, All("base_color", &[0.0, 1.0, 1.0]), STEP),
    ("ok_jpeg_cmyk_without_app14.glb", None, All("base_color", &[0.0, 1.0, 1.0]), STEP),
    // Red grows to the right and green downwards, evenly in sRGB.
    ("ok_jpeg_exif_rotated_is_ignored.glb", None, At("base_color", LEFT, &[0.0508, 0.214, 0.0]), STEP),
    ("ok_jpeg_exif_rotated_is_ignored.glb", None, At("base_color", RIGHT, &[0.5225, 0.214, 0.0]), STEP),
    ("ok_jpeg_exif_rotated_is_ignored.glb", None, At("base_color", BOTTOM, &[0.214, 0.5225, 0.0]), STEP),
    // The same from 0.5 to 1.5: it is repeated.
    ("sampler_wrap_10242.glb", None, At("base_color.R", LEFT, &[0.5225]), 0.01),
    ("sampler_wrap_10242.glb", None, At("base_color.R", RIGHT, &[0.0508]), 0.01),
    ("sampler_wrap_10242.glb", None, At("base_color.G", TOP, &[0.5225]), 0.01),
    ("ok_png_16_bit_maps.glb", None, All("base_color", &[0.2159, 0.0513, 0.5776]), 1e-3),
    ("ok_png_16_bit_maps.glb", None, All("normal.X", &[0.498]), 1e-3),
    ("ok_png_16_bit_maps.glb", None, All("occlusion", &[0.392]), 1e-3),
    ("ok_index_255_of_u8.glb", None, Pixels(WHITE, [26450.0, 26450.0]), 0.0),
    ("ok_instance_mirrored.glb", None, Pixels(WHITE, [5709.0, 5709.0]), 8.0),
    ("ok_morph_normal_alone.glb", None, All("normal", &[0.6, 0.0, 0.8]), 1e-3),
    ("ok_morph_normal_alone.glb", None, Span(WHITE, 0, [-0.5, 0.5]), PX),
    ("ok_morph_normal_alone.glb", None, Span(WHITE, 1, [-0.5, 0.5]), PX),
    ("ok_interleaved_offsets.glb", None, Span(WHITE, 0, [-0.5, 0.5]), PX),
    ("ok_interleaved_offsets.glb", None, Span(WHITE, 1, [-0.5, 0.5]), PX),
    ("ok_second_bin_chunk_behind_the_end.glb", None, Span(WHITE, 0, [0.0, 1.0]), 0.015),
    ("ok_second_bin_chunk_behind_the_end.glb", None, Span(WHITE, 1, [0.0, 1.0]), 0.015),
    ("ok_sheared_node_normals.glb", None, All("normal", &[-0.6247, 0.0, 0.7809]), 1e-3),
    ("ok_infinite_far_plane.glb", None, All("depth", &[40003.0]), 1.0),
    ("ok_layers_half_a_metre_apart_at_20_km.glb", None, All("depth", &[19999.5]), 0.1),
    ("ok_layers_half_a_metre_apart_at_20_km.glb", None, All("base_color", &[0.0, 1.0, 0.0]), STEP),
    ("ok_panes_sorted.glb", None, At("rgba", MIDDLE, &[0.5, 0.125, 0.25, 0.875]), 1e-3),
    ("ok_base_material_of_triangles.3mf", None, All("base_color", &[1.0, 0.2159, 0.0]), STEP),
    ("ok_mirrored_component_in_component.3mf", None, Facing(0.1), 0.0),
    ("ok_inch_item_transform.3mf", None, Span(PLAIN, 0, [0.0508, 0.0762]), 3e-4),
    ("skin_joint_in_no_scene.glb", None, Span(WHITE, 1, [-0.45, 0.45]), PX),
    ("texture_16385_px_wide.glb", None, At("base_color", LEFT, &RED), STEP),
    ("texture_16385_px_wide.glb", None, At("base_color", RIGHT, &[0.0, 1.0, 0.0]), STEP),
    // Red on whatever is behind, and not opaque.
    ("glass_red_base_color_on_plain_background.glb", None, At("rgba.A", MIDDLE, &[0.55]), 0.45),
    ("glass_red_base_color_on_plain_background.glb", None, At("rgba.R", MIDDLE, &[0.6]), 0.2),
    ("glass_red_base_color_on_plain_background.glb", None, At("rgba.G", MIDDLE, &[0.0]), 0.1),
    // Behind clear glass the red of the other ball is seen.
    ("red_glass_ball_behind_glass_ball.glb", None, At("rgba", MIDDLE, &[0.32, 0.05, 0.05, 1.0]), 0.05),
    ("ok_morph_accessor_without_view.glb", Some(0.5), Span(WHITE, 0, [-0.5, 0.5]), PX_OF_64),
    ("ok_morph_accessor_without_view.glb", Some(0.5), Span(WHITE, 1, [-0.5, 0.5]), PX_OF_64),
    ("ok_cubicspline_one_key.glb", Some(0.0), Span(WHITE, 0, [0.1, 0.5]), PX_OF_64),
    ("ok_cubicspline_one_key.glb", Some(0.5), Span(WHITE, 0, [0.1, 0.5]), PX_OF_64),
    ("ok_cubicspline_one_key.glb", Some(2.0), Span(WHITE, 0, [0.1, 0.5]), PX_OF_64),
    // 5,898 pixels of 256².
    ("ok_cubicspline_quaternion_normalised.glb", Some(0.5), Pixels(WHITE, [184.3, 184.3]), 2.0),
    ("ok_pointer_to_absent_texture_transform.glb", Some(1.0), At("base_color", LEFT, &[0.0, 0.0, 0.0]), STEP),
    ("ok_pointer_to_absent_texture_transform.glb", Some(1.0), At("base_color", RIGHT, &WHITE), STEP),
    ("ok_sparse_without_view_in_all_uses.glb", Some(1.0), Span(WHITE, 0, [-0.1, 0.9]), PX_OF_64),
    // The skin, and a box of 0.4 by 0.8 that has turned.
    ("ok_normalised_weights_rotation_colours.glb", Some(1.0), Span([0.5, 1.0, 0.0], 0, [0.199, 0.598]), PX_OF_64),
    ("ok_normalised_weights_rotation_colours.glb", Some(1.0), Span(RED, 0, [-0.2, 0.2]), PX_OF_64),
    ("ok_normalised_weights_rotation_colours.glb", Some(1.0), Span(RED, 1, [-1.0, -0.2]), PX_OF_64),
    ("ok_keys_from_5_to_6_s.glb", Some(0.0), Span(WHITE, 0, [-0.7, -0.3]), PX_OF_64),
    ("ok_keys_from_5_to_6_s.glb", Some(5.0), Span(WHITE, 0, [-0.7, -0.3]), PX_OF_64),
    ("ok_keys_from_5_to_6_s.glb", Some(5.5), Span(WHITE, 0, [-0.2, 0.2]), PX_OF_64),
    ("ok_keys_from_5_to_6_s.glb", Some(6.0), Span(WHITE, 0, [0.3, 0.7]), PX_OF_64),
    ("ok_keys_from_5_to_6_s.glb", Some(7.0), Span(WHITE, 0, [0.3, 0.7]), PX_OF_64),
    // Four metres are seen across 64 pixels, and the cube has one.
    ("ortho_xmag_2_ymag_1.glb", Some(0.0), Pixels(WHITE, [128.0, 128.0]), 0.0),
    ("ascii_end_loop.stl", None, Pixels(PLAIN, TRIANGLE), EDGE),
    ("ascii_noendsolid.stl", None, Pixels(PLAIN, TRIANGLE), EDGE),
    ("ascii_nul.stl", None, Pixels(PLAIN, TRIANGLE), EDGE),
    ("ascii_semi.stl", None, Pixels(PLAIN, TRIANGLE), EDGE),
    ("ok_ascii_name_of_380.stl", None, Pixels(PLAIN, TRIANGLE), EDGE),
    ("ok_binary_solid_header.stl", None, Pixels(PLAIN, TRIANGLE), EDGE),
    ("comment_after_face.obj", None, Pixels(PLAIN, TRIANGLE), EDGE),
    ("face_of_one_corner.obj", None, Pixels(PLAIN, TRIANGLE), EDGE),
    ("numbers_without_leading_zero.ply", None, Pixels(PLAIN, TRIANGLE), EDGE),
    ("ok_list_uint_uchar.ply", None, Pixels(PLAIN, QUAD), EDGE),
    ("ok_big_endian.ply", None, Pixels(PLAIN, QUAD), EDGE),
    ("ok_float_colours.ply", None, Pixels([1.0, 0.2122, 0.0], QUAD), EDGE),
    ("face_colours.ply", None, Pixels(RED, QUAD), EDGE),
    ("wedge_texcoord_texturefile.ply", None, Pixels(RED, QUAD), EDGE),
    ("mtl_d_1_tr_1.obj", None, Pixels(RED, QUAD), EDGE),
    ("mtl_absolute_windows_path.obj", None, Pixels(RED, QUAD), EDGE),
    // 424,673 pixels of 1024², to 1 and 2 %: the teeth are about a pixel wide.
    ("comb_302_corners.obj", None, Pixels(PLAIN, [3317.8, 3317.8]), 66.0),
    ("comb_252_corners.obj", None, Pixels(PLAIN, [3317.8, 3317.8]), 132.0),
    ("ok_negative_indices_interleaved.obj", None, Pixels(PLAIN, [2432.0, 2432.0]), 40.0),
    ("ok_negative_indices_interleaved.obj", None, At("rgba.A", MIDDLE, &[0.0]), 0.0),
];

/// Two files, and a layer in which no pixel differs.
const SAME: [(&str, &str, &str); 2] = [
    ("ok_texture_transform_order.glb", "ok_texture_transform_order_baked.glb", "base_color"),
    ("normal_map_rotated_by_texture_transform.glb", "normal_map_rotated_in_uv.glb", "normal"),
];

/// The other files, and why no picture of theirs is looked at here.
const NOT_DRAWN: [(&str, &str); 10] = [
    ("cube_1e6_m_away_by_its_node.glb", "far.rs compares such cubes of all formats with those at the origin"),
    ("eight_joints_a_vertex.glb", "not as INDEX.md has it: the strongest four joints move a vertex, with a warning"),
    ("gaussian_splat_header.ply", "its warning is what is right"),
    ("mtl_tr_1_alone.obj", "it is invisible: its warning is what is right"),
    ("ok_shadows_at_a_thousandth.glb", "the same scene at 1 is no file; crates/render/tests/shadow_extents.rs"),
    ("skinned_1.8_m_under_scaled_armature.glb", "its bounds are what is right"),
    ("sun_leaks_into_closed_two_sided_box.glb", "16 samples; crates/render/tests/shadow_leaks.rs has such a box"),
    ("sun_shadow_posts_on_400_m_ground.glb", "16 samples; crates/render/tests/shadow_extents.rs has such posts"),
    ("sun_shadow_posts_on_4_km_ground.glb", "16 samples; crates/render/tests/shadow_extents.rs has such posts"),
    ("taa_moving_box_over_still_floor.glb", "17 frames; crates/render/tests/taa.rs has such a box"),
];

/// What `info` says of a file.
fn info(path: &Path) -> (bool, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_manypass"));
    let run = command.arg("info").arg(path).stdin(Stdio::null()).output().expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (run.status.success(), text(&run.stdout), text(&run.stderr))
}

#[test]
fn files_that_broke_other_programs_are_read_as_they_should_be() {
    let Some(folder) = assets("reports") else { return };
    for (name, triangles, bounds, warning) in READ {
        let (is_read, said, error) = info(&folder.join(name));
        assert!(is_read, "{name}: {error}");
        let lines = [format!("triangles drawn: {triangles}\n"), format!("bounds m: {bounds}\n")];
        assert!(lines.iter().all(|line| said.contains(line.as_str())), "{name} is not {lines:?}: {said}");
        match warning {
            None => assert!(said.contains("\nwarnings: 0"), "{name}: {said}"),
            Some(part) => assert!(!said.contains("\nwarnings: 0") && said.contains(part), "{name}, {part}: {said}"),
        }
    }
}

/// How each is drawn: into which folder, with which flags.
const MOVING: (&str, [&str; 8]) = ("moving/", ["--size", "64x64", "--frames", "0..14", "--fps", "2", "--camera", "0"]);
const FLAT: (&str, [&str; 8]) =
    ("flat/", ["--size", "128x128", "--eye", "0,0,5", "--target", "0,0,0", "--ortho-height", "2"]);
const STILL: (&str, [&str; 2]) = ("still/", ["--size", "256x256"]);

/// The folder of a file's pictures.
fn folder_of(name: &str, time: Option<f32>) -> &'static str {
    match name.rsplit_once('.') {
        _ if time.is_some() => MOVING.0,
        Some((_, "obj" | "stl" | "ply")) => FLAT.0,
        _ => STILL.0,
    }
}

/// The picture of a file, at its half second.
fn picture_of(out: &Folder, name: &str, time: Option<f32>) -> FlatImage {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let frame = time.map(|secs| format!("_{:04}", (secs * 2.0) as u32)).unwrap_or_default();
    let path = out.join(&format!("{}{stem}{frame}.exr", folder_of(name, time)));
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    reader.from_file(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The channels of a layer, or one of them, as in `rgba.A`.
fn channels(image: &FlatImage, layer: &str) -> Vec<Vec<f32>> {
    let all = match layer {
        "rgba" => "RGBA",
        "base_color" => "RGB",
        "depth" => "Z",
        "occlusion" => "Y",
        _ => "XYZ",
    };
    let (layer, letters) = layer.split_once('.').unwrap_or((layer, all));
    let is_it = |name: Option<&exr::prelude::Text>| name.is_some_and(|name| name.eq(layer));
    let found = image.layer_data.iter().find(|found| is_it(found.attributes.layer_name.as_ref()));
    let found = found.unwrap_or_else(|| panic!("no layer {layer}"));
    let values = |letter: char| {
        let mut list = found.channel_data.list.iter();
        let channel = list.find(|channel| channel.name.eq(letter.to_string().as_str()));
        match channel.map(|channel| &channel.sample_data) {
            Some(FlatSamples::F32(values)) => values.clone(),
            other => panic!("{layer}.{letter} is {other:?}"),
        }
    };
    letters.chars().map(values).collect()
}

/// What is right, and what the picture has.
fn right_and_found(image: &FlatImage, look: &Look) -> (Vec<f32>, Vec<f32>) {
    let (width, height) = (image.layer_data[0].size.0, image.layer_data[0].size.1);
    let depth = channels(image, "depth").remove(0);
    let surfaces: Vec<usize> = (0..depth.len()).filter(|at| depth[*at].is_finite()).collect();
    let of_color = |color: &[f32; 3]| -> Vec<usize> {
        let base_color = channels(image, "base_color");
        let is_near = |at: usize| base_color.iter().zip(color).all(|(channel, c)| (channel[at] - c).abs() < 0.02);
        surfaces.iter().copied().filter(|at| is_near(*at)).collect()
    };
    match look {
        At(layer, [x, y], right) => {
            let at = (y * height as f32) as usize * width + (x * width as f32) as usize;
            (right.to_vec(), channels(image, layer).iter().map(|channel| channel[at]).collect())
        }
        All(layer, right) => {
            let farthest = |(channel, right): (&Vec<f32>, &f32)| {
                let off = |at: usize| (channel[at] - right).abs();
                let most = surfaces.iter().copied().max_by(|a, b| off(*a).total_cmp(&off(*b)));
                most.map_or(f32::NAN, |at| channel[at])
            };
            (right.to_vec(), channels(image, layer).iter().zip(*right).map(farthest).collect())
        }
        Pixels(color, right) => {
            let pixels = of_color(color);
            let left = pixels.iter().filter(|at| *at % width < width / 2).count();
            (right.to_vec(), vec![left as f32, (pixels.len() - left) as f32])
        }
        Span(color, axis, right) => {
            let position = channels(image, "position").remove(*axis);
            let values: Vec<f32> = of_color(color).into_iter().map(|at| position[at]).collect();
            let least = values.iter().copied().fold(f32::INFINITY, f32::min);
            let greatest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            (right.to_vec(), vec![least, greatest])
        }
        Facing(least) => {
            let toward_eye = channels(image, "normal_view").remove(2);
            let found = surfaces.iter().map(|at| toward_eye[*at]).fold(f32::INFINITY, f32::min);
            let right = if found.is_finite() { found.max(*least) } else { *least };
            (vec![right], vec![found])
        }
    }
}

#[test]
fn files_that_broke_other_programs_look_as_they_should() {
    let Some(folder) = assets("reports") else { return };
    if !has_adapter() {
        return;
    }
    let out = Folder::new("reports-drawn");
    let of_pairs = SAME.iter().flat_map(|(a, b, _)| [(*a, None), (*b, None)]);
    let files: Vec<(&str, Option<f32>)> = DRAWN.iter().map(|row| (row.0, row.1)).chain(of_pairs).collect();
    let layers = ["--aov", "base_color,occlusion,normal,normal_view,position,depth", "--background", "transparent"];
    for (into, flags) in [(MOVING.0, &MOVING.1[..]), (FLAT.0, &FLAT.1[..]), (STILL.0, &STILL.1[..])] {
        let mut paths: Vec<String> = Vec::new();
        for (name, _) in files.iter().filter(|(name, time)| folder_of(name, *time) == into) {
            let path = folder.join(name).to_str().expect("a name in UTF-8").to_owned();
            if !paths.contains(&path) {
                paths.push(path);
            }
        }
        let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        let format = ["--format", "exr", "--exr-compression", "rle", "--samples", "1", "-q", "-o", into];
        run_in(&out, &[&["render"], &paths[..], &format, &layers, flags].concat()).expect(0);
    }
    let mut wrong = Vec::new();
    for rows in DRAWN.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let image = picture_of(&out, rows[0].0, rows[0].1);
        for (name, time, look, tolerance) in rows {
            let (right, found) = right_and_found(&image, look);
            let is_right = right.iter().zip(&found).all(|(right, found)| (found - right).abs() <= *tolerance);
            if !is_right || right.len() != found.len() {
                wrong.push(format!("{name} at {time:?}: {found:?}, and {right:?} is right to {tolerance}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for (a, b, layer) in SAME {
        let [first, second] = [a, b].map(|name| channels(&picture_of(&out, name, None), layer));
        assert!(first == second, "{a} and {b} differ in {layer}");
        let varies = |channel: &Vec<f32>| channel.iter().any(|value| (value - channel[0]).abs() > 0.1);
        assert!(first.iter().any(varies), "{a} shows nothing");
    }
}

#[test]
fn every_file_that_is_read_is_looked_at_or_has_a_reason_not_to_be() {
    let is_drawn =
        |name: &str| DRAWN.iter().any(|row| row.0 == name) || SAME.iter().any(|(a, b, _)| [*a, *b].contains(&name));
    for (name, ..) in READ {
        let reason = NOT_DRAWN.iter().find(|(left, _)| *left == name);
        assert!(is_drawn(name) != reason.is_some(), "{name} is drawn, or NOT_DRAWN has a reason: {reason:?}");
    }
    let is_read = |name: &str| READ.iter().any(|row| row.0 == name);
    assert!(NOT_DRAWN.iter().all(|(name, _)| is_read(name)) && DRAWN.iter().all(|row| is_read(row.0)));
}

#[test]
fn hostile_files_are_refused_with_place_and_value() {
    let Some(folder) = assets("hostile").and_then(|hostile| hostile.parent().map(Path::to_owned)) else { return };
    if assets("reports").is_none() {
        return;
    }
    for (name, part) in REFUSED {
        let (is_read, _, error) = info(&folder.join(name));
        assert!(!is_read && error.contains(part), "{name} should say {part}: {error}");
    }
    for (name, part) in EFFECTS {
        let path = folder.join(name);
        let run = run_in(&folder, &["settings", "--effect", path.to_str().expect("a name in UTF-8")]).expect(1);
        assert!(run.stderr.contains(part), "{name} should say {part}: {}", run.stderr);
    }
    let (is_read, said, error) = info(&folder.join("hostile/names.glb"));
    assert!(is_read && said.contains("\\u001b]0;pwn\\u0007") && !said.contains('\u{1b}'), "{said}{error}");
}

#[test]
fn hostile_simulations_are_drawn_soon_or_refused() {
    let Some(folder) = assets("hostile") else { return };
    if !has_adapter() {
        return;
    }
    let output = Folder::new("hostile-simulations");
    let path = |name: &str| folder.join(name).to_str().expect("a name in UTF-8").to_owned();
    let bare = ["--size", "8x8", "--samples", "1", "-q"];
    let drawn = ["s_mega.stage.toml", "s_rounds.stage.toml", "sim_big.stage.toml"].map(path);
    let drawn: Vec<&str> = drawn.iter().map(String::as_str).collect();
    // They take 1 s of processors together, and what is refused a fifth of it.
    let soon = |args: &[&str], code: i32| {
        let watched = watch(&output, args, Duration::from_secs(300));
        assert!(watched.cpu < Duration::from_secs(15), "{args:?}: {:?} of processors", watched.cpu);
        watched.run.expect(code)
    };
    soon(&[&["render", "-o", "out/"], &drawn[..], &bare].concat(), 0);
    let late = path("particles_t.stage.toml");
    let run = soon(&[&["render", late.as_str(), "--time", "1000"], &bare[..]].concat(), 1);
    assert!(run.stderr.contains("125829120000 cells, and 68719476736 at most"), "{}", run.stderr);
}
