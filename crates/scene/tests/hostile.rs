//! Accessors of every kind, and files that lie about themselves.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use manypass_scene::{LoadError, LoadedScene, load_bytes};
use proptest::prelude::*;
use serde_json::{Value, json};

fn load(json: &Value, buffer: &[u8]) -> Result<LoadedScene, LoadError> {
    load_bytes(json.to_string().as_bytes(), &mut |_| Ok(buffer.to_vec()), "test.gltf")
}

/// A mesh of points whose positions are accessor 0.
fn points(accessor: Value, views: Value, buffer_length: usize) -> Value {
    json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "mode": 0, "attributes": { "POSITION": 0 } }] }],
        "accessors": [accessor], "bufferViews": views,
        "buffers": [{ "byteLength": buffer_length, "uri": "a%20b.bin" }],
    })
}

fn positions(loaded: &LoadedScene) -> &[[f32; 3]] {
    &loaded.scene.meshes[0].primitives[0].positions
}

proptest! {
    #[test]
    fn interleaved_floats_come_back(values in prop::collection::vec(prop::array::uniform3(-1e6_f32..1e6), 1..40), pad in 0_usize..8) {
        let stride = 12 + 4 * pad;
        let mut buffer = vec![0xAB; 4];
        for value in &values {
            buffer.extend(value.iter().flat_map(|v| v.to_le_bytes()));
            buffer.extend(std::iter::repeat_n(0xCD, stride - 12));
        }
        let accessor = json!({ "bufferView": 0, "byteOffset": 4, "componentType": 5126, "type": "VEC3", "count": values.len() });
        let view = json!([{ "buffer": 0, "byteLength": buffer.len(), "byteStride": stride }]);
        let loaded = load(&points(accessor, view, buffer.len()), &buffer).unwrap();
        prop_assert_eq!(positions(&loaded), &values[..]);
    }

    #[test]
    fn normalized_integers_come_back(values in prop::collection::vec(prop::array::uniform3(any::<i16>()), 1..40)) {
        let buffer: Vec<u8> = values.iter().flat_map(|[x, y, z]| [*x, *y, *z, 0]).flat_map(i16::to_le_bytes).collect();
        let accessor = json!({ "bufferView": 0, "componentType": 5122, "normalized": true, "type": "VEC3", "count": values.len() });
        let view = json!([{ "buffer": 0, "byteLength": buffer.len(), "byteStride": 8 }]);
        let loaded = load(&points(accessor, view, buffer.len()), &buffer).unwrap();
        let expected: Vec<[f32; 3]> = values.iter().map(|v| v.map(|v| (f32::from(v) / 32767.0).max(-1.0))).collect();
        prop_assert_eq!(positions(&loaded), &expected[..]);
    }

    #[test]
    fn sparse_values_replace_zeros(count in 1_usize..60, picks in prop::collection::btree_map(0_u8..60, -1.0_f32..1.0, 1..20)) {
        let picks: Vec<(u8, f32)> = picks.into_iter().filter(|(i, _)| usize::from(*i) < count).collect();
        prop_assume!(!picks.is_empty());
        let mut buffer: Vec<u8> = picks.iter().map(|(i, _)| *i).collect();
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        let split = buffer.len();
        buffer.extend(picks.iter().flat_map(|(_, v)| [*v, 2.0, 3.0]).flat_map(f32::to_le_bytes));
        let accessor = json!({ "componentType": 5126, "type": "VEC3", "count": count, "sparse": { "count": picks.len(),
            "indices": { "bufferView": 0, "componentType": 5121 }, "values": { "bufferView": 1 } } });
        let views = json!([{ "buffer": 0, "byteLength": split }, { "buffer": 0, "byteOffset": split, "byteLength": buffer.len() - split }]);
        let loaded = load(&points(accessor, views, buffer.len()), &buffer).unwrap();
        let mut expected = vec![[0.0; 3]; count];
        for (i, v) in picks {
            expected[usize::from(i)] = [v, 2.0, 3.0];
        }
        prop_assert_eq!(positions(&loaded), &expected[..]);
    }

    #[test]
    fn any_ranges_end_without_a_panic(offset in any::<u64>(), count in any::<u64>(), stride in any::<u16>(), view_offset in 0_u64..200, length in 0_u64..200) {
        for (offset, count) in [(offset, count), (offset % 64, count % 64)] {
            let accessor = json!({ "bufferView": 0, "byteOffset": offset, "componentType": 5126, "type": "VEC3", "count": count });
            let view = json!([{ "buffer": 0, "byteOffset": view_offset, "byteLength": length, "byteStride": stride % 64 }]);
            let _ = load(&points(accessor, view, 128), &[0; 128]);
        }
    }

    #[test]
    fn any_bytes_end_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = load_bytes(&bytes, &mut |_| Err(String::new()), "noise");
        let glb = [b"glTF\x02\0\0\0".as_slice(), &(bytes.len() as u32).to_le_bytes(), &bytes].concat();
        let _ = load_bytes(&glb, &mut |_| Err(String::new()), "noise.glb");
    }
}

fn refused_at(json: &Value, buffer: &[u8]) -> String {
    match load(json, buffer) {
        Err(LoadError::Invalid { pointer, .. }) => pointer,
        other => panic!("expected an error, got {other:?}"),
    }
}

#[test]
fn errors_name_the_place() {
    let view = || json!([{ "buffer": 0, "byteLength": 36 }]);
    let accessor = |count: u64| json!({ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": count });
    assert!(load(&points(accessor(3), view(), 36), &[0; 36]).is_ok());
    assert_eq!(refused_at(&points(accessor(4), view(), 36), &[0; 36]), "/accessors/0/count");
    assert_eq!(refused_at(&points(accessor(u64::MAX), view(), 36), &[0; 36]), "/accessors/0/count");
    assert_eq!(refused_at(&points(accessor(3), view(), 36), &[0; 35]), "/buffers/0/byteLength");
    let zeros = json!({ "componentType": 5126, "type": "VEC3", "count": 1_u64 << 40 });
    assert!(load(&points(zeros, json!([]), 36), &[0; 36]).is_err());
    let mut model = points(accessor(3), view(), 36);
    model["nodes"] = json!([{ "children": [0] }]);
    assert!(load(&model, &[0; 36]).is_err());
    model["nodes"] = json!([{ "mesh": 0, "translation": [1e300, 0, 0] }]);
    assert_eq!(refused_at(&model, &[0; 36]), "/nodes/0/translation");
    model["nodes"] = json!([{ "mesh": 7 }]);
    assert_eq!(refused_at(&model, &[0; 36]), "/nodes/0/mesh");
}

#[test]
fn a_deep_hierarchy_needs_no_stack() {
    let depth = 100_000;
    let mut nodes: Vec<Value> = (1..depth).map(|i| json!({ "children": [i] })).collect();
    nodes.push(json!({}));
    let model = json!({ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": nodes });
    assert_eq!(load(&model, &[]).unwrap().scene.visible_nodes().len(), depth);
}

#[test]
fn deep_json_is_refused() {
    let text = "[".repeat(100_000);
    assert!(load_bytes(text.as_bytes(), &mut |_| Err(String::new()), "deep").is_err());
}

#[test]
fn a_required_extension_is_named_and_a_used_one_warned_of() {
    let model = |key: &str| json!({ "asset": { "version": "2.0" }, key: ["EXT_never_heard_of"] });
    let error = load(&model("extensionsRequired"), &[]).unwrap_err();
    assert!(matches!(&error, LoadError::UnsupportedExtension { extension, .. } if extension.contains("never")));
    assert!(error.to_string().starts_with("test.gltf: "));
    let warnings = load(&model("extensionsUsed"), &[]).unwrap().warnings;
    assert!(warnings.iter().any(|warning| warning.contains("EXT_never_heard_of")));
}

#[test]
fn a_missing_image_is_white_with_a_warning() {
    let model = json!({ "asset": { "version": "2.0" }, "images": [{ "uri": "gone.png" }] });
    let loaded = load_bytes(model.to_string().as_bytes(), &mut |_| Err("gone".into()), "test").unwrap();
    assert_eq!(loaded.scene.images[0].decode().unwrap().data, [255; 4]);
    assert!(loaded.warnings[0].contains("/images/0"));
}

#[test]
fn uris_are_decoded_and_escapes_refused() {
    let accessor = json!({ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 1 });
    let model = points(accessor, json!([{ "buffer": 0, "byteLength": 12 }]), 12);
    let mut asked = String::new();
    let mut resolve = |uri: &str| {
        uri.clone_into(&mut asked);
        Ok(vec![0; 12])
    };
    load_bytes(model.to_string().as_bytes(), &mut resolve, "test").unwrap();
    assert_eq!(asked, "a b.bin");

    let folder = std::env::temp_dir().join(format!("manypass-scene-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("in")).unwrap();
    std::fs::write(folder.join("secret.bin"), [0; 12]).unwrap();
    for uri in ["../secret.bin", "%2e%2e/secret.bin", "/etc/passwd", "file:///etc/passwd", ".", "x/../../secret.bin"] {
        let mut escape = model.clone();
        escape["buffers"][0]["uri"] = json!(uri);
        let path = folder.join("in/model.gltf");
        std::fs::write(&path, escape.to_string()).unwrap();
        assert!(manypass_scene::load_path(&path).is_err(), "{uri}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn lights_with_numbers_that_no_light_has_are_told() {
    let light = |light: &str| {
        let json = format!(
            r#"{{ "asset": {{ "version": "2.0" }}, "extensions": {{ "KHR_lights_punctual": {{ "lights": [{light}] }} }},
            "nodes": [{{ "extensions": {{ "KHR_lights_punctual": {{ "light": 0 }} }} }}] }}"#
        );
        let loaded = load_bytes(json.as_bytes(), &mut |_| Err(String::new()), "lights.gltf");
        loaded.map(|loaded| {
            let lights = "/extensions/KHR_lights_punctual/lights/0";
            (loaded.scene.lights, loaded.warnings.iter().filter(|warning| warning.contains(lights)).count())
        })
    };
    for (text, part) in [
        (r#"{ "type": "point", "intensity": 1e39 }"#, "lights/0/intensity\": expected a finite number"),
        (r#"{ "type": "point", "intensity": 1e999 }"#, "its JSON does not parse: number out of range"),
        (r#"{ "type": "point", "intensity": NaN }"#, "its JSON does not parse"),
        (r#"{ "type": "point", "intensity": "5" }"#, "expected a finite number"),
        (r#"{ "type": "point", "color": [1, 1e39, 0] }"#, "expected an array of finite numbers"),
        (r#"{ "type": "point", "range": 0 }"#, "lights/0/range\": expected a number above 0"),
        (r#"{ "type": "point", "range": -3 }"#, "lights/0/range\": expected a number above 0"),
        (r#"{ "type": "point", "range": 1e39 }"#, "expected a finite number"),
        (r#"{ "type": "spot" }"#, "lights/0/spot\": expected an object"),
        (r#"{ "type": "spot", "spot": { "outerConeAngle": -0.1 } }"#, "outerConeAngle\": expected a number from 0 to"),
        (r#"{ "type": "spot", "spot": { "outerConeAngle": 2 } }"#, "outerConeAngle\": expected a number from 0 to"),
        (r#"{ "type": "spot", "spot": { "innerConeAngle": -1 } }"#, "innerConeAngle\": expected a number from 0 to"),
    ] {
        let error = light(text).expect_err(text).to_string();
        assert!(error.contains(part), "{text}: {error}");
    }
    for (text, warnings) in [
        (r#"{ "type": "point", "intensity": 0 }"#, 0),
        (r#"{ "type": "point", "intensity": -5 }"#, 1),
        (r#"{ "type": "point", "range": 1e-30 }"#, 1),
        (r#"{ "type": "point", "range": 3e38 }"#, 0),
        (r#"{ "type": "spot", "spot": { "innerConeAngle": 0.6, "outerConeAngle": 0.5 } }"#, 1),
        (r#"{ "type": "spot", "spot": { "outerConeAngle": 0 } }"#, 1),
        (r#"{ "type": "moon" }"#, 1),
    ] {
        let (lights, found) = light(text).expect(text);
        assert_eq!(found, warnings, "{text}");
        let light = &lights[0];
        assert!(light.intensity >= 0.0 && light.range_m.is_none_or(|range_m| range_m * range_m > 0.0), "{light:?}");
    }
}
