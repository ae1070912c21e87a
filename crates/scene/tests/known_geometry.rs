//! Meshes with known answers: modes, indices, component types, sparse accessors, skins and morph targets.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::{F32, I8, I16, Model, U8, U16, U32, floats, integers};
use manypass_scene::{Primitive, Topology, load_bytes};
use manypass_testkit::data_uri;
use serde_json::{Value, json};

/// Five points that differ.
fn five() -> Vec<[f32; 3]> {
    (0..5_u8).map(|i| [f32::from(i), f32::from(i * i), 0.0]).collect()
}

/// The positions that a primitive draws, in order, by their x.
fn drawn(primitive: &Primitive) -> Vec<u32> {
    primitive.indices.iter().map(|&index| primitive.positions[index as usize][0] as u32).collect()
}

#[test]
fn every_mode_draws_its_list_with_and_without_indices_of_every_type() {
    let modes: [(u32, Topology, &[u32]); 7] = [
        (0, Topology::Points, &[0, 1, 2, 3, 4]),
        (1, Topology::Lines, &[0, 1, 2, 3]),
        (2, Topology::Lines, &[0, 1, 1, 2, 2, 3, 3, 4, 4, 0]),
        (3, Topology::Lines, &[0, 1, 1, 2, 2, 3, 3, 4]),
        (4, Topology::Triangles, &[0, 1, 2]),
        (5, Topology::Triangles, &[0, 1, 2, 1, 3, 2, 2, 3, 4]),
        (6, Topology::Triangles, &[1, 2, 0, 2, 3, 0, 3, 4, 0]),
    ];
    for (mode, topology, list) in modes {
        for index_type in [None, Some(U8), Some(U16), Some(U32)] {
            let mut model = Model::with_positions(mode, &five());
            if let Some(component) = index_type {
                let indices = model.accessor(component, "SCALAR", &integers(component, &[4, 3, 2, 1, 0]));
                model.primitive()["indices"] = json!(indices);
            }
            let loaded = model.try_load().unwrap();
            let primitive = &loaded.scene.meshes[0].primitives[0];
            let expected: Vec<u32> = list.iter().map(|i| if index_type.is_some() { 4 - i } else { *i }).collect();
            assert_eq!(primitive.topology, topology);
            assert_eq!(drawn(primitive), expected, "mode {mode}, indices {index_type:?}");
            // Five vertices are not a whole number of lines or triangles.
            assert_eq!(loaded.warnings.len(), usize::from(mode == 1 || mode == 4));
        }
    }
}

#[test]
fn an_index_beyond_the_vertices_and_a_mode_beyond_6_are_refused() {
    let mut model = Model::with_positions(0, &five());
    let indices = model.accessor(U8, "SCALAR", &[5]);
    model.primitive()["indices"] = json!(indices);
    assert!(model.try_load().unwrap_err().to_string().contains("index 5 is beyond the 5 vertices"));
    assert!(Model::with_positions(7, &five()).try_load().unwrap_err().to_string().contains("/mode"));
    let mut model = Model::with_positions(0, &five());
    let indices = model.accessor(I16, "SCALAR", &[0, 0]);
    model.primitive()["indices"] = json!(indices);
    assert!(model.try_load().unwrap_err().to_string().contains("/indices"));
}

/// The extremes of a component type, and what they are when normalized.
fn extremes(component: u32) -> ([i64; 3], [f32; 3]) {
    match component {
        I8 => ([-128, 0, 127], [-1.0, 0.0, 1.0]),
        U8 => ([51, 0, 255], [0.2, 0.0, 1.0]),
        I16 => ([-32768, 16384, 32767], [-1.0, 16384.0 / 32767.0, 1.0]),
        _ => ([13107, 0, 65535], [0.2, 0.0, 1.0]),
    }
}

/// Pads every three components to four, as glTF asks for strides that are multiples of four bytes.
fn padded(component: u32, vector: &[i64; 3]) -> Vec<u8> {
    integers(component, &[vector[0], vector[1], vector[2], 99])
}

#[test]
fn quantized_attributes_come_back_in_every_type() {
    for component in [I8, U8, I16, U16] {
        let (values, normalized) = extremes(component);
        for is_normalized in [false, true] {
            let plain = values.map(|value| value as f32);
            let expected = if is_normalized { normalized } else { plain };
            let mut model = Model::empty(0);
            let position = model.attribute("POSITION", component, "VEC3", &padded(component, &values));
            let uv = model.attribute("TEXCOORD_0", component, "VEC2", &padded(component, &values));
            model.json["accessors"][position]["normalized"] = json!(is_normalized);
            model.json["accessors"][uv]["normalized"] = json!(is_normalized);
            for accessor in [position, uv] {
                let stride = if component == I8 || component == U8 { 4 } else { 8 };
                model.json["accessors"][accessor]["count"] = json!(1);
                model.json["bufferViews"][accessor]["byteStride"] = json!(stride);
            }
            let primitive = model.load_primitive();
            assert_eq!(primitive.positions, [expected], "{component} {is_normalized}");
            assert_eq!(primitive.uv0, [[expected[0], expected[1]]]);
        }
    }
    for (component, scale) in [(I8, 127), (I16, 32767)] {
        let mut model = Model::with_positions(0, &[[0.0; 3]]);
        let normal = model.attribute("NORMAL", component, "VEC4", &padded(component, &[0, -scale, 0]));
        model.json["accessors"][normal]["type"] = json!("VEC3");
        model.json["accessors"][normal]["normalized"] = json!(true);
        let tangent = model.attribute("TANGENT", component, "VEC4", &integers(component, &[scale, 0, 0, -scale]));
        model.json["accessors"][tangent]["normalized"] = json!(true);
        let primitive = model.load_primitive();
        assert_eq!((primitive.normals[0], primitive.tangents[0]), ([0.0, -1.0, 0.0], [1.0, 0.0, 0.0, -1.0]));
    }
}

#[test]
fn vertex_colors_come_back_in_every_format() {
    let formats: [(u32, Vec<u8>); 3] = [
        (F32, floats(&[0.0, 0.2, 1.0, 0.4])),
        (U8, integers(U8, &[0, 51, 255, 102])),
        (U16, integers(U16, &[0, 13107, 65535, 26214])),
    ];
    for (component, bytes) in formats {
        for kind in ["VEC3", "VEC4"] {
            let mut model = Model::with_positions(0, &[[0.0; 3]]);
            let color = model.attribute("COLOR_0", component, "VEC4", &bytes);
            model.json["accessors"][color]["type"] = json!(kind);
            model.json["accessors"][color]["normalized"] = json!(component != F32);
            let alpha = if kind == "VEC4" { 0.4 } else { 1.0 };
            assert_eq!(model.load_primitive().colors, [[0.0, 0.2, 1.0, alpha]], "{component} {kind}");
        }
    }
    let mut model = Model::with_positions(0, &[[0.0; 3]]);
    model.attribute("COLOR_0", F32, "VEC4", &floats(&[-1.0, 0.5, 2.0, f32::NAN]));
    let loaded = model.try_load().unwrap();
    assert_eq!(loaded.scene.meshes[0].primitives[0].colors, [[0.0, 0.5, 1.0, 0.0]]);
    assert_eq!(loaded.warnings.len(), 2, "{:?}", loaded.warnings);
}

#[test]
fn both_uv_sets_are_read() {
    let mut model = Model::with_positions(0, &[[0.0; 3]]);
    model.attribute("TEXCOORD_0", F32, "VEC2", &floats(&[-0.5, 2.0]));
    let second = model.attribute("TEXCOORD_1", U16, "VEC2", &integers(U16, &[65535, 13107]));
    model.json["accessors"][second]["normalized"] = json!(true);
    let primitive = model.load_primitive();
    assert_eq!((primitive.uv0[0], primitive.uv1[0]), ([-0.5, 2.0], [1.0, 0.2]));
}

/// Replaces elements 1 and 3 of accessor 0.
fn add_sparse(model: &mut Model, index_type: u32, values: &[u8]) {
    let indices = model.view(&integers(index_type, &[1, 3]));
    let values = model.view(values);
    model.json["accessors"][0]["sparse"] = json!({ "count": 2,
        "indices": { "bufferView": indices, "componentType": index_type }, "values": { "bufferView": values } });
}

#[test]
fn sparse_values_replace_those_of_the_buffer_or_zeros() {
    let replaced = [[9.0, 8.0, 7.0], [6.0, 5.0, 4.0]];
    for index_type in [U8, U16, U32] {
        for has_base in [true, false] {
            let mut model = Model::with_positions(0, &five());
            add_sparse(&mut model, index_type, &floats(replaced.as_flattened()));
            if !has_base {
                model.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
            }
            let mut expected = if has_base { five() } else { vec![[0.0; 3]; 5] };
            (expected[1], expected[3]) = (replaced[0], replaced[1]);
            assert_eq!(model.load_primitive().positions, expected, "{index_type} {has_base}");
        }
    }
    // Quantized values are tightly packed, whatever the stride of the elements that they replace.
    let mut model = Model::empty(0);
    model.attribute("POSITION", I8, "VEC4", &integers(I8, &[1; 20]));
    model.json["accessors"][0]["type"] = json!("VEC3");
    model.json["bufferViews"][0]["byteStride"] = json!(4);
    add_sparse(&mut model, U16, &integers(I8, &[9, 8, 7, 6, 5, -4]));
    let positions = model.load_primitive().positions;
    assert_eq!(positions, [[1.0; 3], [9.0, 8.0, 7.0], [1.0; 3], [6.0, 5.0, -4.0], [1.0; 3]]);
}

#[test]
fn sparse_indices_beyond_the_count_are_refused() {
    let mut model = Model::with_positions(0, &five()[..2]);
    add_sparse(&mut model, U8, &floats(&[0.0; 6]));
    assert!(model.try_load().unwrap_err().to_string().contains("/sparse/indices"));
}

#[test]
fn data_uris_of_every_shape_are_read() {
    let bytes = floats(&[0.25, -1.5, 3.0]);
    let base64 = data_uri("application/octet-stream", &bytes);
    let percent = format!("data:,{}", bytes.iter().map(|byte| format!("%{byte:02X}")).collect::<String>());
    let uris = [
        base64.clone(),
        data_uri("application/gltf-buffer", &bytes),
        data_uri("application/octet-stream;charset=utf-8", &bytes),
        base64.trim_end_matches('=').to_owned(),
        base64.replace('+', "-").replace('/', "_").replace("data:application_", "data:application/"),
        base64.replace('/', "%2F").replace("application%2F", "application/"),
        percent,
    ];
    for uri in uris {
        let mut model = Model::with_positions(0, &[[0.0; 3]]);
        model.json["buffers"] = json!([{ "byteLength": 12, "uri": uri }]);
        let loaded = load_bytes(model.json.to_string().as_bytes(), &mut |_| Err("asked".into()), "model").unwrap();
        assert_eq!(loaded.scene.meshes[0].primitives[0].positions, [[0.25, -1.5, 3.0]], "{uri}");
    }
    for uri in ["data:application/octet-stream;base64", "data:;base64,AA*A", "data:,%zz", "data:;base64,AA=="] {
        let mut model = Model::with_positions(0, &[[0.0; 3]]);
        model.json["buffers"] = json!([{ "byteLength": 12, "uri": uri }]);
        let error = load_bytes(model.json.to_string().as_bytes(), &mut |_| Err("asked".into()), "model").unwrap_err();
        assert!(error.to_string().contains("/buffers/0/"), "{error}");
    }
}

#[test]
fn a_buffer_without_bytes_is_zeros_and_a_glb_without_its_chunk_is_refused() {
    let mut model = Model::with_positions(0, &[[1.0; 3]]);
    model.json["buffers"] = json!([{ "byteLength": 12 }]);
    let text = model.json.to_string();
    let loaded = load_bytes(text.as_bytes(), &mut |_| Err(String::new()), "model").unwrap();
    assert_eq!(loaded.scene.meshes[0].primitives[0].positions, [[0.0; 3]]);
    assert!(loaded.warnings[0].contains("/accessors/0/bufferView"), "{:?}", loaded.warnings);

    let padded = format!("{text:width$}", width = text.len().next_multiple_of(4));
    let glb = |chunks: &[(&[u8; 4], &[u8])]| {
        let body: Vec<u8> = chunks
            .iter()
            .flat_map(|(kind, bytes)| [&(bytes.len() as u32).to_le_bytes()[..], &kind[..], bytes].concat())
            .collect();
        [b"glTF\x02\0\0\0", &(12 + body.len() as u32).to_le_bytes()[..], &body].concat()
    };
    let alone = glb(&[(b"JSON", padded.as_bytes())]);
    let error = load_bytes(&alone, &mut |_| Err(String::new()), "model.glb").unwrap_err();
    assert!(error.to_string().contains("binary chunk"), "{error}");
    let whole = glb(&[(b"JSON", padded.as_bytes()), (b"meta", b"abcd"), (b"BIN\0", &floats(&[1.0, 2.0, 3.0]))]);
    let loaded = load_bytes(&whole, &mut |_| Err(String::new()), "model.glb").unwrap();
    assert_eq!(loaded.scene.meshes[0].primitives[0].positions, [[1.0, 2.0, 3.0]]);
}

/// A point with these joints and weights, in a node with a skin of nine joints.
fn skinned(sets: &[(u32, [i64; 4], u32, Vec<u8>)]) -> Model {
    let mut model = Model::with_positions(0, &[[0.0; 3]]);
    for (i, (joint_type, joints, weight_type, weights)) in sets.iter().enumerate() {
        model.attribute(&format!("JOINTS_{i}"), *joint_type, "VEC4", &integers(*joint_type, joints));
        let weight = model.attribute(&format!("WEIGHTS_{i}"), *weight_type, "VEC4", weights);
        model.json["accessors"][weight]["normalized"] = json!(*weight_type != F32);
    }
    let joints: Vec<Value> =
        (0..10).map(|i| if i == 0 { json!({ "mesh": 0, "skin": 0 }) } else { json!({}) }).collect();
    model.json["nodes"] = json!(joints);
    model.json["scenes"] = json!([{ "nodes": (0..10).collect::<Vec<_>>() }]);
    model.json["skins"] = json!([{ "joints": (1..10).collect::<Vec<_>>() }]);
    model
}

#[test]
fn joints_and_weights_come_back_in_every_type() {
    for joint_type in [U8, U16] {
        for (weight_type, weights) in [
            (F32, floats(&[0.2, 0.8, 0.0, 0.0])),
            (U8, integers(U8, &[51, 204, 0, 0])),
            (U16, integers(U16, &[13107, 52428, 0, 0])),
        ] {
            // A joint without weight is 0, whatever the file says.
            let primitive = skinned(&[(joint_type, [3, 8, 200, 1], weight_type, weights)]).load_primitive();
            assert_eq!(primitive.joints, [[3, 8, 0, 0]]);
            assert_eq!(primitive.weights[0][2..], [0.0, 0.0]);
            assert!((primitive.weights[0][0] - 0.2).abs() < 1e-6 && (primitive.weights[0][1] - 0.8).abs() < 1e-6);
        }
    }
    let error = skinned(&[(U8, [3, 9, 0, 0], F32, floats(&[0.5, 0.5, 0.0, 0.0]))]).try_load().unwrap_err();
    assert!(error.to_string().contains("uses joint 9"), "{error}");
}

#[test]
fn of_eight_joints_the_strongest_four_move_a_vertex() {
    let sets = [
        (U8, [0, 1, 2, 3], F32, floats(&[0.1, 0.05, 0.2, 0.05])),
        (U8, [4, 5, 6, 7], F32, floats(&[0.05, 0.3, 0.05, 0.2])),
    ];
    let loaded = skinned(&sets).try_load().unwrap();
    let primitive = &loaded.scene.meshes[0].primitives[0];
    assert_eq!(primitive.joints, [[5, 2, 7, 0]]);
    for (weight, expected) in primitive.weights[0].iter().zip([0.375, 0.25, 0.25, 0.125]) {
        assert!((weight - expected).abs() < 1e-6, "{:?}", primitive.weights);
    }
    assert!(loaded.warnings[0].contains("JOINTS_1"), "{:?}", loaded.warnings);
    // Four joints spread over two sets lose nothing.
    let sets = [
        (U8, [1, 0, 0, 0], F32, floats(&[0.75, 0.0, 0.0, 0.0])),
        (U8, [2, 0, 0, 0], F32, floats(&[0.25, 0.0, 0.0, 0.0])),
    ];
    let primitive = skinned(&sets).load_primitive();
    assert_eq!((primitive.joints, primitive.weights), (vec![[1, 2, 0, 0]], vec![[0.75, 0.25, 0.0, 0.0]]));
}

#[test]
fn morph_targets_come_back_with_their_weights() {
    let mut model = Model::with_positions(0, &[[0.0; 3]]);
    let dense = model.accessor(F32, "VEC3", &floats(&[1.0, 2.0, 3.0]));
    let small = model.accessor(I8, "VEC4", &integers(I8, &[-127, 0, 127, 0]));
    model.json["accessors"][small]["type"] = json!("VEC3");
    model.json["accessors"][small]["normalized"] = json!(true);
    model.primitive()["targets"] = json!([{ "POSITION": dense }, { "POSITION": small, "NORMAL": dense }]);
    model.json["meshes"][0]["weights"] = json!([0.25, 0.5]);
    model.json["nodes"][0]["weights"] = json!([1, -1]);
    let scene = model.load().scene;
    let mesh = &scene.meshes[0];
    assert_eq!(
        (mesh.default_morph_weights.as_slice(), scene.nodes[0].morph_weights.as_slice()),
        (&[0.25, 0.5][..], &[1.0, -1.0][..])
    );
    let [first, second] = &mesh.primitives[0].morph_targets[..] else { panic!("two targets") };
    assert_eq!((first.positions.as_slice(), first.normals.len()), (&[[1.0, 2.0, 3.0]][..], 0));
    assert_eq!((second.positions[0], second.normals[0]), ([-1.0, 0.0, 1.0], [1.0, 2.0, 3.0]));
}

#[test]
fn missing_normals_are_flat_and_mirrored_nodes_keep_their_matrices() {
    let mut model = Model::triangle();
    model.json["nodes"] = json!([{ "mesh": 0, "scale": [-1, 2, 1], "translation": [5, 0, 0] }]);
    let scene = model.load().scene;
    assert_eq!(scene.meshes[0].primitives[0].normals, [[0.0, 0.0, 1.0]; 3]);
    assert!(scene.nodes[0].world_from_object.determinant() < 0.0);
    let bounds = scene.bounds_world();
    assert_eq!((bounds.min.to_array(), bounds.max.to_array()), ([4.0, 0.0, 0.0], [5.0, 2.0, 0.0]));
    // A shear does not decompose, so that the matrix stays.
    let mut model = Model::triangle();
    model.json["nodes"] = json!([{ "mesh": 0, "matrix": [1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1] }]);
    let scene = model.load().scene;
    let corner = scene.nodes[0].world_from_object.transform_point3(glam::vec3(0.0, 1.0, 0.0));
    assert_eq!(corner.to_array(), [8.0, 9.0, 9.0]);
}
