//! `--cameras`: many views of NeRF's and COLMAP's lists in one process.

use crate::common::{Folder, Run, has_adapter, run_in, triangle_glb};
use exr::prelude::{ReadChannels, ReadLayers, read};
use glam::{DMat4, DVec3};
use serde_json::{Value, json};

const SMALL: [&str; 6] = ["--size", "16x16", "--samples", "1", "--near", "0.1"];

fn render(folder: &Folder, args: &[&str]) -> Run {
    run_in(folder, &[&["render", "tri.glb"], args].concat())
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// A frame of a `transforms.json`.
fn frame(name: &str, world_from_view: DMat4) -> Value {
    let rows = [0, 1, 2, 3].map(|row| world_from_view.row(row).to_array());
    json!({ "file_path": format!("./train/{name}.png"), "transform_matrix": rows })
}

/// At a point before the triangle, which is in the plane z = 0, and at one behind it.
fn two_views() -> Value {
    let front = DMat4::from_translation(DVec3::new(0.25, 0.0, 2.0));
    let turned = DMat4::from_scale(DVec3::new(-1.0, 1.0, -1.0));
    let back = DMat4::from_translation(DVec3::new(0.5, 0.25, -3.0)) * turned;
    // As --fov-y 40 has it.
    let angle_rad = f64::from(40.0_f32.to_radians());
    json!({ "camera_angle_x": angle_rad, "frames": [frame("000", front), frame("001", back)] })
}

#[test]
fn what_contradicts_a_list_of_cameras_is_wrong_usage() {
    let folder = Folder::new("cameras-usage");
    folder.write("tri.glb", &triangle_glb([1.0, 0.0, 0.0]));
    folder.write("t.json", two_views().to_string().as_bytes());
    let others: [[&str; 2]; 8] = [
        ["--camera", "0"],
        ["--eye", "1,2,3"],
        ["--orbit", "1,2,3"],
        ["--target", "1,2,3"],
        ["--up", "1,2,3"],
        ["--fov-y", "30"],
        ["--ortho-height", "3"],
        ["--turntable", "4"],
    ];
    for other in others {
        let run = render(&folder, &[&["--cameras", "t.json", "-o", "{camera}.png"][..], &other].concat()).expect(2);
        assert!(run.stderr.contains("--cameras") && run.stderr.contains("hint: "), "{other:?}: {}", run.stderr);
    }
    let run = render(&folder, &["--cameras", "t.json", "-o", "x.png"]).expect(2);
    assert!(run.stderr.contains("one place for all cameras") && run.stderr.contains("{camera}"), "{}", run.stderr);
    let run = render(&folder, &["--cameras", "t.json", "--report", "t.json"]).expect(2);
    assert!(run.stderr.contains("would replace the cameras t.json"), "{}", run.stderr);
    let run = render(&folder, &["--cameras", "gone.json"]).expect(1);
    assert!(run.stderr.contains("cannot read gone.json") && run.stderr.contains("COLMAP"), "{}", run.stderr);
    std::fs::create_dir_all(folder.join("empty")).expect("a folder");
    let run = render(&folder, &["--cameras", "empty"]).expect(1);
    assert!(run.stderr.contains("neither empty nor empty/sparse/0"), "{}", run.stderr);
    folder.write("bad.json", br#"{ "camera_angle_x": 1, "frames": [{ "file_path": "a.png" }] }"#);
    let run = render(&folder, &["--cameras", "bad.json"]).expect(1);
    assert!(run.stderr.contains("bad.json: frame 0 (`a.png`): it has no `transform_matrix`"), "{}", run.stderr);
}

#[test]
fn each_view_is_as_it_is_alone() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("cameras-alone");
    folder.write("tri.glb", &triangle_glb([1.0, 0.0, 0.0]));
    folder.write("t.json", two_views().to_string().as_bytes());
    let flags = ["--cameras", "t.json", "-o", "out/{camera}.png", "--report", "r.jsonl"];
    let run = render(&folder, &[&flags[..], &SMALL].concat()).expect(0);
    assert!(!run.stderr.contains("--cameras"), "{}", run.stderr);
    let report = String::from_utf8(bytes(&folder, "r.jsonl")).expect("text");
    let names: Vec<Value> =
        report.lines().map(|line| serde_json::from_str::<Value>(line).expect("JSON")["camera_name"].clone()).collect();
    assert_eq!(names, ["000", "001"]);
    for (name, eye, target) in [("000", "0.25,0,2", "0.25,0,0"), ("001", "0.5,0.25,-3", "0.5,0.25,0")] {
        let flags = ["--eye", eye, "--target", target, "--fov-y", "40", "-o", "alone.png"];
        render(&folder, &[&flags[..], &SMALL].concat()).expect(0);
        assert!(bytes(&folder, "alone.png") == bytes(&folder, &format!("out/{name}.png")), "{name}");
    }
    assert!(bytes(&folder, "out/000.png") != bytes(&folder, "out/001.png"));
    // The same cameras from COLMAP, to the camera from the world: half a turn about x, and one about z.
    folder.write("colmap/sparse/0/cameras.txt", b"1 SIMPLE_PINHOLE 16 16 21.97982005 8 8\n");
    let images = "1 0 1 0 0 -0.25 0 2 1 a/000.png\n\n2 0 0 0 1 0.5 0.25 3 1 a/001.png\n\n";
    folder.write("colmap/sparse/0/images.txt", images.as_bytes());
    let flags = ["--cameras", "colmap", "-o", "of_colmap/{camera}.png"];
    render(&folder, &[&flags[..], &SMALL].concat()).expect(0);
    for name in ["000.png", "001.png"] {
        assert!(differing(&folder, &format!("out/{name}"), &format!("of_colmap/{name}")) <= 2, "{name}");
    }
}

/// How many pixels of two pictures differ by more than rounding.
fn differing(folder: &Folder, a: &str, b: &str) -> usize {
    let [a, b] = [a, b].map(|name| image::open(folder.join(name)).expect("a picture").to_rgb8());
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = a.pixels().zip(b.pixels());
    pairs.filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 2)).count()
}

#[test]
fn frames_play_in_every_view() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("cameras-frames");
    folder.write("tri.glb", &triangle_glb([1.0, 0.0, 0.0]));
    folder.write("t.json", two_views().to_string().as_bytes());
    render(&folder, &[&["--cameras", "t.json", "--frames", "0..1", "-o", "out/"][..], &SMALL].concat()).expect(0);
    for name in ["tri_000_0000.png", "tri_000_0001.png", "tri_001_0000.png", "tri_001_0001.png"] {
        assert!(folder.join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn the_camera_of_an_exr_header_gives_the_picture_again() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("cameras-exr");
    folder.write("tri.glb", &triangle_glb([0.2, 0.5, 0.8]));
    let small = ["--size", "64x36", "--samples", "1"];
    for output in ["a.exr", "a.png"] {
        render(&folder, &[&["--orbit", "25,-15,6", "--fov-y", "30", "-o", output][..], &small].concat()).expect(0);
    }
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image = reader.from_file(folder.join("a.exr")).expect("EXR");
    let attributes = &image.layer_data[0].attributes;
    // For row vectors, so that its rows are the columns here; z is ahead.
    let camera_from_world = attributes.world_to_camera.expect("worldToCamera").map(f64::from);
    let view_from_world = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)) * DMat4::from_cols_array(&camera_from_world);
    let fov_y_deg = attributes.vertical_field_of_view.expect("a field of view");
    let focal_px = 18.0 / f64::from(0.5 * fov_y_deg).to_radians().tan();
    let list = json!({
        "fl_x": focal_px, "fl_y": focal_px, "cx": 32, "cy": 18, "w": 64, "h": 36,
        "frames": [frame("b", view_from_world.inverse())],
    });
    folder.write("t.json", list.to_string().as_bytes());
    let run = render(&folder, &[&["--cameras", "t.json", "-o", "{camera}.png"][..], &small].concat()).expect(0);
    assert!(!run.stderr.contains("--cameras"), "{}", run.stderr);
    // A header has 24 bits: an edge may fall on the other side of the middle of a pixel.
    let count = differing(&folder, "a.png", "b.png");
    assert!(count <= 12, "{count} pixels of 2304 differ");
}
