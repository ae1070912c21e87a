//! Materials on the command line: variants, and what reports and `info` say of layers.

mod common;

use common::{Folder, has_adapter, run_in};

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
    assert!(text.contains("blue (clearcoat: shaded where it is drawn)"), "{text}");
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
    assert_eq!(report["layered_materials"][0]["layers"], serde_json::json!(["clearcoat"]));
    let unknown = run_in(&folder, &["render", "m.gltf", "--variant", "damp"]).expect(2);
    assert!(unknown.stderr.contains("0 `dry`, 1 `wet`"), "{}", unknown.stderr);
}
