//! What needs a feature that is off says which. It runs by
//! `cargo test -p manypass-scene --no-default-features --test without_features`.
#![cfg(not(any(
    feature = "draco",
    feature = "exr",
    feature = "formats",
    feature = "ktx2",
    feature = "meshopt",
    feature = "simplify",
    feature = "text"
)))]
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use manypass_scene::overlay::Font;
use manypass_scene::{EnvironmentMap, Image, ImageSource, LoadedScene, Scene, load_bytes};
use manypass_testkit::ktx2;
use serde_json::{Value, json};

const DRACO: &str = "KHR_draco_mesh_compression";
const MESHOPT: &str = "EXT_meshopt_compression";

/// Loads a file whose buffers hold zeros.
fn load(file: &Value) -> Result<LoadedScene, String> {
    let mut resolve = |uri: &str| uri.parse().map(|length| vec![0; length]).map_err(|_| format!("no {uri}"));
    load_bytes(file.to_string().as_bytes(), &mut resolve, "test.gltf").map_err(|error| error.to_string())
}

/// A triangle packed by Draco, beside the same that is not packed.
fn draco(required: &[&str]) -> Value {
    json!({
        "asset": { "version": "2.0" }, "extensionsUsed": [DRACO], "extensionsRequired": required,
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0 }, "indices": 1,
            "extensions": { DRACO: { "bufferView": 0, "attributes": { "POSITION": 0 } } },
        }] }],
        "accessors": [{ "bufferView": 1, "componentType": 5126, "type": "VEC3", "count": 3 },
            { "bufferView": 0, "componentType": 5121, "type": "SCALAR", "count": 3 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 3 }, { "buffer": 1, "byteLength": 36 }],
        "buffers": [{ "byteLength": 3, "uri": "3" }, { "byteLength": 36, "uri": "36" }],
    })
}

/// Points packed by meshoptimizer, beside the same that are not packed.
fn meshopt(required: &[&str]) -> Value {
    let packed = json!({ "buffer": 0, "byteLength": 4, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES" });
    json!({
        "asset": { "version": "2.0" }, "extensionsUsed": [MESHOPT], "extensionsRequired": required,
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "mode": 0, "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 }],
        "bufferViews": [{ "buffer": 1, "byteLength": 36, "byteStride": 12, "extensions": { MESHOPT: packed } }],
        "buffers": [{ "byteLength": 4, "uri": "4" }, { "byteLength": 36, "uri": "36" }],
    })
}

#[test]
fn packed_meshes_are_refused_where_nothing_is_in_their_stead() {
    for (file, feature) in [(draco(&[DRACO]), "draco"), (meshopt(&[MESHOPT]), "meshopt")] {
        let error = load(&file).unwrap_err();
        assert!(error.contains(&format!("without the feature `{feature}`")), "{error}");
    }
}

#[test]
fn packed_meshes_that_are_there_unpacked_are_a_warning() {
    for (file, feature) in [(draco(&[]), "draco"), (meshopt(&[]), "meshopt")] {
        let loaded = load(&file).unwrap();
        let warned = |line: &String| line.contains(&format!("without the feature `{feature}`"));
        assert!(loaded.warnings.iter().any(warned), "{:?}", loaded.warnings);
        assert_eq!(loaded.scene.meshes[0].primitives[0].positions.len(), 3);
    }
}

#[test]
fn models_of_other_formats_are_refused() {
    let mut resolve = |uri: &str| Err(format!("no {uri}"));
    for (bytes, name) in [(&b"v 0 0 0\n"[..], "a.obj"), (b"solid a\nendsolid\n", "-"), (b"ply\n", "-"), (b"", "a.3mf")]
    {
        let error = load_bytes(bytes, &mut resolve, name).unwrap_err().to_string();
        assert!(error.contains("need the feature `formats`"), "{error}");
    }
}

#[test]
fn images_are_refused() {
    let image = |bytes: Vec<u8>| Image { name: "a".into(), source: ImageSource::Encoded(bytes.into()) };
    let basis = ktx2::picture(0, [4, 4], 0, &[&ktx2::solid_block([9, 8, 7, 255])]);
    let zstandard = ktx2::picture(37, [1, 1], 2, &[&[0; 4]]);
    for bytes in [basis, zstandard] {
        let error = image(bytes).decode().unwrap_err().to_string();
        assert!(error.contains("without the feature `ktx2`"), "{error}");
    }
    let plain = ktx2::picture(37, [1, 1], 0, &[&[1, 2, 3, 4]]);
    assert_eq!(image(plain).decode().unwrap().data, [1, 2, 3, 4]);
    let exr = [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let errors = [
        image(exr.to_vec()).decode_light().unwrap_err().to_string(),
        EnvironmentMap::decode("a.exr", &exr).unwrap_err().to_string(),
    ];
    assert!(errors.iter().all(|error| error.contains("without the feature `exr`")), "{errors:?}");
}

#[test]
fn there_are_no_fonts_and_no_coarser_levels() {
    assert!(Font::built_in().is_none());
    let error = Font::parse("a.ttf", Vec::new()).unwrap_err();
    assert!(error.contains("without the feature `text`"), "{error}");
    let warnings = Scene::default().simplify();
    assert!(warnings[0].contains("the feature `simplify`"), "{warnings:?}");
}
