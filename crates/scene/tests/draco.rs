//! `KHR_draco_mesh_compression`: a stream written by hand after the bitstream's specification, files of other programs
//! beside their twins, and broken streams.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::{floats, twins};
use manypass_scene::{LoadError, LoadedScene, load_bytes, load_path};
use manypass_testkit::needs::assets;
use proptest::prelude::*;
use serde_json::{Value, json};

const POSITIONS: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.5];
const COLORS: [u8; 16] = [255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 51, 51, 51, 255];
const JOINTS: [u16; 16] = [0, 0, 0, 0, 300, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0];

/// Two triangles, stored one after the other: positions are attribute 7, colours 2 and joints 40.
fn stream() -> Vec<u8> {
    let mut data = b"DRACO".to_vec();
    // Version 2.2, a mesh, in sequence, without flags; two triangles of four points, as plain indices.
    data.extend([2, 2, 1, 0, 0, 0, 2, 4, 1]);
    data.extend([0, 1, 2, 2, 1, 3]);
    // One decoder of three attributes: what they are, their type, components, whether normalised, their number.
    data.extend([1, 3]);
    data.extend([0, 9, 3, 0, 7]);
    data.extend([2, 2, 4, 1, 2]);
    data.extend([4, 4, 4, 0, 40]);
    // All stored as they are.
    data.extend([0, 0, 0]);
    data.extend(floats(&POSITIONS));
    data.extend(COLORS);
    data.extend(JOINTS.iter().flat_map(|joint| joint.to_le_bytes()));
    data
}

fn file(stream: &[u8]) -> Value {
    let accessor =
        |component: u32, kind: &str, count: usize| json!({ "componentType": component, "type": kind, "count": count });
    let mut colors = accessor(5121, "VEC4", 4);
    colors["normalized"] = json!(true);
    json!({
        "asset": { "version": "2.0" }, "extensionsRequired": ["KHR_draco_mesh_compression"], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "COLOR_0": 1, "JOINTS_0": 2, "WEIGHTS_0": 3 }, "indices": 4,
            "extensions": { "KHR_draco_mesh_compression": {
                "bufferView": 0, "attributes": { "POSITION": 7, "COLOR_0": 2, "JOINTS_0": 40 } } },
        }] }],
        "accessors": [accessor(5126, "VEC3", 4), colors, accessor(5123, "VEC4", 4),
            { "bufferView": 1, "componentType": 5126, "type": "VEC4", "count": 4 }, accessor(5121, "SCALAR", 6)],
        "bufferViews": [{ "buffer": 0, "byteLength": stream.len() }, { "buffer": 1, "byteLength": 64 }],
        "buffers": [{ "byteLength": stream.len(), "uri": "packed.bin" }, { "byteLength": 64, "uri": "weights.bin" }],
    })
}

fn load(file: &Value, stream: &[u8]) -> Result<LoadedScene, LoadError> {
    let weights = floats(&[1.0, 0.0, 0.0, 0.0].repeat(4));
    let mut resolve = |uri: &str| Ok(if uri == "packed.bin" { stream.to_vec() } else { weights.clone() });
    load_bytes(file.to_string().as_bytes(), &mut resolve, "test.gltf")
}

#[test]
fn attributes_are_found_by_their_numbers() {
    for mode in [4, 5] {
        let mut file = file(&stream());
        file["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let loaded = load(&file, &stream()).unwrap();
        assert_eq!(loaded.warnings, [""; 0]);
        let primitive = &loaded.scene.meshes[0].primitives[0];
        // Without normals the corners come apart, triangle by triangle.
        let corners = [0, 1, 2, 2, 1, 3];
        let drawn: Vec<usize> = primitive.indices.iter().map(|index| *index as usize).collect();
        assert_eq!(drawn.len(), 6);
        for (index, corner) in drawn.into_iter().zip(corners) {
            assert_eq!(primitive.positions[index], POSITIONS[3 * corner..3 * corner + 3]);
            assert_eq!(primitive.colors[index], [0, 1, 2, 3].map(|i| f32::from(COLORS[4 * corner + i]) / 255.0));
            assert_eq!(primitive.joints[index][0], JOINTS[4 * corner]);
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    let extension = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    let place = format!("test.gltf: at \"{extension}");
    for (pointer, value, part) in [
        (
            format!("{extension}/attributes/COLOR_0"),
            json!(3),
            "/attributes/COLOR_0\": the packed data have no attribute 3",
        ),
        (format!("{extension}/attributes/COLOR_0"), json!(7), "expected 4 components, as the accessor says, found 3"),
        (format!("{extension}/attributes/COLOR_0"), json!(1_u64 << 40), "expected an integer of 32 bits"),
        (format!("{extension}/attributes"), json!({ "NORMAL": 1 }), "the primitive has no such attribute"),
        (format!("{extension}/bufferView"), json!(9), "refers to bufferView 9, but there are 2"),
        (format!("{extension}/bufferView"), json!(1), "/bufferView\": the packed data are broken"),
    ] {
        let mut file = file(&stream());
        *file.pointer_mut(&pointer).unwrap() = value;
        let error = load(&file, &stream()).unwrap_err().to_string();
        assert!(error.starts_with(&place) && error.contains(part), "{error}");
    }
    let primitive = |key: &str, value| {
        let mut file = file(&stream());
        file["meshes"][0]["primitives"][0][key] = value;
        load(&file, &stream()).unwrap_err().to_string()
    };
    assert!(primitive("mode", json!(1)).contains("only they can be packed"));
    assert!(primitive("indices", Value::Null).contains("/indices\": expected"));
    let mut file = file(&stream());
    file["accessors"][4]["count"] = json!(3);
    let warnings = load(&file, &stream()).unwrap().warnings;
    assert!(warnings[0].contains("the packed data have 6 elements, the accessor says 3"), "{warnings:?}");
}

#[test]
fn broken_data_that_are_not_required_are_replaced_by_the_accessors() {
    let mut file = file(&stream());
    file["extensionsRequired"] = json!([]);
    let error = load(&file, b"DRACO").unwrap_err().to_string();
    assert!(error.contains("the file cut off"), "{error}");
    let mut broken = stream();
    broken[7] = 9;
    assert!(load(&file, &broken).unwrap_err().to_string().contains("the packed data are broken"));
    for (accessor, count) in [(0, 4), (1, 4), (2, 4), (4, 3)] {
        file["accessors"][accessor]["bufferView"] = json!(1);
        file["accessors"][accessor]["count"] = json!(count);
    }
    // Behind the first weight there are zeros.
    file["accessors"][4]["byteOffset"] = json!(4);
    let loaded = load(&file, &broken).unwrap();
    assert!(loaded.warnings[0].contains("the accessors that are not packed are used"), "{:?}", loaded.warnings);
    assert_eq!(loaded.scene.meshes[0].primitives[0].indices.len(), 3);
}

/// Small files of an encoder, with its way of storing triangles by edges.
fn encoded_files() -> Vec<(Value, Vec<u8>)> {
    let Some(assets) = assets("") else { return Vec::new() };
    let models = [
        "khronos-sample-assets/Models/Box/glTF-Draco/Box.gltf",
        "gltf-transform/extensions/test/in/DracoSparseMesh.gltf",
        "khronos-sample-assets/Models/MorphPrimitivesTest/glTF-Draco/MorphPrimitivesTest.gltf",
    ];
    let read = |model: &str| {
        let path = assets.join(model);
        let file: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let stream = std::fs::read(path.with_file_name(file["buffers"][0]["uri"].as_str().unwrap())).unwrap();
        (file, stream)
    };
    models.map(read).to_vec()
}

#[test]
fn changed_streams_end_without_a_panic() {
    let mut files = encoded_files();
    files.push((file(&stream()), stream()));
    let any_changes = prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..5);
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(300)
    });
    let changed = (any::<prop::sample::Index>(), any_changes, any::<prop::sample::Index>(), any::<bool>());
    let result = runner.run(&changed, |(which, changes, cut, is_cut)| {
        let (file, mut stream) = files[which.index(files.len())].clone();
        for (at, byte) in changes {
            let at = at.index(stream.len().min(400));
            stream[at] = byte;
        }
        if is_cut {
            let length = cut.index(stream.len());
            stream[length..].fill(0);
        }
        if let Err(error) = load(&file, &stream) {
            prop_assert!(error.to_string().starts_with("test.gltf: at \"/"), "{error}");
        }
        Ok(())
    });
    result.unwrap();
}

#[test]
fn packed_models_are_those_that_are_not_packed() {
    let Some(assets) = assets("") else { return };
    for model in ["Box", "Duck", "CesiumMan", "MorphPrimitivesTest"] {
        let folder = assets.join("khronos-sample-assets/Models").join(model);
        let packed = load_path(&folder.join(format!("glTF-Draco/{model}.gltf"))).unwrap();
        let plain = load_path(&folder.join(format!("glTF-Binary/{model}.glb"))).unwrap();
        assert!(packed.warnings.is_empty(), "{:?}", packed.warnings);
        twins::assert_same(&packed.scene, &plain.scene, [1e-3, 0.02, 1e-3]);
    }
    // Decoded by another program, Google's own.
    let packed = load_path(&assets.join("sponza/sponza_cd.glb")).unwrap();
    let plain = load_path(&assets.join("sponza/rebuilt/Sponza.gltf")).unwrap();
    twins::assert_same(&packed.scene, &plain.scene, [1e-5, 1e-5, 1e-5]);
}
