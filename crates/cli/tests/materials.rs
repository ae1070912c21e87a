//! Materials on the command line: variants, and what reports and `info` say of layers.

use crate::common::{self, Folder, has_adapter, run_in};

/// A triangle, red; blue with a clear coat in the variant `wet`.
const VARIANTS: &str = r#"{
    "asset": { "version": "2.0" },
    "extensionsUsed": ["KHR_materials_variants", "KHR_materials_clearcoat", "KHR_materials_unlit"],
    "extensions": { "KHR_materials_variants": { "variants": [{ "name": "dry" }, { "name": "wet" }] } },
    "scenes": [{ "nodes": [0] }],
    "nodes": [{ "mesh": 0 }],
    "meshes": [{ "primitives": [{
        "attributes": { "POSITION": 0, "NORMAL": 1 },
        "material": 0,
        "extensions": { "KHR_materials_variants": { "mappings": [{ "material": 1, "variants": [1] }] } }
    }] }],
    "materials": [
        { "name": "red", "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0 } },
        {
            "name": "blue",
            "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 1, 1], "metallicFactor": 0 },
            "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1 } }
        }
    ],
    "accessors": [
        { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-2, -2, 0], "max": [2, 2, 0] },
        { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3" }
    ],
    "bufferViews": [
        { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
        { "buffer": 0, "byteOffset": 36, "byteLength": 36 }
    ],
    "buffers": [{
        "byteLength": 72,
        "uri": "data:application/octet-stream;base64,AAAAwAAAAMAAAAAAAAAAQAAAAMAAAAAAAAAAAAAAAEAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/"
    }]
}"#;

#[test]
fn a_variant_gives_surfaces_other_materials() {
    let folder = Folder::new("variants");
    folder.write("m.gltf", VARIANTS.as_bytes());
    let info: serde_json::Value =
        serde_json::from_str(&run_in(&folder, &["info", "m.gltf", "--json"]).expect(0).text()).expect("JSON");
    assert_eq!(info["variants"], serde_json::json!(["dry", "wet"]));
    assert_eq!(info["materials"][0]["layers"], serde_json::json!([]));
    assert_eq!(info["materials"][1]["layers"], serde_json::json!(["clearcoat"]));
    let text = run_in(&folder, &["info", "m.gltf"]).expect(0).text();
    assert!(text.contains("blue (layered because of clearcoat)"), "{text}");
    if !has_adapter() {
        return;
    }
    let middle = |variant: &[&str], out: &str| {
        let words =
            ["render", "m.gltf", "-o", out, "--size", "16x16", "--samples", "1", "--eye", "0,0,2", "--target", "0,0,0"];
        run_in(&folder, &[&words[..], &["--report", "r.json"], variant].concat()).expect(0);
        let picture = image::open(folder.join(out)).expect("a picture").to_rgb8();
        picture.get_pixel(8, 8).0
    };
    let plain = middle(&[], "plain.png");
    assert!(plain[0] > plain[2] + 60, "{plain:?}");
    assert_eq!(middle(&["--variant", "dry"], "dry.png"), plain, "it says nothing of this surface");
    for name in ["wet", "1"] {
        let wet = middle(&["--variant", name], "wet.png");
        assert!(wet[2] > wet[0] + 60, "{wet:?}");
    }
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("r.json")).expect("a report")).expect("JSON");
    assert_eq!(
        report["forward_materials"],
        serde_json::json!([{ "index": 1, "name": "blue", "shading": "layered", "layers": ["clearcoat"] }])
    );
    let unknown = run_in(&folder, &["render", "m.gltf", "--variant", "damp"]).expect(2);
    assert!(unknown.stderr.contains("0 `dry`, 1 `wet`"), "{}", unknown.stderr);
}

#[test]
fn all_variants_and_cameras_have_a_picture_each() {
    let folder = Folder::new("looks");
    let cameras = r#"
    "cameras": [
        { "name": "Front", "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } },
        { "name": "front", "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }
    ],
    "scenes": [{ "nodes": [0, 1, 2] }],
    "nodes": [{ "mesh": 0 }, { "camera": 0, "translation": [0, 0, 2] }, { "camera": 1, "translation": [0, 0, 90] }],"#;
    let plain = r#""scenes": [{ "nodes": [0] }],
    "nodes": [{ "mesh": 0 }],"#;
    assert!(VARIANTS.contains(plain));
    folder.write("m.gltf", VARIANTS.replace(plain, cameras).as_bytes());
    // What can be refused without the file is refused before it.
    for (flags, said) in [
        (["--variant", "all", "-o", "x.png"], "one place for all variants"),
        (["--camera", "all", "-o", "{variant}.png"], "one place for all cameras"),
        (["--variant", "wet", "-o", "{camera}.png"], "names a camera, and none is asked for"),
        (["--camera", "all", "-o", "-"], "standard output"),
    ] {
        let refused = run_in(&folder, &[&["render", "m.gltf"][..], &flags].concat()).expect(2);
        assert!(refused.stderr.contains(said), "{}", refused.stderr);
    }
    for words in [["graph", "m.gltf", "--variant", "all"], ["diff", "m.gltf", "--camera", "all"]] {
        let words = if words[0] == "diff" { [&words[..], &["m.gltf"]].concat() } else { words.to_vec() };
        let refused = run_in(&folder, &words).expect(2);
        assert!(refused.stderr.contains("only for `manypass render`"), "{}", refused.stderr);
    }
    if !has_adapter() {
        return;
    }
    let size = ["--size", "16x16", "--samples", "1"];
    let render = |flags: &[&str]| run_in(&folder, &[&["render", "m.gltf"][..], flags, &size].concat()).expect(0);
    render(&["--variant", "all", "--camera", "all", "-o", "out/", "--report", "r.jsonl"]);
    let lines = std::fs::read_to_string(folder.join("r.jsonl")).expect("a report");
    let mut outputs = Vec::new();
    for line in lines.lines() {
        let line: serde_json::Value = serde_json::from_str(line).expect("JSON");
        outputs.push(format!("{} {} {}", line["output"], line["variant"], line["camera_name"]).replace('"', ""));
    }
    let expected = [("dry", "Front"), ("dry", "front-1"), ("wet", "Front"), ("wet", "front-1")]
        .map(|(variant, camera)| format!("out/m_{variant}_{camera}.png {variant} {camera}"));
    assert_eq!(outputs, expected);
    let middle = |file: &str| image::open(folder.join(file)).expect("a picture").to_rgb8().get_pixel(8, 8).0;
    let (dry, wet) = (middle("out/m_dry_Front.png"), middle("out/m_wet_Front.png"));
    assert!(dry[0] > dry[2] + 60 && wet[2] > wet[0] + 60, "{dry:?} {wet:?}");
    // Each is as it is alone.
    for (variant, camera, file) in [("dry", "front", "dry_front-1"), ("wet", "0", "wet_Front")] {
        render(&["--variant", variant, "--camera", camera, "-o", "{variant}_{camera}_alone.png"]);
        let alone = std::fs::read(folder.join(&format!("{variant}_{camera}_alone.png"))).expect("a picture");
        assert_eq!(std::fs::read(folder.join(&format!("out/m_{file}.png"))).expect("a picture"), alone, "{file}");
    }
    let again =
        render(&["--variant", "all", "--camera", "all", "-o", "out/", "--skip-existing", "--report", "s.jsonl"]);
    let skipped = std::fs::read_to_string(folder.join("s.jsonl")).expect("a report");
    assert_eq!((skipped.matches("\"skipped\":true").count(), again.stderr.as_str()), (4, ""));
    folder.write("t.glb", &common::triangle_glb([1.0, 0.0, 0.0]));
    let without = run_in(&folder, &[&["render", "t.glb", "--variant", "all", "--camera", "all"][..], &size].concat());
    assert!(without.expect(0).stderr.contains("no variants") && folder.join("t_default_default.png").is_file());
}
