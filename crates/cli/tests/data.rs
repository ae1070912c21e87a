//! Data that others can use: cameras, names of ids, hashes and ranges, from reports, `info` and headers of files.

use crate::common::{Folder, has_adapter, python, run_in, triangle_glb};
use exr::prelude::{AttributeValue, FlatImage, FlatSamples, ReadChannels, ReadLayers, Text, read};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// A small picture of the triangle through a camera that looks at it from the side.
const RENDER: [&str; 8] = ["render", "tri.glb", "--size", "64x36", "--samples", "1", "--orbit", "25,-15,6"];

fn render(folder: &Folder, args: &[&str]) {
    folder.write("tri.glb", &triangle_glb([0.2, 0.5, 0.8]));
    run_in(folder, &[&RENDER[..], args].concat()).expect(0);
}

fn opened(path: &Path) -> FlatImage {
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    reader.from_file(path).expect("EXR")
}

/// The channels of a part as floats, by name.
fn values(image: &FlatImage, part: &str) -> BTreeMap<String, Vec<f64>> {
    let named = image.layer_data.iter().find(|l| l.attributes.layer_name.as_ref().is_some_and(|name| name.eq(part)));
    let channels = &named.unwrap_or_else(|| panic!("no part {part}")).channel_data.list;
    let floats = |samples: &FlatSamples| match samples {
        FlatSamples::F32(values) => values.iter().map(|value| f64::from(*value)).collect(),
        FlatSamples::U32(values) => values.iter().map(|value| f64::from(*value)).collect(),
        FlatSamples::F16(_) => panic!("{part} has half floats"),
    };
    channels.iter().map(|channel| (channel.name.to_string(), floats(&channel.sample_data))).collect()
}

fn report(folder: &Folder) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join("r.json")).expect("a report")).expect("JSON")
}

/// Row vector times matrix, divided by w.
fn row_times(p: [f64; 3], matrix: &[f32; 16]) -> [f64; 3] {
    let sum = |column: usize| {
        (0..3).map(|row| p[row] * f64::from(matrix[row * 4 + column])).sum::<f64>() + f64::from(matrix[12 + column])
    };
    [0, 1, 2].map(|column| sum(column) / sum(3))
}

#[test]
fn cameras_and_positions_far_from_the_origin_are_those_of_the_file() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("data-far");
    let offset = [432_100.0, 200.0, -5_512_345.0];
    let drawn = |name: &str, [x, y, z]: [f64; 3]| {
        let corner = |[u, v]: [f64; 2]| format!("v {} {} {z}\n", x + u, y + v);
        let corners = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]].map(corner).concat();
        folder.write(&format!("{name}.obj"), (corners + "f 1 2 3 4\n").as_bytes());
        let (eye, target) = (format!("--eye={x},{y},{}", z + 10.0), format!("--target={x},{y},{z}"));
        let (input, output) = (format!("{name}.obj"), format!("{name}.exr"));
        let args = ["render", &input, "-o", &output, "--aov", "position", "--size", "32x32", "--samples", "1"];
        run_in(&folder, &[&args[..], &["--ground", "none", "--report", "r.json", &eye, &target]].concat()).expect(0);
        (values(&opened(&folder.join(&output)), "position"), report(&folder)["camera"]["eye_world_m"].clone())
    };
    let (near, _) = drawn("near", [0.0; 3]);
    let (far, eye) = drawn("far", offset);
    assert_eq!(eye, json!([offset[0], offset[1], offset[2] + 10.0]));
    // Floats are 1/32 m apart there in x.
    let is_same = |at: &usize| (far["X"][*at] - near["X"][*at] - offset[0]).abs() < 0.016;
    let inside: Vec<usize> = (0..32 * 32).filter(|at| far["Z"][*at] == offset[2]).collect();
    assert!(inside.len() > 100 && inside.iter().all(is_same), "{}", inside.len());
    assert!((0..32 * 32).all(|at| inside.contains(&at) || far["Z"][at] == 0.0), "the background has no place");
}

#[test]
fn cameras_of_headers_and_report_see_positions_at_their_pixels() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("data-camera");
    render(&folder, &["-o", "a.exr", "--aov", "position,depth", "--far", "50", "--report", "r.json"]);
    let image = opened(&folder.join("a.exr"));
    let (position, depth) = (values(&image, "position"), values(&image, "depth"));
    let report = report(&folder);
    let camera = &report["camera"];
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"));
    let row = |matrix: &Value, row: usize, p: [f64; 3]| {
        (0..3).map(|column| number(&matrix[row][column]) * p[column]).sum::<f64>()
    };
    let mut covered = 0;
    for at in (0..64 * 36).filter(|at| depth["Z"][*at].is_finite()) {
        covered += 1;
        let p = ["X", "Y", "Z"].map(|axis| position[axis][at]);
        let pixel = [(at % 64) as f64 + 0.5, (at / 64) as f64 + 0.5];
        let near = |x: f64, y: f64| (x - pixel[0]).abs() < 1e-3 && (y - pixel[1]).abs() < 1e-3;
        for part in &image.layer_data {
            let to_camera = row_times(p, &part.attributes.world_to_camera.expect("worldToCamera"));
            assert!((to_camera[2] - depth["Z"][at]).abs() < 1e-4, "z is ahead: {to_camera:?}");
            let ndc = row_times(p, &part.attributes.world_to_normalized_device.expect("worldToNDC"));
            assert!(near(ndc[0] * 64.0, ndc[1] * 36.0) && (0.0..=1.0).contains(&ndc[2]), "{ndc:?}");
        }
        let cv = &camera["opencv"];
        let seen = [0, 1, 2].map(|axis| row(&cv["rotation"], axis, p) + number(&cv["translation_m"][axis]));
        let project = |axis: usize, f: &str, c: &str| number(&cv[f]) * seen[axis] / seen[2] + number(&cv[c]);
        assert!(near(project(0, "fx", "cx"), project(1, "fy", "cy")), "{seen:?}");
        let view_z = row(&camera["view_from_world"], 2, p) + number(&camera["view_from_world"][2][3]);
        assert!((view_z + depth["Z"][at]).abs() < 1e-4, "view space looks along -z");
        let matrix = &camera["pixel_from_world"];
        let [x, y, w] = [0, 1, 3].map(|axis| row(matrix, axis, p) + number(&matrix[axis][3]));
        assert!(near(x / w, y / w));
    }
    assert!(covered > 50);
    let attributes = &image.layer_data[0].attributes;
    assert_eq!((attributes.far_clip_plane, number(&camera["far_m"])), (Some(50.0), 50.0));
    assert!((f64::from(attributes.near_clip_plane.expect("near")) - number(&camera["near_m"])).abs() < 1e-6);
    assert!((attributes.vertical_field_of_view.expect("field of view") - 45.0).abs() < 1e-4);
    let eye = camera["eye_world_m"].as_array().expect("eye").iter().map(|value| number(value).powi(2)).sum::<f64>();
    assert!((eye.sqrt() - 6.0).abs() < 1e-4);
    let Some(AttributeValue::Text(text)) = attributes.other.get(&Text::from("manypass/camera")) else {
        panic!("the header has no camera")
    };
    assert_eq!(serde_json::from_str::<Value>(&text.to_string()).expect("JSON"), *camera);
}

#[test]
fn ids_have_names_in_headers_and_info() {
    let folder = Folder::new("data-ids");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 1.0]));
    let info: Value =
        serde_json::from_str(&run_in(&folder, &["info", "tri.glb", "--json"]).expect(0).text()).expect("");
    assert_eq!(info["nodes"], json!([{ "index": 0, "name": "tri", "mesh": 0, "parent": null }]));
    assert_eq!(info["materials"], json!([{ "index": 0, "name": "paint", "layers": [], "shading": "deferred" }]));
    assert!(info["automatic_camera"]["opencv"]["fx"].as_f64() > Some(0.0) && info["cameras"] == json!([]));
    let text = run_in(&folder, &["info", "tri.glb"]).expect(0).text();
    assert!(text.contains("nodes: 1\n") && text.contains("  paint\n") && !text.contains("view from world"), "{text}");
    if !has_adapter() {
        return;
    }
    render(&folder, &["-o", "a.exr", "--aov", "object_id,material_id"]);
    let image = opened(&folder.join("a.exr"));
    let manifest = |part: usize, name: &str| match image.layer_data[part].attributes.other.get(&Text::from(name)) {
        Some(AttributeValue::Text(text)) => serde_json::from_str::<Value>(&text.to_string()).expect("JSON"),
        other => panic!("{name} of part {part} is {other:?}"),
    };
    for part in [0, 1] {
        assert_eq!(manifest(part, "manypass/object_id/manifest"), json!({ "1": "tri" }));
    }
    for part in [0, 2] {
        assert_eq!(manifest(part, "manypass/material_id/manifest"), json!({ "1": "paint", "2": "default" }));
    }
}

#[test]
fn a_report_says_what_was_read_done_and_written() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("data-report");
    let flags = ["--aov", "depth,motion,object_id", "--time", "0.5", "--set", "render.scale=2", "--report", "r.json"];
    render(
        &folder,
        &[&flags[..], &["-o", "a.png", "--contact-sheet", "sheet.png", "--dump-passes", "passes"]].concat(),
    );
    let report = report(&folder);
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert!(report["arguments"].as_array().expect("arguments").contains(&json!("--aov")));
    assert_eq!((&report["time_secs"], &report["settings"]["render"]["scale"]), (&json!(0.5), &json!(2.0)));
    let file = &report["input_files"][0];
    assert_eq!((&file["path"], file["sha256"].as_str().expect("a hash").len()), (&json!("tri.glb"), 64));
    assert_eq!(file["bytes"], folder.join("tri.glb").metadata().expect("there").len());
    let outputs = &report["outputs"];
    assert_eq!((&outputs["picture"], &outputs["contact_sheet"]), (&json!("a.png"), &json!("sheet.png")));
    assert_eq!(outputs["aovs"]["depth"], "a.depth.png");
    let written =
        outputs["passes"].as_array().expect("passes").iter().chain(outputs["aovs"].as_object().expect("").values());
    for path in written {
        assert!(folder.join(path.as_str().expect("a path")).is_file(), "{path}");
    }
    // The passes of variables are in the plan, and were measured.
    let has = |list: &Value, name: &str| {
        list.as_array().expect("a list").iter().any(|pass| {
            let pass = pass.get("name").unwrap_or(pass).as_str().expect("a name");
            pass == name || pass.ends_with(&format!("/{name}"))
        })
    };
    for name in ["ids", "motion"] {
        assert!(has(&report["plan"]["passes"], name) && has(&report["passes"], name), "{name}: {}", report["plan"]);
    }
    assert_eq!(report["texture_bytes"], report["plan"]["bytes"]["aliased"]);

    // The passes are those of the samples that were drawn, as `graph` shows them: radiance has a mean of its own.
    let flags = ["tri.glb", "--size", "16x16", "--samples", "2", "--aov", "radiance"];
    run_in(&folder, &[&["render"], &flags[..], &["-o", "b.png", "--report", "b.json"]].concat()).expect(0);
    let graph = run_in(&folder, &[&["graph"], &flags[..], &["--format", "json"]].concat()).expect(0).text();
    let [graph, report] = [graph, std::fs::read_to_string(folder.join("b.json")).expect("a report")]
        .map(|text| serde_json::from_str::<Value>(&text).expect("JSON"));
    let names = |passes: &Value| -> Vec<Value> {
        passes.as_array().expect("passes").iter().map(|pass| pass["name"].clone()).collect()
    };
    assert_eq!(report["plan"]["passes"], json!(names(&graph["plan"]["passes"])));
    assert!(has(&report["passes"], "accumulate.radiance"), "{}", report["passes"]);
}

/// The values of a PNG of a variable, channel by channel, as `docs/aovs.md` says.
fn decoded(path: &Path, info: &manypass::AovInfo, range: &Value) -> (Vec<Vec<f64>>, f64) {
    let picture = image::open(path).unwrap_or_else(|error| panic!("{}: {error}", info.name));
    let is_8_bit = matches!(picture.color(), image::ColorType::L8 | image::ColorType::Rgb8);
    let pixels: Vec<[f64; 4]> = picture.to_rgba16().pixels().map(|pixel| pixel.0.map(f64::from)).collect();
    let number = |end: &str, channel: usize| {
        let list = range[end].as_array().unwrap_or_else(|| panic!("{} has no {end}", info.name));
        list[channel.min(list.len() - 1)].as_f64().expect("a number")
    };
    let mut step = 0.0f64;
    let channels = (0..info.channels.len()).map(|channel| {
        let words = pixels.iter().map(|pixel| pixel[channel] / if is_8_bit { 257.0 } else { 1.0 });
        words
            .zip(&pixels)
            .map(|(v, pixel)| match info.png {
                manypass::PngEncoding::Srgb8 => {
                    let s = v / 255.0;
                    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
                }
                manypass::PngEncoding::Unit8 => v / 255.0,
                manypass::PngEncoding::Signed16 if pixel[..3] == [0.0; 3] => 0.0,
                manypass::PngEncoding::Signed16 => 2.0 * v / 65535.0 - 1.0,
                manypass::PngEncoding::Range16 => {
                    step = step.max((number("high", channel) - number("low", channel)) / 65534.0);
                    if v == 65535.0 {
                        f64::INFINITY
                    } else {
                        number("low", channel) + v / 65534.0 * (number("high", channel) - number("low", channel))
                    }
                }
                manypass::PngEncoding::Symmetric16 => {
                    step = step.max(number("high", channel) / 32767.0);
                    (v - 32768.0) / 32767.0 * number("high", channel)
                }
                manypass::PngEncoding::Maximum16 if channel == 3 => v / 65535.0,
                manypass::PngEncoding::Maximum16 => {
                    let alpha = if info.channels.len() == 4 { pixel[3] / 65535.0 } else { 1.0 };
                    step = step.max(number("high", channel) / 65535.0);
                    v / 65535.0 * number("high", channel) * alpha
                }
                manypass::PngEncoding::Id16 => v,
            })
            .collect()
    });
    (channels.collect(), step.max(1.0 / 65535.0))
}

#[test]
fn png_files_give_back_the_values_of_exr() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("data-png");
    let flags = ["--aov", "all", "--time", "0.5", "--fps", "5", "--report", "r.json", "--background", "transparent"];
    render(&folder, &[&flags[..], &["-o", "a.exr"]].concat());
    render(&folder, &[&flags[..], &["-o", "a.{aov}.png"]].concat());
    let (image, report) = (opened(&folder.join("a.exr")), report(&folder));
    let background: Vec<bool> = values(&image, "depth")["Z"].iter().map(|depth_m| depth_m.is_infinite()).collect();
    assert!(background.contains(&true) && background.contains(&false));
    for aov in manypass::Aov::ALL {
        let info = aov.info();
        let path = folder.join(&format!("a.{}.png", info.name));
        let bytes = std::fs::read(&path).expect("a file");
        let is_picture = info.png == manypass::PngEncoding::Srgb8;
        for chunk in [b"sRGB", b"gAMA", b"iCCP"] {
            let has_chunk = bytes.windows(4).any(|window| window == chunk);
            assert_eq!(has_chunk, is_picture && chunk == b"sRGB", "{}", info.name);
        }
        let (channels, step) = decoded(&path, info, &report["aov_ranges"][info.name]);
        let expected = values(&image, info.name);
        for (name, found) in info.channels.iter().zip(channels) {
            for (at, (found, expected)) in found.iter().zip(&expected[*name]).enumerate() {
                let is_nothing = info.png == manypass::PngEncoding::Range16 && background[at];
                // Alpha, by which radiance is multiplied, is rounded too.
                let near = (found - expected).abs() <= 1.01 * step;
                assert!(
                    if is_nothing { found.is_infinite() } else { near },
                    "{} {name}: {found} {expected}",
                    info.name
                );
            }
        }
    }
    assert_eq!(report["depth_range_m"][1], report["aov_ranges"]["depth"]["high"][0]);
}

#[test]
fn ids_that_16_bits_do_not_hold_are_refused_before_rendering() {
    let folder = Folder::new("data-many");
    let nodes = vec![json!({ "mesh": 0 }); 65_535];
    let glb = triangle_glb([1.0, 1.0, 1.0]);
    let length = u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]) as usize;
    let mut model: Value = serde_json::from_slice(&glb[20..20 + length]).expect("JSON");
    model["nodes"] = Value::Array(nodes);
    let digits = |byte: &u8| format!("%{byte:02x}");
    let uri: String = glb[28 + length..].iter().map(digits).collect();
    model["buffers"][0]["uri"] = format!("data:application/octet-stream,{uri}").into();
    folder.write("many.gltf", model.to_string().as_bytes());
    if !has_adapter() {
        return;
    }
    let args = ["render", "many.gltf", "--size", "16x16", "--samples", "1", "--aov", "object_id", "-o"];
    let refused = run_in(&folder, &[&args[..], &["a.png"]].concat()).expect(2);
    assert!(refused.stderr.contains("65535") && refused.stderr.contains("write .exr"), "{}", refused.stderr);
    assert_eq!(folder.names(), ["many.gltf"]);
    run_in(&folder, &[&args[..], &["a.exr"]].concat()).expect(0);
}

#[test]
fn the_same_call_writes_the_same_bytes_to_a_file_and_to_standard_output() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("data-bytes");
    render(&folder, &["-o", "a.exr", "--aov", "all"]);
    render(&folder, &["-o", "b.exr", "--aov", "all"]);
    let read = |name: &str| std::fs::read(folder.join(name)).expect("a file");
    assert!(read("a.exr") == read("b.exr"));
    let piped = run_in(&folder, &[&RENDER[..], &["-o", "-", "--format", "exr", "--aov", "all"]].concat()).expect(0);
    assert!(piped.stdout == read("a.exr"));
}

#[test]
fn a_script_finds_the_motion_of_a_turntable_from_depth_and_cameras() {
    if !has_adapter() {
        return;
    }
    let Some(python) = python(&["numpy", "OpenEXR"]) else {
        manypass_testkit::needs::skip("no Python with NumPy and OpenEXR; `cargo xtask setup` brings them");
        return;
    };
    let folder = Folder::new("data-flow");
    render(&folder, &["--turntable", "24", "-o", "t{frame:02}.exr", "--aov", "depth,motion"]);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/examples/flow_from_depth.py");
    let run = |before: &str, now: &str| {
        let output = Command::new(&python).arg(&script).args([before, now]).current_dir(&*folder).output();
        let output = output.expect("Python starts");
        (output.status.success(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (agrees, said) = run("t04.exr", "t05.exr");
    assert!(agrees, "{said}");
    // The test can fail: the wrong way round, and with a frame too early.
    assert!(!run("t05.exr", "t04.exr").0 && !run("t03.exr", "t05.exr").0);
}

#[test]
fn info_gives_the_bounds_of_what_is_drawn() {
    let folder = Folder::new("data-bounds");
    // A triangle of 30 by 180 cm, which its skin shows in metres whatever its own node says (glTF 2.0, section 3.7.3.3).
    let positions = [[-30.0_f32, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 180.0, 0.0]];
    let weights = [[1.0_f32, 0.0, 0.0, 0.0]; 3];
    let mut buffer: Vec<u8> = positions.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    buffer.extend(weights.iter().flatten().flat_map(|value| value.to_le_bytes()));
    buffer.extend([0_u8; 12]);
    let model = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [2] }],
        "nodes": [{}, { "mesh": 0, "skin": 0, "translation": [500, 0, 0] }, { "children": [0, 1], "scale": [0.01, 0.01, 0.01] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "WEIGHTS_0": 1, "JOINTS_0": 2 } }] }],
        "skins": [{ "joints": [0] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC4" },
            { "bufferView": 0, "byteOffset": 84, "componentType": 5121, "count": 3, "type": "VEC4" },
        ],
        "bufferViews": [{ "buffer": 0, "byteLength": buffer.len() }],
        "buffers": [{ "uri": "b.bin", "byteLength": buffer.len() }],
    });
    folder.write("b.bin", &buffer);
    folder.write("skinned.gltf", model.to_string().as_bytes());
    let info: Value =
        serde_json::from_str(&run_in(&folder, &["info", "skinned.gltf", "--json"]).expect(0).text()).expect("JSON");
    let corner = |key: &str| -> Vec<f64> {
        let corner = info["bounds_m"][key].as_array().into_iter().flatten();
        corner.filter_map(Value::as_f64).map(|value| (value * 1000.0).round() / 1000.0).collect()
    };
    assert_eq!((corner("min"), corner("max")), (vec![-0.3, 0.0, 0.0], vec![0.3, 1.8, 0.0]));
}

/// A sheet of 0.6 m by 1.8 m in a file. Its accessors are positions, indices, joints (all of them the first), and then
/// `more` of floats, with the count of their components; `shown` says how it is shown.
fn sheet(folder: &Folder, name: &str, more: &[(usize, &[f32])], shown: &Value) {
    let positions = [-0.3_f32, 0.0, 0.0, 0.3, 0.0, 0.0, 0.3, 1.8, 0.0, -0.3, 1.8, 0.0];
    let mut buffer: Vec<u8> = positions.into_iter().flat_map(f32::to_le_bytes).collect();
    buffer.extend([0_u16, 1, 2, 0, 2, 3].into_iter().flat_map(u16::to_le_bytes));
    let mut views =
        vec![json!({ "buffer": 0, "byteLength": 48 }), json!({ "buffer": 0, "byteOffset": 48, "byteLength": 12 })];
    let mut accessors = vec![
        json!({ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" }),
        json!({ "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" }),
        json!({ "componentType": 5121, "count": 4, "type": "VEC4" }),
    ];
    for (index, (components, values)) in more.iter().enumerate() {
        let (kind, count) = (format!("VEC{components}"), values.len() / components);
        views.push(json!({ "buffer": 0, "byteOffset": buffer.len(), "byteLength": values.len() * 4 }));
        accessors.push(json!({ "bufferView": index + 2, "componentType": 5126, "count": count, "type": kind }));
        buffer.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    }
    let mut model = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "materials": [{ "doubleSided": true }],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{ "uri": format!("{name}.bin"), "byteLength": buffer.len() }],
    });
    for (key, value) in shown.as_object().into_iter().flatten() {
        model[key] = value.clone();
    }
    folder.write(&format!("{name}.bin"), &buffer);
    folder.write(&format!("{name}.gltf"), model.to_string().as_bytes());
}

#[test]
fn bounds_of_skins_morphs_and_instances_are_those_of_positions_in_pictures() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("data-bounds-drawn");
    let mesh = |attributes: Value, targets: Value| {
        let primitive = json!({ "attributes": attributes, "targets": targets, "indices": 1, "material": 0 });
        json!([{ "primitives": [primitive] }])
    };
    let skinned = json!({
        "nodes": [
            { "children": [1, 2], "scale": [2, 0.5, 1] }, {}, { "mesh": 0, "skin": 0, "translation": [500, 0, 0] },
        ],
        "meshes": mesh(json!({ "POSITION": 0, "WEIGHTS_0": 3, "JOINTS_0": 2 }), json!([])),
        "skins": [{ "joints": [1] }],
    });
    sheet(&folder, "skinned", &[(4, &[1.0, 0.0, 0.0, 0.0].repeat(4))], &skinned);
    let morphed = json!({
        "nodes": [{ "mesh": 0, "weights": [0.5] }],
        "meshes": mesh(json!({ "POSITION": 0 }), json!([{ "POSITION": 3 }])),
    });
    sheet(&folder, "morphed", &[(3, &[0.0, 0.0, 0.0, 2.0, 0.0, 0.5, 2.0, -1.0, 0.5, 0.0, -1.0, 0.0])], &morphed);
    let attributes = json!({ "TRANSLATION": 3, "SCALE": 4 });
    let instanced = json!({
        "extensionsUsed": ["EXT_mesh_gpu_instancing"],
        "nodes": [{ "mesh": 0, "translation": [0, 0.25, 0],
            "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } } }],
        "meshes": mesh(json!({ "POSITION": 0 }), json!([])),
    });
    let places: [&[f32]; 2] = [&[-3.0, 0.0, 0.0, 1.0, 1.0, 0.0], &[1.0, 1.0, 1.0, 2.0, 0.5, 1.0]];
    sheet(&folder, "instanced", &places.map(|values| (3_usize, values)), &instanced);
    let inputs = ["skinned.gltf", "morphed.gltf", "instanced.gltf"];
    // A pixel is an eighth of a metre.
    let flags =
        "--format exr --aov position,depth --eye 0,1,20 --target 0,1,0 --ortho-height 8 --size 64x64 --samples 1";
    let flags: Vec<&str> = flags.split(' ').chain(["-o", "out/"]).collect();
    run_in(&folder, &[&["render"], &inputs[..], &flags[..]].concat()).expect(0);
    let expected = [
        [[-0.6, 0.0, 0.0], [0.6, 0.9, 0.0]],
        [[-0.3, 0.0, 0.0], [1.3, 1.3, 0.25]],
        [[-3.3, 0.25, 0.0], [1.6, 2.15, 0.0]],
    ];
    for (input, [low, high]) in inputs.into_iter().zip(expected) {
        let info: Value =
            serde_json::from_str(&run_in(&folder, &["info", input, "--json"]).expect(0).text()).expect("JSON");
        let image = opened(&folder.join("out").join(input.replace("gltf", "exr")));
        let (position, depth) = (values(&image, "position"), values(&image, "depth"));
        let covered: Vec<usize> = (0..64 * 64).filter(|at| depth["Z"][*at].is_finite()).collect();
        for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            let [least, most] = ["min", "max"].map(|key| info["bounds_m"][key][axis].as_f64().unwrap_or(f64::NAN));
            assert!(
                (least - low[axis]).abs() < 1e-6 && (most - high[axis]).abs() < 1e-6,
                "{input} {name}: {least} {most}"
            );
            let seen = covered.iter().map(|at| position[name][*at]);
            let (first, last) = (seen.clone().fold(f64::INFINITY, f64::min), seen.fold(f64::NEG_INFINITY, f64::max));
            let (below, above) = (first - least, most - last);
            assert!((-1e-4..0.126).contains(&below), "{input} {name}: {first} is seen, and {least} is said");
            assert!((-1e-4..0.126).contains(&above), "{input} {name}: {last} is seen, and {most} is said");
        }
    }
}
