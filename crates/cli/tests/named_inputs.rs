//! The files of the folders `reports` and `hostile` of the shared models, by name: what each is read as, warned of or
//! refused for. Their INDEX.md say what other programs made of them, and which value is right.
//!
//! Left out are those of which only a picture tells, which other tests draw with inputs of their own, and what is
//! packed (`.gz`) or made by a script: `crates/offline/tests/growth.rs` makes as large ones. Two are not as INDEX.md
//! has them, for a reason: of the eight joints a vertex in `eight_joints_a_vertex.glb` the strongest four move it,
//! which is warned of; and sunlight leaks along the edges of `sun_leaks_into_closed_two_sided_box.glb`, whose
//! sheets have no thickness: docs/shadows.md says so, and `crates/render/tests/shadow_leaks.rs` looks at it.

mod common;

use common::{Folder, has_adapter, run_in};
use manypass_testkit::needs::assets;
use std::path::Path;
use std::process::{Command, Stdio};

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
    ("hostile/particles_rate.stage.toml", ":5:9: error: `1000000` is no value of `rate_hz`"),
    ("hostile/sim_rate.stage.toml", ":5:9: error: `1000000` is no value of `rate_hz`"),
];

/// Effects, and why they are refused.
const EFFECTS: [(&str, &str); 4] = [
    ("hostile/effect_array_1e6.wgsl", "makes the variables of this shader larger than 16 KiB"),
    ("hostile/effect_array_1e8.wgsl", "makes the variables of this shader larger than 16 KiB"),
    ("hostile/effect_private_array.wgsl", "makes the variables of this shader larger than 16 KiB"),
    ("hostile/effect_calls_doubling.wgsl", "has more than 50000 expressions"),
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
    run_in(&output, &[&["render", "-o", "out/"], &drawn[..], &bare].concat()).expect(0);
    let late = path("particles_t.stage.toml");
    let run = run_in(&output, &[&["render", late.as_str(), "--time", "1000"], &bare[..]].concat()).expect(1);
    assert!(run.stderr.contains("125829120000 cells, and 68719476736 at most"), "{}", run.stderr);
}
