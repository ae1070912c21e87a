//! `KHR_animation_pointer`: every kind of property, at known times; and pointers to what nothing can animate.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::{F32, Model, U8, floats};
use glam::{Quat, Vec2, Vec3, Vec4};
use manypass_scene::{AlphaMode, LightKind, Projection, Scene};
use serde_json::{Value, json};

/// A triangle with a material, a light and a camera, of which `pointer` is animated between 1 s and 3 s.
fn model(pointer: &str, kind: &str, values: &[f32]) -> Model {
    let mut model = Model::triangle();
    let input = model.accessor(F32, "SCALAR", &floats(&[1.0, 3.0]));
    let output = model.accessor(F32, kind, &floats(values));
    let texture = json!({ "index": 0 });
    model.json["images"] = json!([{ "uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==" }]);
    model.json["textures"] = json!([{ "source": 0 }]);
    model.json["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": texture },
        "emissiveFactor": [1.0, 0.5, 0.0],
        "alphaMode": "MASK",
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 4.0 },
            "KHR_materials_clearcoat": { "clearcoatFactor": 0.25, "clearcoatTexture": texture },
        },
    }]);
    model.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    model.json["cameras"] = json!([
        { "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.5, "zfar": 9.0 } },
        { "type": "orthographic", "orthographic": { "xmag": 1.0, "ymag": 1.0, "znear": 0.5, "zfar": 9.0 } },
    ]);
    model.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": {} }] } });
    model.json["extensionsUsed"] = json!(["KHR_animation_pointer", "KHR_lights_punctual"]);
    model.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    model.json["animations"] = json!([{
        "samplers": [{ "input": input, "output": output }],
        "channels": [{
            "sampler": 0,
            "target": { "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } },
        }],
    }]);
    model
}

/// The scene half way between two keys.
fn half_way(pointer: &str, kind: &str, values: &[f32]) -> Scene {
    let loaded = model(pointer, kind, values).load();
    assert_eq!(loaded.warnings, [""; 0], "{pointer}");
    let mut scene = loaded.scene;
    assert_eq!(scene.animations[0].duration_secs(), 3.0);
    scene.pose(0, 2.0);
    scene
}

#[test]
fn factors_of_materials_follow_their_keys() {
    let factor = |path: &str, kind: &str, values: &[f32]| {
        half_way(&format!("/materials/0/{path}"), kind, values).materials.remove(0)
    };
    let base = factor("pbrMetallicRoughness/baseColorFactor", "VEC4", &[0.0, 0.0, 0.0, 1.0, 1.0, 0.5, 0.25, 0.0]);
    assert_eq!(base.base_color_factor, Vec4::new(0.5, 0.25, 0.125, 0.5));
    assert_eq!(factor("pbrMetallicRoughness/roughnessFactor", "SCALAR", &[0.0, 1.0]).roughness_factor, 0.5);
    // Keys may leave the range.
    assert_eq!(factor("pbrMetallicRoughness/metallicFactor", "SCALAR", &[1.0, 9.0]).metallic_factor, 1.0);
    assert_eq!(factor("alphaCutoff", "SCALAR", &[0.0, 0.5]).alpha_mode, AlphaMode::Mask { cutoff: 0.25 });
    // Emission is colour times strength, whichever of them moves.
    let color = factor("emissiveFactor", "VEC3", &[0.0, 0.0, 0.0, 1.0, 1.0, 2.0]);
    assert_eq!(color.emissive_factor, Vec3::new(2.0, 2.0, 4.0));
    let path = "extensions/KHR_materials_emissive_strength/emissiveStrength";
    assert_eq!(factor(path, "SCALAR", &[0.0, 2.0]).emissive_factor, Vec3::new(1.0, 0.5, 0.0));
    let path = "extensions/KHR_materials_clearcoat/clearcoatFactor";
    let coat = factor(path, "SCALAR", &[0.0, 1.0]).clearcoat.unwrap();
    assert!(coat.weight.factor == 0.5 && coat.weight.texture.is_some());
    // A layer that was not there.
    let path = "extensions/KHR_materials_transmission/transmissionFactor";
    assert_eq!(factor(path, "SCALAR", &[0.0, 1.0]).transmission.unwrap().factor, 0.5);
    let path = "extensions/KHR_materials_volume/attenuationColor";
    let volume = factor(path, "VEC3", &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]).volume.unwrap();
    assert_eq!(volume.attenuation_color, Vec3::splat(0.5));
}

/// Both move at once, whichever stands first; twice the same time gives twice the same light.
#[test]
fn colour_and_strength_of_emission_multiply_each_other() {
    for is_strength_first in [false, true] {
        let mut model = model("/materials/0/emissiveFactor", "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.5, 2.0]);
        let input = model.accessor(F32, "SCALAR", &floats(&[1.0, 3.0]));
        let output = model.accessor(F32, "SCALAR", &floats(&[2.0, 6.0]));
        let pointer = "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength";
        let target = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } });
        let animation = &mut model.json["animations"][0];
        animation["samplers"].as_array_mut().unwrap().push(json!({ "input": input, "output": output }));
        let channels = animation["channels"].as_array_mut().unwrap();
        let at = if is_strength_first { 0 } else { 1 };
        channels.insert(at, json!({ "sampler": 1, "target": target }));
        let mut scene = model.load().scene;
        for _ in 0..2 {
            scene.pose(0, 2.0);
            assert_eq!(scene.materials[0].emissive_factor, Vec3::new(2.0, 1.0, 4.0), "{is_strength_first}");
        }
        scene.pose(0, 9.0);
        assert_eq!(scene.materials[0].emissive_factor, Vec3::new(6.0, 3.0, 12.0));
    }
}

#[test]
fn layers_that_grow_from_nothing_are_the_files_own() {
    let mut growing = model("/materials/0/extensions/KHR_materials_clearcoat/clearcoatFactor", "SCALAR", &[0.0, 1.0]);
    let coat = json!({ "clearcoatFactor": 0.0, "clearcoatRoughnessFactor": 0.5, "clearcoatTexture": { "index": 0 } });
    growing.json["materials"][0]["extensions"]["KHR_materials_clearcoat"] = coat;
    let mut scene = growing.load().scene;
    scene.pose(0, 2.0);
    let grown = scene.materials[0].clearcoat.unwrap();
    assert!(grown.weight.factor == 0.5 && grown.weight.texture.is_some() && grown.roughness.factor == 0.5);
}

#[test]
fn splines_that_leave_the_numbers_change_nothing() {
    let huge = 3e38;
    let mut spline = model(
        "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle",
        "SCALAR",
        &[0.0, 0.5, huge, huge, 0.5, 0.0],
    );
    spline.json["animations"][0]["samplers"][0]["interpolation"] = json!("CUBICSPLINE");
    let mut scene = spline.load().scene;
    for step in 0..40u8 {
        scene.pose(0, f32::from(step) / 10.0);
        let LightKind::Spot { inner_cone_rad, outer_cone_rad } = scene.lights[0].kind else { panic!("no spot") };
        assert!((0.0..=outer_cone_rad).contains(&inner_cone_rad), "{inner_cone_rad} {outer_cone_rad}");
    }
}

#[test]
fn textures_move_over_surfaces() {
    for slot in ["pbrMetallicRoughness/baseColorTexture", "extensions/KHR_materials_clearcoat/clearcoatTexture"] {
        let moved = |part: &str, kind: &str, values: &[f32]| {
            let pointer = format!("/materials/0/{slot}/extensions/KHR_texture_transform/{part}");
            let material = half_way(&pointer, kind, values).materials.remove(0);
            let coat = material.clearcoat.unwrap().weight.texture;
            if slot.contains("base") { material.base_color_texture } else { coat }.unwrap().transform
        };
        assert_eq!(moved("offset", "VEC2", &[0.0, 0.0, 1.0, 2.0]).offset, Vec2::new(0.5, 1.0));
        assert_eq!(moved("scale", "VEC2", &[1.0, 1.0, 3.0, 5.0]).scale, Vec2::new(2.0, 3.0));
        assert_eq!(moved("rotation", "SCALAR", &[0.0, 1.0]).rotation_rad, 0.5);
    }
}

#[test]
fn lights_and_cameras_follow_their_keys() {
    let light = |path: &str, kind: &str, values: &[f32]| {
        half_way(&format!("/extensions/KHR_lights_punctual/lights/0/{path}"), kind, values).lights.remove(0)
    };
    assert_eq!(light("color", "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.5, 0.0]).color_linear, Vec3::new(0.5, 0.25, 0.0));
    assert_eq!(light("intensity", "SCALAR", &[0.0, 8.0]).intensity, 4.0);
    assert_eq!(light("range", "SCALAR", &[2.0, 4.0]).range_m, Some(3.0));
    let cone = light("spot/outerConeAngle", "SCALAR", &[0.5, 0.7]).kind;
    assert!(matches!(cone, LightKind::Spot { outer_cone_rad, .. } if (outer_cone_rad - 0.6).abs() < 1e-6));
    let camera = |index: usize, path: &str, values: &[f32]| {
        half_way(&format!("/cameras/{index}/{path}"), "SCALAR", values).cameras[index].projection
    };
    assert!(matches!(
        camera(0, "perspective/yfov", &[0.5, 1.5]),
        Projection::Perspective { fov_y_rad: 1.0, near_m: 0.5, far_m: Some(9.0) }
    ));
    // What would be no projection is left out.
    assert!(matches!(camera(0, "perspective/znear", &[20.0, 20.0]), Projection::Perspective { near_m: 0.5, .. }));
    assert!(matches!(camera(1, "orthographic/ymag", &[1.0, 2.0]), Projection::Orthographic { height_m: 3.0, .. }));
}

#[test]
fn nodes_are_animated_by_pointers_as_by_paths() {
    let scene = half_way("/nodes/0/translation", "VEC3", &[0.0, 0.0, 0.0, 2.0, 4.0, 6.0]);
    assert_eq!(scene.nodes[0].translation, Vec3::new(1.0, 2.0, 3.0));
    let turn = Quat::from_rotation_y(1.0).to_array();
    let scene = half_way("/nodes/0/rotation", "VEC4", &[[0.0, 0.0, 0.0, 1.0], turn].concat());
    assert!(scene.nodes[0].rotation.angle_between(Quat::from_rotation_y(0.5)) < 1e-3);
    let mut blinking = model("/nodes/0/extensions/KHR_node_visibility/visible", "SCALAR", &[0.0, 0.0]);
    let shown = blinking.accessor(U8, "SCALAR", &[0, 1]);
    blinking.json["animations"][0]["samplers"][0]["output"] = json!(shown);
    blinking.json["animations"][0]["samplers"][0]["interpolation"] = json!("STEP");
    let mut scene = blinking.load().scene;
    for (time_secs, is_visible) in [(0.0, false), (2.9, false), (3.0, true)] {
        scene.pose(0, time_secs);
        assert_eq!(scene.nodes[0].is_visible, is_visible, "{time_secs} s");
    }
}

#[test]
fn pointers_to_nothing_and_broken_keys_are_passed_over() {
    for pointer in ["", "/", "/materials/7/alphaCutoff", "/materials/0/name", "/nodes/-1/scale", "/cameras/0/", "é/é/é"]
    {
        let loaded = model(pointer, "SCALAR", &[0.0, 1.0]).try_load().unwrap();
        assert!(loaded.warnings.iter().any(|warning| warning.contains("cannot be animated")), "{pointer}");
        assert!(loaded.scene.animations[0].properties.is_empty());
    }
    // Broken keys cost the channel alone, and so does a pointer that is no text.
    let mut without_pointer = model("/materials/0/alphaCutoff", "SCALAR", &[0.0, 1.0]);
    without_pointer.json["animations"][0]["channels"][0]["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
        Value::Null;
    for (model, said) in [
        (model("/materials/0/alphaCutoff", "SCALAR", &[0.0, f32::NAN]), "expected finite numbers"),
        (model("/materials/0/alphaCutoff", "VEC2", &[0.0; 4]), "expected 1 components"),
        (without_pointer, "pointer\": expected a string"),
    ] {
        let loaded = model.try_load().unwrap();
        assert!(loaded.scene.animations[0].properties.is_empty());
        let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
        assert!(warning.contains(said) && warning.ends_with("; the channel is passed over"), "{warning}");
    }
    // Values behind the last keyframe are not needed.
    let loaded = model("/materials/0/alphaCutoff", "SCALAR", &[0.0, 1.0, 2.0]).try_load().unwrap();
    let [channel] = &loaded.scene.animations[0].properties[..] else { panic!("one channel") };
    assert_eq!((&channel.times_secs[..], &channel.values[..]), (&[1.0, 3.0][..], &[0.0, 1.0][..]));
    let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
    assert!(warning.contains("expected 2 elements, found more; the rest is passed over"), "{warning}");
}
