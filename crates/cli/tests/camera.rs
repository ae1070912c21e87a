//! From where pictures are seen: the automatic camera, turntables, scenes.

use crate::common::{Folder, Run, has_adapter, run_in, triangle_glb};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
use image::RgbaImage;
use serde_json::{Value, json};
use std::path::Path;

const SMALL: [&str; 6] = ["--size", "96x64", "--samples", "1", "--background", "transparent"];

fn render(folder: &Path, args: &[&str]) -> Run {
    run_in(folder, &[&["render"], args, &SMALL].concat())
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// How many columns or rows are free at the left, the top, the right and the bottom.
fn margins(picture: &RgbaImage) -> [u32; 4] {
    let (width, height) = picture.dimensions();
    let covered = || picture.enumerate_pixels().filter(|(.., pixel)| pixel.0[3] > 0).map(|(x, y, _)| (x, y));
    let [left, top] = [covered().map(|p| p.0).min(), covered().map(|p| p.1).min()];
    let [right, bottom] = [covered().map(|p| width - 1 - p.0).min(), covered().map(|p| height - 1 - p.1).min()];
    [left, top, right, bottom].map(|margin| margin.expect("a picture of something"))
}

/// A box of 4 × 3 × 9 m in a file with two scenes: its faces are turned inwards in one, outwards in the other.
fn two_scenes(folder: &Folder) {
    let corners = (0..8u8).flat_map(|i| [(i & 1, 4.0), (i >> 1 & 1, 3.0), (i >> 2, 9.0)]);
    let positions = corners.flat_map(|(is_far, size_m): (u8, f32)| (f32::from(is_far) * size_m).to_le_bytes());
    let outwards: [u16; 36] =
        [0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6];
    let inwards = outwards.as_chunks().0.iter().flat_map(|[a, b, c]| [*a, *c, *b]);
    let indices = outwards.into_iter().chain(inwards).flat_map(u16::to_le_bytes);
    folder.write("two.bin", &positions.chain(indices).collect::<Vec<u8>>());
    folder.write(
        "two.gltf",
        br#"{"asset":{"version":"2.0"},"scene":0,
        "scenes":[{"name":"Room","nodes":[0]},{"nodes":[1]},{"name":"Void"}],
        "nodes":[{"mesh":0},{"mesh":1}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":2}]},
            {"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[0,0,0],"max":[4,3,9]},
            {"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"},
            {"bufferView":1,"byteOffset":72,"componentType":5123,"count":36,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":96},{"buffer":0,"byteOffset":96,"byteLength":144}],
        "buffers":[{"uri":"two.bin","byteLength":240}]}"#,
    );
}

/// A triangle of 1 m, and a camera `distance_m` before it that looks at it.
fn seen_from(distance_m: f32) -> String {
    let corners: Vec<u8> =
        [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
    let uri = manypass_testkit::data_uri("application/octet-stream", &corners);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],
        "nodes":[{{"mesh":0}},{{"camera":0,"translation":[0.4,0.4,{distance_m}]}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":0.8,"znear":0.01}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":"{uri}"}}]}}"#
    )
}

#[test]
fn a_model_that_its_camera_hardly_shows_is_shown_whole() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("camera-automatic");
    folder.write("near.gltf", seen_from(2.0).as_bytes());
    folder.write("far.gltf", seen_from(20.0).as_bytes());
    let said = |model: &str, out: &str, more: &[&str]| {
        let run = render(&folder, &[&[model, "-o", out][..], more].concat()).expect(0);
        run.stderr.contains("it is shown whole; --camera 0 takes the file's")
    };
    assert!(!said("near.gltf", "near.png", &[]) && !said("near.gltf", "near0.png", &["--camera", "0"]));
    assert!(bytes(&folder, "near.png") == bytes(&folder, "near0.png"), "the file's camera shows it");
    assert!(said("far.gltf", "far.png", &[]) && !said("far.gltf", "auto.png", &["--camera", "auto"]));
    assert!(bytes(&folder, "far.png") == bytes(&folder, "auto.png"));
    // What is asked for is shown, and sequences are seen as the file says.
    assert!(
        !said("far.gltf", "far0.png", &["--camera", "0"]) && !said("far.gltf", "f{frame}.png", &["--frames", "0..0"])
    );
    assert!(
        bytes(&folder, "far0.png") == bytes(&folder, "f0.png")
            && bytes(&folder, "far0.png") != bytes(&folder, "far.png")
    );
}

/// A model with an animation of 1 s that moves a node along x.
fn sliding(model: &str, node: usize, [from, to]: [[f32; 3]; 2]) -> String {
    let floats: Vec<f32> = [&[0.0, 1.0][..], &from, &to].concat();
    let bytes: Vec<u8> = floats.into_iter().flat_map(f32::to_le_bytes).collect();
    let mut model: Value = serde_json::from_str(model).expect("JSON");
    let mut push = |key: &str, value: Value| model[key].as_array_mut().expect("a list").push(value);
    push("buffers", json!({ "byteLength": 32, "uri": manypass_testkit::data_uri("application/octet-stream", &bytes) }));
    push("bufferViews", json!({ "buffer": 1, "byteLength": 8 }));
    push("bufferViews", json!({ "buffer": 1, "byteOffset": 8, "byteLength": 24 }));
    let times = json!({ "bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1] });
    push("accessors", times);
    push("accessors", json!({ "bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3" }));
    let channel = json!({ "sampler": 0, "target": { "node": node, "path": "translation" } });
    model["animations"] = json!([{ "samplers": [{ "input": 1, "output": 2 }], "channels": [channel] }]);
    model.to_string()
}

/// Triangles in all directions around a camera.
fn field() -> String {
    let mut model: Value = serde_json::from_str(&seen_from(0.0)).expect("JSON");
    let places = (0..125).map(|i| [i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2]).filter(|place| *place != [0, 0, 0]);
    let nodes = places.map(|place| json!({ "mesh": 0, "translation": place.map(|steps| 4 * steps) }));
    let nodes: Vec<Value> = std::iter::once(json!({ "camera": 0 })).chain(nodes).collect();
    model["scenes"][0]["nodes"] = (0..nodes.len()).collect();
    model["nodes"] = nodes.into();
    model.to_string()
}

#[test]
fn the_automatic_camera_is_decided_over_the_animation_and_cameras_that_move_stay() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("camera-decided");
    folder.write("field.gltf", field().as_bytes());
    folder.write("moving.gltf", sliding(&seen_from(20.0), 1, [[0.4, 0.4, 20.0], [0.4, 0.4, 19.0]]).as_bytes());
    // One is before its camera at its first time alone, another one half of the time and not at the first.
    folder.write("leaves.gltf", sliding(&seen_from(2.0), 0, [[0.0; 3], [100.0, 0.0, 0.0]]).as_bytes());
    folder.write("comes.gltf", sliding(&seen_from(2.0), 0, [[3.0, 0.0, 0.0], [0.0; 3]]).as_bytes());
    folder.write("named.gltf", seen_from(20.0).replace(r#""cameras":[{"#, r#""cameras":[{"name":"auto","#).as_bytes());
    // It comes, too, and is not before its camera without a time.
    let beside = seen_from(2.0).replace(r#"{"mesh":0}"#, r#"{"mesh":0,"translation":[3,0,0]}"#);
    folder.write("beside.gltf", sliding(&beside, 0, [[3.0, 0.0, 0.0], [0.0; 3]]).as_bytes());
    // Whether the model is said to be shown whole, and where the camera is, of each input.
    let decided = |args: &[&str]| -> Vec<(bool, Value)> {
        render(&folder, &[args, &["-o", "out/", "--report", "r.json", "--quiet"]].concat()).expect(0);
        let text = std::fs::read_to_string(folder.join("r.json")).expect("a report");
        let lines = text.lines().map(serde_json::from_str).collect::<Result<Vec<Value>, _>>();
        let lines = lines.unwrap_or_else(|_| vec![serde_json::from_str(&text).expect("one value")]);
        let is_whole = |line: &Value| line["hints"].to_string().contains("it is shown whole; --camera 0");
        lines.iter().map(|line| (is_whole(line), line["camera"]["eye_world_m"].clone())).collect()
    };
    let is_own = |(is_whole, eye): &(bool, Value), place: [f64; 3]| {
        !is_whole && (0..3).all(|axis| (number(&eye[axis]) - place[axis]).abs() < 1e-5)
    };
    let still = decided(&["field.gltf", "moving.gltf"]);
    assert!(still[0].0 && number(&still[0].1[2]) > 10.0, "a field that is seen from within: {still:?}");
    assert!(is_own(&still[1], [0.4, 0.4, 20.0]), "a camera that moves: {still:?}");
    let [first, last] = ["0", "1"].map(|time| decided(&["leaves.gltf", "comes.gltf", "--time", time]));
    assert_eq!(first, last);
    assert!(first[0].0 && is_own(&first[1], [0.4, 0.4, 2.0]), "{first:?}");
    let still = decided(&["leaves.gltf", "beside.gltf"]);
    assert!(still[0].0 && is_own(&still[1], [0.4, 0.4, 2.0]), "stills without a time: {still:?}");
    // `auto` is the automatic camera; one of that name is asked for by its index.
    let of_file = decided(&["named.gltf", "--camera", "0"]);
    assert!(is_own(&of_file[0], [0.4, 0.4, 20.0]), "{of_file:?}");
    let automatic = decided(&["named.gltf", "--camera", "auto"]);
    assert!(!automatic[0].0 && number(&automatic[0].1[2]) < 5.0, "{automatic:?}");
}

#[test]
fn a_frame_is_the_same_alone_in_a_range_and_by_its_time_and_nothing_leaves_the_picture() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("camera-frames");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    render(&folder, &["tri.glb", "--frames", "0..4", "--fps", "4", "-o", "range{frame}.png"]).expect(0);
    render(&folder, &["tri.glb", "--frames", "4..4", "--fps", "4", "-o", "alone{frame}.png"]).expect(0);
    render(&folder, &["tri.glb", "--time", "1", "-o", "time.png"]).expect(0);
    assert!(bytes(&folder, "range4.png") == bytes(&folder, "alone4.png"));
    assert!(bytes(&folder, "range4.png") == bytes(&folder, "time.png"));
    let pictures = (0..5).map(|i| image::open(folder.join(&format!("range{i}.png"))).expect("a picture").to_rgba8());
    let margins: Vec<[u32; 4]> = pictures.map(|picture| margins(&picture)).collect();
    // All frames together are in the middle, with 6 % of 64 pixels above and below.
    let least = |side: usize| margins.iter().map(|margins| margins[side]).min().unwrap_or(0);
    assert!((3..=5).contains(&least(1)) && (3..=5).contains(&least(3)), "{margins:?}");
    assert!(least(0).abs_diff(least(2)) <= 2 && margins[0][0] + 20 < margins[4][0], "{margins:?}");
}

#[test]
fn what_is_drawn_fills_the_picture_and_lies_in_its_middle() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("camera-margins");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    two_scenes(&folder);
    for input in [&["tri.glb"][..], &["two.gltf", "--scene", "1"]] {
        for (size, limits) in [("192x48", [1, 3]), ("48x192", [0, 2])] {
            let size = ["--size", size, "--samples", "1", "--background", "transparent", "-o", "a.png"];
            run_in(&folder, &[&["render"], input, &size].concat()).expect(0);
            let margins = margins(&image::open(folder.join("a.png")).expect("a picture").to_rgba8());
            let [left, top, right, bottom] = margins;
            assert!(left.abs_diff(right) <= 1 && top.abs_diff(bottom) <= 1, "{input:?}: {margins:?}");
            // 6 % of 48 pixels, by the rasteriser's rounding.
            assert!(limits.iter().all(|side| (2..=4).contains(&margins[*side])), "{input:?}: {margins:?}");
        }
    }
}

#[test]
fn a_turntable_plays_with_frames_and_stands_still_with_a_time() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("camera-turntable");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    let turn = ["tri.glb", "--turntable", "4"];
    render(&folder, &[&turn[..], &["--frames", "0..5", "--fps", "4", "-o", "both{frame}.png"]].concat()).expect(0);
    render(&folder, &[&turn[..], &["--frames", "2..2", "--fps", "4", "-o", "alone{frame}.png"]].concat()).expect(0);
    render(&folder, &[&turn[..], &["--time", "0.5", "-o", "time{frame}.png"]].concat()).expect(0);
    assert!(bytes(&folder, "both2.png") == bytes(&folder, "alone2.png"));
    // Frame 2 is at 0.5 s, turned by half a turn; a full turn takes four frames, and the animation ends after four.
    assert!(bytes(&folder, "both2.png") == bytes(&folder, "time2.png"));
    assert!(bytes(&folder, "both1.png") != bytes(&folder, "time1.png"));
    assert!(bytes(&folder, "both1.png") != bytes(&folder, "both5.png"));
    assert!(!folder.join("time4.png").exists());

    // One frame for a full turn: nothing moves but by the animation, whose time stands still.
    let motion = |args: &[&str]| -> f32 {
        let common = ["tri.glb", "--turntable", "1", "--fps", "2", "--aov", "motion", "-o", "m{frame}.exr"];
        render(&folder, &[&common[..], args].concat()).expect(0);
        let file = folder.names().into_iter().find(|name| name.ends_with(".exr")).expect("a file");
        let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        let image = reader.from_file(folder.join(&file)).expect("EXR");
        std::fs::remove_file(folder.join(&file)).expect("removed");
        let layers = image.layer_data.iter();
        let mut named = layers.filter(|l| l.attributes.layer_name.as_ref().is_some_and(|name| name.eq("motion")));
        let channels = &named.next().expect("motion").channel_data.list;
        let largest = |samples: &FlatSamples| match samples {
            FlatSamples::F32(values) => values.iter().fold(0.0f32, |most, value| most.max(value.abs())),
            other => panic!("{other:?}"),
        };
        channels.iter().map(|channel| largest(&channel.sample_data)).fold(0.0, f32::max)
    };
    assert!(motion(&["--time", "0.5"]) < 1e-3, "the time moved");
    assert!(motion(&["--frames", "1..1"]) > 1.0, "the test cannot fail");
}

#[test]
fn scenes_are_shown_by_name_or_index_and_listed() {
    let folder = Folder::new("camera-scenes");
    two_scenes(&folder);
    let json = |args: &[&str]| -> Value {
        let run = run_in(&folder, &[&["info", "two.gltf", "--json"], args].concat()).expect(0);
        serde_json::from_str(&run.text()).expect("JSON")
    };
    assert_eq!(json(&[])["scenes"][0], serde_json::json!({ "index": 0, "name": "Room", "is_shown": true }));
    for asked in ["Void", "2"] {
        let value = json(&["--scene", asked]);
        assert_eq!((&value["triangles_drawn"], &value["scenes"][2]["is_shown"]), (&0.into(), &true.into()));
        assert!(value["warnings"][0].as_str().is_some_and(|warning| warning.contains("draws nothing")), "{value}");
    }
    for asked in ["Hall", "3", "-1", "99999999999999999999"] {
        let asked = format!("--scene={asked}");
        let run = run_in(&folder, &["info", "two.gltf", &asked]).expect(2);
        assert!(
            run.stderr.ends_with("hint: scenes by index or name: 0 `Room`, 1 (no name), 2 `Void`\n"),
            "{}",
            run.stderr
        );
    }
    folder.write("tri.glb", &triangle_glb([1.0; 3]));
    assert!(run_in(&folder, &["info", "tri.glb", "--scene", "0"]).expect(0).text().contains("triangles: 1"));
}

#[test]
fn a_room_is_seen_from_inside_with_a_hint_how_to_leave_it() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("camera-room");
    two_scenes(&folder);
    let inside = render(&folder, &["two.gltf", "-o", "inside.png"]).expect(0);
    assert!(inside.stderr.starts_with("hint: two.gltf: ") && inside.stderr.contains("--orbit"), "{}", inside.stderr);
    let picture = image::open(folder.join("inside.png")).expect("a picture").to_rgba8();
    assert!(picture.pixels().all(|pixel| pixel.0[3] == 255), "walls are everywhere");
    for args in [&["--orbit", "30,28,auto"][..], &["--scene", "1"], &["--quiet"]] {
        let run = render(&folder, &[&["two.gltf", "-o", "a.png"], args].concat()).expect(0);
        assert_eq!(run.stderr, "", "{args:?}");
    }
    let outside = image::open(folder.join("a.png")).expect("a picture").to_rgba8();
    assert_eq!(outside, picture, "only the hint is quiet");
}

#[test]
fn an_outlier_does_not_make_a_cloud_small() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("camera-outliers");
    let grid: String = (0..12 * 12 * 12).map(|i| format!("{} {} {}\n", i % 12, i / 12 % 12, i / 144)).collect();
    let cloud = |count: usize, more: &str| {
        let header = "property float x\nproperty float y\nproperty float z\nend_header\n";
        format!("ply\nformat ascii 1.0\nelement vertex {count}\n{header}{grid}{more}")
    };
    folder.write("clean.ply", cloud(1728, "").as_bytes());
    folder.write("outlier.ply", cloud(1729, "0 500 0\n").as_bytes());
    let seen = |args: &[&str]| {
        let run = render(&folder, &[args, &["-o", "a.png"]].concat()).expect(0);
        (margins(&image::open(folder.join("a.png")).expect("a picture").to_rgba8()), run.stderr)
    };
    let (clean, said) = seen(&["clean.ply"]);
    assert_eq!(said, "");
    let (outlier, said) = seen(&["outlier.ply"]);
    assert_eq!(outlier, clean);
    assert!(said.starts_with("hint: outlier.ply: 1 of its points lie far from all others") && said.contains("--orbit"));
    let (_, said) = seen(&["outlier.ply", "--eye", "30,20,30"]);
    assert_eq!(said, "");
}
