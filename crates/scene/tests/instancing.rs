//! `EXT_mesh_gpu_instancing`: every instance is where the product of its node's matrix and its own places it.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::{F32, I16, Model, floats, integers, push};
use glam::{Mat4, Quat, Vec3};
use manypass_scene::{Scene, load_path};
use manypass_testkit::needs::assets;
use serde_json::json;

/// A triangle whose node is instanced by `attributes`.
fn instanced(attributes: &[(&str, u32, &str, Vec<u8>)]) -> Model {
    let mut model = Model::triangle();
    let accessors = attributes.iter().map(|(key, component, kind, bytes)| {
        let accessor = model.accessor(*component, kind, bytes);
        model.json["accessors"][accessor]["normalized"] = json!(*component != F32);
        ((*key).to_owned(), json!(accessor))
    });
    let accessors: serde_json::Map<_, _> = accessors.collect();
    model.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": accessors } });
    model.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    model
}

/// `world_from_object` of everything that is drawn.
fn matrices(scene: &Scene) -> Vec<Mat4> {
    let drawn = scene.visible_nodes().into_iter().filter(|id| scene.node(*id).mesh.is_some());
    drawn.map(|id| scene.node(id).world_from_object).collect()
}

const PLACES: [[f32; 3]; 3] = [[1.0, 2.0, 3.0], [-4.0, 0.5, 0.0], [0.0, 0.0, 7.0]];
const SIZES: [[f32; 3]; 3] = [[1.0, 1.0, 1.0], [2.0, -1.0, 0.5], [0.1, 3.0, 1.0]];

#[test]
fn places_rotations_and_sizes_are_below_those_of_the_node() {
    let turns = [[0, 0, 0, 32767], [23170, 0, 0, 23170], [0, -16384, 0, 28377]];
    let mut model = instanced(&[
        ("TRANSLATION", F32, "VEC3", floats(PLACES.as_flattened())),
        ("ROTATION", I16, "VEC4", integers(I16, turns.map(|turn| turn.map(i64::from)).as_flattened())),
        ("SCALE", F32, "VEC3", floats(SIZES.as_flattened())),
        ("_TEMPERATURE", F32, "SCALAR", floats(&[1.0, 2.0, 3.0])),
    ]);
    model.json["nodes"][0]["translation"] = json!([0, 10, 0]);
    model.json["nodes"][0]["scale"] = json!([2, 2, 2]);
    model.json["nodes"][0]["name"] = json!("leaf");
    push(&mut model.json["nodes"], json!({ "children": [0], "rotation": [0, 0, 1, 0] }));
    model.json["scenes"][0]["nodes"] = json!([1]);
    let scene = model.load().scene;
    let world_from_node = Mat4::from_rotation_z(std::f32::consts::PI)
        * Mat4::from_translation(Vec3::Y * 10.0)
        * Mat4::from_scale(Vec3::splat(2.0));
    let angles = [0.0, std::f32::consts::FRAC_PI_2, -std::f32::consts::FRAC_PI_3];
    let axes = [Vec3::X, Vec3::X, Vec3::Y];
    let found = matrices(&scene);
    assert_eq!(found.len(), 3);
    for (i, found) in found.iter().enumerate() {
        let turn = Quat::from_axis_angle(axes[i], angles[i]);
        let node_from_mesh = Mat4::from_scale_rotation_translation(SIZES[i].into(), turn, PLACES[i].into());
        assert!(found.abs_diff_eq(world_from_node * node_from_mesh, 3e-3), "{i}: {found}");
    }
    assert!(scene.nodes[2..].iter().all(|node| node.mesh == Some(0) && node.name == "leaf"));
}

#[test]
fn what_is_left_out_is_nothing_one_and_unturned() {
    for (key, width) in [("TRANSLATION", 3), ("ROTATION", 4), ("SCALE", 3)] {
        let numbers = [0.6, 0.0, 0.8, 0.0, 0.0, 1.0, 0.0, 0.0];
        let kind = if width == 4 { "VEC4" } else { "VEC3" };
        let scene = instanced(&[(key, F32, kind, floats(&numbers[..2 * width]))]).load().scene;
        let expected = match key {
            "TRANSLATION" => Mat4::from_translation(Vec3::new(0.6, 0.0, 0.8)),
            "ROTATION" => Mat4::from_quat(Quat::from_xyzw(0.6, 0.0, 0.8, 0.0)),
            _ => Mat4::from_scale(Vec3::new(0.6, 0.0, 0.8)),
        };
        assert!(matrices(&scene)[0].abs_diff_eq(expected, 1e-6), "{key}");
    }
    // Without attributes the mesh is drawn once, as without the extension.
    assert_eq!(matrices(&instanced(&[]).load().scene), [Mat4::IDENTITY]);
}

#[test]
fn what_is_wrong_is_named_and_numbers_have_a_limit() {
    let three = || floats(PLACES.as_flattened());
    let refused = |attributes: &[_]| instanced(attributes).try_load().unwrap_err().to_string();
    let place = "model.gltf: at \"/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/";
    for (error, part) in [
        (
            refused(&[("SCALE", F32, "VEC3", three()), ("TRANSLATION", F32, "VEC3", floats(&[0.0; 6]))]),
            "expected 3 elem",
        ),
        (refused(&[("TRANSLATION", I16, "VEC3", vec![0; 12])]), "expected floats"),
        (refused(&[("SCALE", F32, "VEC3", floats(&[f32::NAN; 3]))]), "expected finite numbers"),
    ] {
        assert!(error.starts_with(place) && error.contains(part), "{error}");
    }
    assert!(refused(&[("ROTATION", F32, "VEC3", three())]).contains("expected 4 components"));
    let many = |count: usize| {
        let mut model = instanced(&[("TRANSLATION", F32, "VEC3", three())]);
        let accessor = model.json["accessors"].as_array().unwrap().len() - 1;
        // The same places over and over, without bytes of their own.
        model.json["accessors"][accessor] = json!({ "componentType": F32, "type": "VEC3", "count": count });
        model.try_load()
    };
    assert_eq!(many(100_000).unwrap().scene.nodes.len(), 100_001);
    assert!(many((1 << 20) + 1).unwrap_err().to_string().contains("more than 1048576 instances"));
    assert!(many(900_000).unwrap_err().to_string().contains("far more than its buffers hold"));
}

#[test]
fn the_shared_models_have_their_instances() {
    let Some(assets) = assets("") else { return };
    for (model, count) in [
        ("khronos-sample-assets/Models/SimpleInstancing/glTF-Binary/SimpleInstancing.glb", 125),
        ("sharpgltf/gltf-GpuMeshInstancing/InstanceTest.glb", 2500),
    ] {
        let loaded = load_path(&assets.join(model)).unwrap();
        assert_eq!((matrices(&loaded.scene).len(), loaded.warnings.len()), (count, 0), "{:?}", loaded.warnings);
    }
}
