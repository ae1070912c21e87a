//! Files that are broken, lie, or mean harm: each ends in a picture or in one error, in bounded time and memory.

mod common;

use common::watch::watch;
use common::{Folder, has_adapter, run_in, triangle_glb};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

const SMALL: [&str; 6] = ["--size", "64x64", "--samples", "1", "--report", "report.jsonl"];

/// What a broken file may take at most.
const LIMIT: Duration = Duration::from_secs(10);
/// The most time of processors after which an error is there.
const CPU_LIMIT: Duration = Duration::from_secs(5);
/// The same for a small picture under tens of thousands of lights.
const CPU_LIMIT_OF_LIGHTS: Duration = Duration::from_secs(15);
/// The same for the start of the driver and a small picture.
const CPU_LIMIT_OF_PICTURE: Duration = Duration::from_secs(5);
const LIMIT_MIB: u64 = 1024;

/// The error of every input of a batch, or none where it was rendered.
fn verdicts(folder: &Path) -> BTreeMap<String, Option<String>> {
    let report = std::fs::read_to_string(folder.join("report.jsonl")).expect("report");
    let lines = report.lines().map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
    let verdict = |line: Value| {
        let error = line["error"].as_str().map(str::to_owned);
        let total_ms = line["milliseconds"]["total"].as_f64();
        assert!(total_ms.is_none_or(|ms| ms < LIMIT.as_secs_f64() * 1e3), "too slow: {line}");
        (line["input"].as_str().expect("input").to_owned(), error)
    };
    lines.map(verdict).collect()
}

/// Renders files whose stems differ in one process; gives the verdicts. Every file has its picture, or one error.
fn render(folder: &Folder, files: &[&str]) -> BTreeMap<String, Option<String>> {
    // A batch of one has another kind of report.
    folder.write("extra.glb", &triangle_glb([1.0, 1.0, 1.0]));
    let files: Vec<&str> = files.iter().copied().chain(["extra.glb"]).collect();
    let args = [&["render", "-o", "out/"], &files[..], &SMALL].concat();
    let watched = watch(folder, &args, LIMIT * files.len().min(12) as u32);
    assert!(watched.peak_mib < LIMIT_MIB, "{} MiB", watched.peak_mib);
    let verdicts = verdicts(folder);
    let drawn = verdicts.values().filter(|error| error.is_none()).count();
    // All errors of a batch together take no longer than one may.
    let cpu_limit = CPU_LIMIT + CPU_LIMIT_OF_PICTURE * drawn as u32;
    assert!(watched.cpu < cpu_limit, "{:?} of processors, and {drawn} pictures", watched.cpu);
    assert_eq!(verdicts.len(), files.len(), "{}", watched.run.stderr);
    let failed = verdicts.values().flatten().count();
    assert_eq!(watched.run.code, i32::from(failed > 0), "{}", watched.run.stderr);
    // One line for each, and one for all.
    let lines = watched.run.stderr.lines().filter(|line| line.starts_with("error: ")).count();
    assert_eq!(lines, if failed > 0 { failed + 1 } else { 0 }, "{}", watched.run.stderr);
    for (input, error) in &verdicts {
        let stem = Path::new(input).file_stem().expect("a stem").to_string_lossy();
        let picture = image::open(folder.join(&format!("out/{stem}.png"))).ok();
        match error {
            Some(error) => assert!(picture.is_none() && error.contains(input.as_str()), "{input}: {error}"),
            None => assert_eq!(picture.expect("a picture").width(), 64, "{input}"),
        }
    }
    let _ = std::fs::remove_dir_all(folder.join("out"));
    verdicts
}

fn models(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut pending) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).expect("listed") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                pending.push(path);
            } else if path.extension().is_some_and(|end| end == "gltf" || end == "glb") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

#[test]
fn every_file_of_the_broken_sets_is_drawn_or_refused_as_the_reader_says() {
    let folders = ["khronos-validator", "assimp"].map(manypass_testkit::needs::assets);
    let [Some(validator), Some(assimp)] = folders else { return };
    if !has_adapter() {
        return;
    }
    // Of the files with one stem each goes into another batch, as their pictures would have the same name.
    let mut batches: Vec<Vec<PathBuf>> = Vec::new();
    let mut seen: BTreeMap<PathBuf, usize> = BTreeMap::new();
    for path in models(&validator).into_iter().chain(models(&assimp)) {
        let batch = seen.entry(path.file_stem().expect("a stem").into()).or_default();
        batches.resize(batches.len().max(*batch + 1), Vec::new());
        batches[*batch].push(path);
        *batch += 1;
    }
    let folder = Folder::new("broken-sets");
    let (mut drawn, mut refused) = (0, 0);
    for batch in &batches {
        let files: Vec<&str> = batch.iter().map(|path| path.to_str().expect("a name in UTF-8")).collect();
        let verdicts = render(&folder, &files);
        for path in files {
            let error = &verdicts[path];
            assert_eq!(error.is_none(), manypass_scene::load_path(Path::new(path)).is_ok(), "{path}: {error:?}");
            *if error.is_none() { &mut drawn } else { &mut refused } += 1;
        }
    }
    println!("{drawn} drawn, {refused} refused");
    assert!(drawn > 150 && refused > 30);
}

/// A triangle as a `.gltf` beside `tri.bin`, with some parts replaced.
fn model(changes: Value) -> Value {
    let mut model = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }], "buffers": [{ "byteLength": 36, "uri": "tri.bin" }],
    });
    for (key, value) in changes.as_object().expect("an object") {
        model[key] = value.clone();
    }
    model
}

/// Files, and what their error contains; none where there is a picture.
#[derive(Default)]
struct Cases {
    files: Vec<(String, Vec<u8>)>,
    expected: Vec<Option<&'static str>>,
}

impl Cases {
    fn add(&mut self, bytes: impl Into<Vec<u8>>, end: &str, error: Option<&'static str>) {
        self.files.push((format!("case-{:03}.{end}", self.files.len()), bytes.into()));
        self.expected.push(error);
    }

    fn refused(&mut self, changes: Value, error: &'static str) {
        self.add(model(changes).to_string(), "gltf", Some(error));
    }

    fn drawn(&mut self, changes: Value) {
        self.add(model(changes).to_string(), "gltf", None);
    }

    /// Renders all of them and compares.
    fn check(&self, name: &str) {
        if !has_adapter() {
            return;
        }
        let folder = Folder::new(name);
        let triangle: Vec<u8> =
            [-1_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        folder.write("tri.bin", &triangle);
        for (file, bytes) in &self.files {
            folder.write(file, bytes);
        }
        let names: Vec<&str> = self.files.iter().map(|(name, _)| name.as_str()).collect();
        let verdicts = render(&folder, &names);
        for ((name, bytes), expected) in self.files.iter().zip(&self.expected) {
            let error = &verdicts[name];
            let text = String::from_utf8_lossy(&bytes[..bytes.len().min(400)]);
            match (error, expected) {
                (None, None) => {}
                (Some(error), Some(part)) => assert!(error.contains(part), "expected {part}: {error}: {text}"),
                _ => panic!("expected {expected:?}, found {error:?}: {text}"),
            }
        }
    }
}

#[test]
fn a_file_cut_off_anywhere_and_a_lying_header_are_refused() {
    let mut cases = Cases::default();
    let glb = triangle_glb([1.0, 0.0, 0.0]);
    for i in 0..24 {
        cases.add(&glb[..glb.len() * i / 24], "glb", Some(""));
    }
    for at in [8, 12, 16, glb.len() - 76] {
        let mut lying = glb.clone();
        lying[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        cases.add(lying, "glb", Some("GLB"));
    }
    cases.add(&b"glTF\x02\0\0\0\xff\xff\xff\xff"[..], "glb", Some("shorter than its header"));
    cases.add(&b"\x89PNG\r\n\x1a\n"[..], "gltf", Some("JSON"));
    cases.add("[".repeat(100_000), "gltf", Some("JSON"));
    cases.add(format!("{{\"asset\":{}", "{\"a\":".repeat(100_000)), "gltf", Some("JSON"));
    cases.add(model(json!({})).to_string().replace("\"scene\":0", "\"scene\":NaN"), "gltf", Some("JSON"));
    let text = model(json!({})).to_string();
    for i in 0..12 {
        cases.add(&text[..text.len() * i / 12], "gltf", Some(if i == 0 { "empty" } else { "JSON" }));
    }
    cases.check("cut");
}

#[test]
fn claims_and_places_that_cannot_be_are_refused() {
    let mut cases = Cases::default();
    let accessor = |count: u64, offset: u64| json!([{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": count, "byteOffset": offset }]);
    let count = "/accessors/0/count";
    cases.refused(json!({ "accessors": accessor(4, 0) }), count);
    cases.refused(json!({ "accessors": accessor(3, 4) }), count);
    cases.refused(json!({ "accessors": accessor(u64::MAX, 0) }), count);
    cases.refused(json!({ "accessors": accessor(1 << 63, 1 << 63) }), count);
    cases.refused(json!({ "accessors": accessor(u64::MAX / 12 + 1, 0) }), count);
    cases
        .refused(json!({ "accessors": [{ "componentType": 5126, "type": "VEC3", "count": 1_u64 << 32 }] }), "POSITION");
    let zeros = json!([{ "componentType": 5126, "type": "VEC3", "count": 20_000_000 }]);
    cases.refused(json!({ "accessors": zeros }), "decodes to far more");
    let shared = json!([{ "primitives": vec![json!({ "attributes": { "POSITION": 0 } }); 2000] }]);
    let many = json!([{ "componentType": 5126, "type": "VEC3", "count": 100_000 }]);
    cases.refused(json!({ "accessors": many, "meshes": shared }), "decodes to far more");
    let nodes: Vec<Value> = (0..2000).map(|_| json!({ "mesh": 0 })).collect();
    let roots: Vec<usize> = (0..2000).collect();
    cases.refused(json!({ "meshes": shared, "nodes": nodes, "scenes": [{ "nodes": roots }] }), "join meshes");
    let buffer = |bytes: u64, uri: &str| json!([{ "byteLength": bytes, "uri": uri }]);
    cases.refused(json!({ "buffers": buffer(1 << 32, "tri.bin") }), "/buffers/0/byteLength");
    cases.refused(json!({ "buffers": buffer(u64::MAX, "tri.bin") }), "/buffers/0/byteLength");
    cases.refused(json!({ "buffers": buffer(36, "gone.bin") }), "gone.bin");
    for escape in
        ["../tri.bin", "%2e%2e/tri.bin", "/dev/zero", "//etc/passwd", "file:///etc/passwd", "a/../../b", ".", ""]
    {
        cases.refused(json!({ "buffers": buffer(36, escape) }), "/buffers/0/uri");
    }
    cases.refused(json!({ "nodes": [{ "mesh": 0, "children": [0] }] }), "/nodes/0");
    cases.refused(json!({ "nodes": [{ "mesh": 0 }, { "children": [2] }, { "children": [1] }] }), "ancestor");
    cases.refused(json!({ "nodes": [{ "children": [1] }, { "children": [2] }, { "children": [1] }] }), "parent");
    cases.refused(json!({ "nodes": [{ "mesh": 0, "translation": [1e300, 0, 0] }] }), "/nodes/0/translation");
    cases.refused(json!({ "nodes": [{ "mesh": 0, "rotation": [0, 0, 0, 0] }] }), "/nodes/0/rotation");
    cases.refused(json!({ "nodes": [{ "mesh": 0, "matrix": [1, 2, 3] }] }), "/nodes/0/matrix");
    cases.refused(json!({ "extensionsRequired": ["EXT_not_there"] }), "EXT_not_there");
    cases.refused(json!({ "asset": { "version": "1.0" } }), "/asset/version");
    cases.check("claims");
}

#[test]
fn values_of_the_wrong_type_are_refused_with_their_place() {
    let mut cases = Cases::default();
    let keys = ["scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers", "images", "textures", "materials"];
    for key in keys.into_iter().chain(["cameras", "skins", "animations", "samplers"]) {
        for wrong in [json!(null), json!(5), json!("x"), json!({ "a": [] }), json!([5]), json!([null]), json!([[]])] {
            cases.refused(json!({ key: wrong }), key);
        }
    }
    for (key, wrong) in [("asset", json!([])), ("scene", json!(-1)), ("scene", json!(1.5)), ("extensions", json!(1))] {
        cases.refused(json!({ key: wrong }), key);
    }
    cases.check("types");
}

#[test]
fn strange_but_possible_scenes_are_drawn() {
    let mut cases = Cases::default();
    cases.add(r#"{"asset":{"version":"2.0"}}"#, "gltf", None);
    cases.drawn(json!({ "scenes": [{}] }));
    cases.drawn(json!({ "meshes": [{ "primitives": [] }] }));
    for mode in 0..4 {
        cases.drawn(json!({ "meshes": [{ "primitives": [{ "mode": mode, "attributes": { "POSITION": 0 } }] }] }));
    }
    let node = |key: &str, value: Value| json!({ "nodes": [{ "mesh": 0, key: value }] });
    for scale in [0.0, 1e-40, 1e-20, -1.0, 1e20, 3e38] {
        cases.drawn(node("scale", json!([scale, scale, scale])));
        cases.drawn(node("translation", json!([scale, -scale, scale])));
    }
    cases.drawn(node("matrix", json!([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1])));
    let chain = |length: usize, scale: f32| -> Value {
        let node = |i: usize| {
            if i + 1 < length {
                json!({ "children": [i + 1], "scale": [scale, scale, 1] })
            } else {
                json!({ "mesh": 0 })
            }
        };
        (0..length).map(node).collect()
    };
    cases.drawn(json!({ "nodes": chain(1000, 2.0) }));
    cases.drawn(json!({ "nodes": chain(100_000, 1.0) }));
    let crowd: Value =
        (0..100_000).map(|i| json!({ "mesh": 0, "translation": [3 * (i % 300), 3 * (i / 300), 0] })).collect();
    cases.drawn(json!({ "nodes": crowd, "scenes": [{ "nodes": (0..100_000).collect::<Vec<_>>() }] }));
    for value in [f32::NAN, f32::INFINITY, 3e38, 1e-40] {
        let bytes: Vec<u8> =
            [-value, -value, 0.0, value, -value, 0.0, 0.0, value, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let percent: String = bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
        cases.drawn(json!({ "buffers": [{ "byteLength": 36, "uri": format!("data:,{percent}") }] }));
    }
    for lens in [json!({ "yfov": 100, "znear": 1e-38 }), json!({ "yfov": 1e-30, "znear": 3e38 })] {
        cases
            .drawn(json!({ "nodes": [{ "mesh": 0 }, { "camera": 0, "scale": [0, 0, 0], "translation": [0, 0, 3e38] }],
            "scenes": [{ "nodes": [0, 1] }], "cameras": [{ "type": "perspective", "perspective": lens }] }));
    }
    let surface =
        json!([{ "emissiveFactor": [3e38, 0, -1], "pbrMetallicRoughness": { "baseColorFactor": [-5, 1e30, 0, 9] } }]);
    cases.drawn(json!({ "materials": surface, "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }] }));
    cases.check("strange");
}

/// A PNG with the header of a large picture and the texels of a small one.
fn lying_png(side: u32) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbaImage::new(2, 2).write_to(&mut bytes, image::ImageFormat::Png).expect("encoded");
    let mut file = bytes.into_inner();
    file[16..20].copy_from_slice(&side.to_be_bytes());
    file[20..24].copy_from_slice(&side.to_be_bytes());
    let crc = file[12..29].iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    });
    file[29..33].copy_from_slice(&(!crc).to_be_bytes());
    file
}

#[test]
fn images_that_are_bombs_missing_or_elsewhere_are_white() {
    let mut cases = Cases::default();
    let textured = |count: usize, uri: &str| {
        let list = |item: &dyn Fn(usize) -> Value| (0..count).map(item).collect::<Value>();
        json!({
            "images": list(&|_| json!({ "uri": uri })), "textures": list(&|i| json!({ "source": i })),
            "materials": list(&|i| json!({ "emissiveTexture": { "index": i }, "emissiveFactor": [1, 1, 1] })),
            "meshes": [{ "primitives": list(&|i| json!({ "attributes": { "POSITION": 0 }, "material": i })) }],
        })
    };
    for uri in
        ["gone.png", "../secret.png", "/dev/zero", "data:,", "data:image/png;base64,AAAA", "http://localhost/a.png"]
    {
        cases.drawn(textured(1, uri));
    }
    for side in [0, 4096, 16384, 100_000, u32::MAX] {
        let percent: String = lying_png(side).iter().map(|byte| format!("%{byte:02x}")).collect();
        cases.drawn(textured(1, &format!("data:,{percent}")));
    }
    cases.check("bombs");
}

/// A model with this many lights in a grid above the triangle.
fn lit(count: usize, kind: &str, range_m: Option<f32>) -> Value {
    let node = |i: usize| match i.checked_sub(1) {
        None => json!({ "mesh": 0 }),
        Some(light) => {
            json!({ "translation": [(light % 300) as f32 / 150.0 - 1.0, (light / 300) as f32 / 150.0 - 1.0, 0.1],
            "extensions": { "KHR_lights_punctual": { "light": light } } })
        }
    };
    let mut light = json!({ "type": kind, "intensity": 0.01, "color": [1, 0, 0] });
    if let Some(range_m) = range_m {
        light["range"] = json!(range_m);
    }
    model(json!({
        "nodes": (0..=count).map(node).collect::<Vec<_>>(), "scenes": [{ "nodes": (0..=count).collect::<Vec<_>>() }],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": vec![light; count] } },
    }))
}

#[test]
fn more_lights_than_sixteen_bits_count_are_drawn() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("lights");
    let triangle = [-1_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes);
    folder.write("tri.bin", triangle.as_flattened());
    folder.write("points.gltf", lit(70_000, "point", Some(0.1)).to_string().as_bytes());
    folder.write("suns.gltf", lit(70_000, "directional", None).to_string().as_bytes());
    // Every one of them casts its shadow, in several rounds of the atlas; those without a range on all that is seen.
    folder.write("everywhere.gltf", lit(16_000, "point", None).to_string().as_bytes());
    folder.write("shadowed.gltf", lit(3_000, "point", Some(0.1)).to_string().as_bytes());
    let bare = ["--size", "16x16", "--samples", "1", "--report", "report.json", "--set"];
    for (file, setting) in [
        ("points.gltf", "shadows.enabled=false"),
        ("suns.gltf", "shadows.enabled=false"),
        ("everywhere.gltf", "shadows.enabled=true"),
        ("shadowed.gltf", "shadows.atlas_px=512"),
    ] {
        let args = [&["render", file], &bare[..], &[setting]].concat();
        let watched = watch(&folder, &args, 3 * LIMIT);
        assert!(watched.peak_mib < LIMIT_MIB && watched.run.code == 0, "{file}: {} MiB", watched.peak_mib);
        // 5 s were measured for those everywhere.
        assert!(watched.cpu < CPU_LIMIT_OF_LIGHTS, "{file}: {:?} of processors", watched.cpu);
    }
    let report = std::fs::read_to_string(folder.join("report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    let shadows = &report["shadows"];
    assert_eq!((&shadows["lights_beyond_atlas"], report["lights"].as_u64()), (&0.into(), Some(3_000)), "{shadows}");
    assert!(shadows["light_rounds"].as_u64() > Some(1), "{shadows}");
}

#[test]
fn a_scene_without_triangles_or_lights_shows_its_background() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("background");
    folder.write("none.gltf", br#"{"asset":{"version":"2.0"},"scenes":[{}],"scene":0}"#);
    let args =
        ["render", "none.gltf", "--background", "ff0000", "--tonemap", "none", "--size", "8x8", "--samples", "1"];
    let run = run_in(&folder, &args).expect(0);
    assert!(run.stderr.starts_with("warning: none.gltf") && run.stderr.contains("draws nothing"), "{}", run.stderr);
    let picture = image::open(folder.join("none.png")).expect("a picture").to_rgba8();
    assert!(picture.pixels().all(|p| p.0[0] >= 253 && p.0[1] <= 2 && p.0[2] <= 2), "{:?}", picture.get_pixel(0, 0));
    let args = ["render", "none.gltf", "--background", "transparent", "--size", "8x8", "--samples", "1", "-o", "t.png"];
    run_in(&folder, &args).expect(0);
    assert!(image::open(folder.join("t.png")).expect("a picture").to_rgba8().pixels().all(|p| p.0[3] == 0));
}
