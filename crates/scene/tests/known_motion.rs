//! Animations, skins, cameras and lights with known answers.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::{F32, I8, I16, Model, U8, U16, floats, integers};
use glam::{Quat, Vec3, vec3};
use manypass_scene::{Interpolation, LightKind, Node, Projection};
use serde_json::{Value, json};

/// A triangle whose node is animated between 1 s and 3 s.
fn animated(path: &str, interpolation: &str, (component, kind, bytes): (u32, &str, &[u8])) -> Model {
    let mut model = Model::triangle();
    let input = model.accessor(F32, "SCALAR", &floats(&[1.0, 3.0]));
    let output = model.accessor(component, kind, bytes);
    model.json["accessors"][output]["normalized"] = json!(component != F32);
    model.json["animations"] = json!([{
        "name": "Move",
        "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": path } }],
    }]);
    model
}

/// The node at a time.
#[track_caller]
fn at(model: Model, time_secs: f32) -> Node {
    let mut scene = model.load().scene;
    assert_eq!((scene.animations[0].name.as_str(), scene.animations[0].duration_secs()), ("Move", 3.0));
    scene.pose(0, time_secs);
    scene.nodes[0].clone()
}

#[test]
fn translations_and_scales_follow_their_keys() {
    let keys = floats(&[0.0, 0.0, 0.0, 4.0, -2.0, 8.0]);
    // In-tangent, value and out-tangent of each; the slopes of t² from 1 to 3 in every component.
    let cubic: Vec<f32> = [1.0_f32, 3.0].iter().flat_map(|t| [2.0 * t, t * t, 2.0 * t]).flat_map(|v| [v; 3]).collect();
    let cases: [(&str, Vec<u8>, f32, Vec3); 8] = [
        ("STEP", keys.clone(), 2.9, Vec3::ZERO),
        ("STEP", keys.clone(), 3.0, vec3(4.0, -2.0, 8.0)),
        ("LINEAR", keys.clone(), 1.5, vec3(1.0, -0.5, 2.0)),
        ("LINEAR", keys.clone(), 0.0, Vec3::ZERO),
        ("LINEAR", keys, 99.0, vec3(4.0, -2.0, 8.0)),
        ("CUBICSPLINE", floats(&cubic), 1.0, Vec3::ONE),
        ("CUBICSPLINE", floats(&cubic), 2.0, Vec3::splat(4.0)),
        ("CUBICSPLINE", floats(&cubic), 2.5, Vec3::splat(6.25)),
    ];
    for (interpolation, bytes, time_secs, expected) in cases {
        for path in ["translation", "scale"] {
            let node = at(animated(path, interpolation, (F32, "VEC3", &bytes)), time_secs);
            let (moved, other) =
                if path == "scale" { (node.scale, node.translation) } else { (node.translation, node.scale - 1.0) };
            assert!(moved.abs_diff_eq(expected, 1e-5), "{interpolation} {time_secs}: {moved}");
            assert_eq!(other, Vec3::ZERO);
        }
    }
}

#[test]
fn rotations_turn_the_short_way_in_every_type() {
    // From nothing to a quarter turn around y, which is half of 2 · 45°.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let quantized = |component, max: f32| {
        let top = (half * max).round() as i64;
        (component, integers(component, &[0, 0, 0, max as i64, 0, top, 0, top]))
    };
    let keys = [
        (F32, floats(&[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half])),
        (F32, floats(&[0.0, 0.0, 0.0, 1.0, 0.0, -half, 0.0, -half])),
        quantized(I8, 127.0),
        quantized(U8, 255.0),
        quantized(I16, 32767.0),
        quantized(U16, 65535.0),
    ];
    for (component, bytes) in keys {
        for (time_secs, angle) in [(1.0, 0.0_f32), (2.0, 45.0), (3.0, 90.0)] {
            let node = at(animated("rotation", "LINEAR", (component, "VEC4", &bytes)), time_secs);
            let expected = Quat::from_rotation_y(angle.to_radians());
            let tolerance = if component == I8 { 1e-4 } else { 1e-5 };
            assert!(node.rotation.dot(expected).abs() > 1.0 - tolerance, "{component} {time_secs}: {}", node.rotation);
            assert!(node.rotation.is_normalized());
        }
    }
    // Without tangents a spline eases: after a quarter of the time the second key weighs 5/32.
    let cubic =
        floats(&[[0.0; 4], [0.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0; 4], [0.0, half, 0.0, half], [0.0; 4]].concat());
    let rotation = at(animated("rotation", "CUBICSPLINE", (F32, "VEC4", &cubic)), 1.5).rotation;
    let eased = 5.0 / 32.0;
    let expected = Quat::from_xyzw(0.0, eased * half, 0.0, 1.0 - eased + eased * half).normalize();
    assert!(rotation.dot(expected) > 0.999_999, "{rotation} {expected}");
}

#[test]
fn morph_weights_follow_their_keys() {
    for (interpolation, values, expected) in [
        ("STEP", vec![1.0, 2.0, 3.0, 6.0], [1.0, 2.0]),
        ("LINEAR", vec![1.0, 2.0, 3.0, 6.0], [1.5, 3.0]),
        // All in-tangents, then all values, then all out-tangents of a key.
        ("CUBICSPLINE", vec![0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 3.0, 6.0, 0.0, 0.0], [1.3125, 2.625]),
    ] {
        let mut model = animated("weights", interpolation, (F32, "SCALAR", &floats(&values)));
        model.primitive()["targets"] = json!([{ "POSITION": 0 }, { "POSITION": 0 }]);
        assert_eq!(at(model, 1.5).morph_weights, expected, "{interpolation}");
    }
    let mut model = animated("weights", "LINEAR", (U8, "SCALAR", &[0, 51, 255, 0]));
    model.primitive()["targets"] = json!([{ "POSITION": 0 }, { "POSITION": 0 }]);
    assert_eq!(at(model, 3.0).morph_weights, [1.0, 0.0]);
}

/// A model is drawn as it stands where what moves it is broken: that costs the channel, and a warning says so.
#[test]
fn animations_that_contradict_themselves_move_nothing() {
    let passed_over = |model: Model| {
        let loaded = model.try_load().unwrap();
        assert_eq!(loaded.scene.animations[0].channels.len(), 0, "{:?}", loaded.warnings);
        let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
        assert!(warning.ends_with("; the channel is passed over"), "{warning}");
        warning.clone()
    };
    let broken = |change: &dyn Fn(&mut Value)| {
        let mut model = animated("translation", "LINEAR", (F32, "VEC3", &floats(&[0.0; 6])));
        change(&mut model.json);
        passed_over(model)
    };
    let sampler = |key: &'static str, value: Value| {
        broken(&move |json| json["animations"][0]["samplers"][0][key] = value.clone())
    };
    assert!(sampler("interpolation", json!("CUBICSPLINE")).contains("expected 6 elements, found 2"));
    assert!(sampler("input", json!(0)).contains("/animations/0/samplers/0/input"));
    assert!(sampler("output", json!(9)).contains("/animations/0/samplers/0/output"));
    assert!(broken(&|json| json["animations"][0]["channels"][0]["sampler"] = json!(1)).contains("/channels/0/sampler"));
    assert!(broken(&|json| json["accessors"][2]["type"] = json!("VEC2")).contains("/accessors/2/type"));
    let endless = floats(&[0.0, f32::NAN, 0.0, 0.0, 0.0, 0.0]);
    assert!(passed_over(animated("translation", "LINEAR", (F32, "VEC3", &endless))).contains("finite"));
    // An interpolation that is not known is the default one.
    let loaded = animated("translation", "SPLINE", (F32, "VEC3", &floats(&[0.0; 6]))).try_load().unwrap();
    assert_eq!(loaded.scene.animations[0].channels[0].interpolation, Interpolation::Linear);
    let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
    assert!(warning.contains("expected STEP, LINEAR or CUBICSPLINE, found SPLINE; LINEAR is used"), "{warning}");
}

#[test]
fn joint_matrices_are_the_world_times_the_inverse_bind() {
    let mut model = Model::triangle();
    model.attribute("JOINTS_0", U8, "VEC4", &[0; 12]);
    model.attribute("WEIGHTS_0", F32, "VEC4", &floats(&[[1.0, 0.0, 0.0, 0.0]; 3].concat()));
    let inverse_bind = glam::Mat4::from_translation(vec3(-1.0, 0.0, 0.0));
    let matrices = model.accessor(F32, "MAT4", &floats(&inverse_bind.to_cols_array()));
    model.json["nodes"] =
        json!([{ "mesh": 0, "skin": 0, "translation": [50, 0, 0] }, { "translation": [0, 3, 0], "scale": [2, 2, 2] }]);
    model.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    model.json["skins"] = json!([{ "joints": [1], "inverseBindMatrices": matrices }]);
    let scene = model.load().scene;
    let moved = scene.joint_matrices(0)[0].transform_point3(vec3(1.0, 1.0, 0.0));
    assert_eq!(moved, vec3(0.0, 5.0, 0.0));
    // The node of a skinned mesh does not move it.
    let bounds = scene.posed_bounds_world();
    assert_eq!((bounds.min, bounds.max), (vec3(-2.0, 3.0, 0.0), vec3(0.0, 5.0, 0.0)));
}

/// glTF: what a camera sees should not be cropped, whatever shape the picture has.
#[test]
fn all_that_a_camera_sees_is_in_pictures_of_every_shape() {
    let perspective = json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1, "aspectRatio": 2 } });
    let parallel = json!({ "type": "orthographic", "orthographic": { "xmag": 4, "ymag": 2, "znear": 0, "zfar": 8 } });
    let shapeless = json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } });
    let (tangent, height) = ((0.25f32).tan(), 2.0);
    for (camera, half_height, is_shaped) in
        [(perspective, tangent, true), (parallel, height, true), (shapeless, tangent, false)]
    {
        let mut model = Model::triangle();
        model.json["cameras"] = json!([camera]);
        model.json["nodes"][0]["camera"] = json!(0);
        let scene = model.load().scene;
        for aspect in [0.5f32, 1.0, 1.9, 2.0, 3.0] {
            let (_, projection) = scene.first_camera(aspect).unwrap();
            let half = projection.half_extent(aspect);
            let expected = if is_shaped { half_height * (2.0 / aspect).max(1.0) } else { half_height };
            assert!((half.y / expected - 1.0).abs() < 1e-5, "{camera} at {aspect}: {half}");
        }
    }
}

#[test]
fn cameras_of_both_kinds_are_read() {
    let read = |camera: Value| {
        let mut model = Model::triangle();
        model.json["cameras"] = json!([camera]);
        let loaded = model.try_load().unwrap();
        let projection = loaded.scene.cameras[0].projection;
        if loaded.warnings.is_empty() { Ok(projection) } else { Err((projection, loaded.warnings.join("\n"))) }
    };
    let perspective = |lens: Value| read(json!({ "type": "perspective", "perspective": lens }));
    let orthographic = |lens: Value| read(json!({ "type": "orthographic", "orthographic": lens }));
    assert_eq!(
        perspective(json!({ "yfov": 0.5, "znear": 0.1 })),
        Ok(Projection::Perspective { fov_y_rad: 0.5, near_m: 0.1, far_m: None })
    );
    assert_eq!(
        perspective(json!({ "yfov": 0.5, "znear": 0.1, "zfar": 8, "aspectRatio": 2 })),
        Ok(Projection::Perspective { fov_y_rad: 0.5, near_m: 0.1, far_m: Some(8.0) })
    );
    assert_eq!(
        orthographic(json!({ "xmag": 3, "ymag": -2, "znear": 0, "zfar": 8 })),
        Ok(Projection::Orthographic { height_m: 4.0, near_m: 0.0, far_m: 8.0 })
    );
    // Pictures by other cameras do not need a broken one, which has a lens of its own then.
    let instead = Projection::Perspective { fov_y_rad: std::f32::consts::FRAC_PI_4, near_m: 0.01, far_m: None };
    for (broken, place) in [
        (perspective(json!({ "yfov": 0, "znear": 0.1 })), "perspective/yfov"),
        (perspective(json!({ "yfov": 0.5, "znear": 1, "zfar": 1 })), "perspective/zfar"),
        (orthographic(json!({ "xmag": 1, "ymag": 0, "znear": 0, "zfar": 1 })), "orthographic/ymag"),
        (orthographic(json!({ "xmag": 1, "ymag": 1, "znear": 2, "zfar": 1 })), "orthographic/zfar"),
        (read(json!({ "type": "fisheye" })), "/cameras/0/type"),
    ] {
        let (projection, warning) = broken.unwrap_err();
        assert_eq!(projection, instead, "{place}");
        assert!(
            warning.contains(place) && warning.ends_with("; a perspective lens of 45 degrees is used"),
            "{warning}"
        );
    }
}

#[test]
fn nodes_are_hidden_with_all_below_them() {
    let load = |extension: Value| {
        let mut model = Model::triangle();
        model.json["nodes"] = json!([{ "children": [1] }, { "mesh": 0 }]);
        model.json["nodes"][0]["extensions"] = json!({ "KHR_node_visibility": extension });
        model.json["extensionsRequired"] = json!(["KHR_node_visibility"]);
        model.try_load()
    };
    for (extension, count) in [(json!({ "visible": false }), 0), (json!({ "visible": true }), 2), (json!({}), 2)] {
        let loaded = load(extension).unwrap();
        // A scene of which all is hidden draws nothing, and says so.
        assert_eq!((loaded.scene.visible_nodes().len(), loaded.warnings.is_empty()), (count, count > 0));
    }
    assert!(load(json!({ "visible": "no" })).is_err());
}

#[test]
fn lights_of_every_kind_are_read() {
    let read = |light: Value| {
        let mut model = Model::triangle();
        model.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
        model.json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
        let loaded = model.try_load().unwrap();
        assert_eq!(loaded.scene.nodes[0].light, Some(0));
        (loaded.scene.lights[0].clone(), loaded.warnings.len())
    };
    let (sun, _) = read(json!({ "type": "directional", "intensity": 1000, "color": [1, 0.5, 0], "name": "sun" }));
    assert_eq!((sun.kind, sun.intensity, sun.color_linear), (LightKind::Directional, 1000.0, vec3(1.0, 0.5, 0.0)));
    let (point, _) = read(json!({ "type": "point", "range": 5 }));
    assert_eq!((point.kind, point.intensity, point.range_m), (LightKind::Point, 1.0, Some(5.0)));
    let (spot, _) = read(json!({ "type": "spot", "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } }));
    assert_eq!(spot.kind, LightKind::Spot { inner_cone_rad: 0.25, outer_cone_rad: 0.5 });
    let (spot, _) = read(json!({ "type": "spot", "spot": {} }));
    let LightKind::Spot { inner_cone_rad, outer_cone_rad } = spot.kind else { panic!("a spot") };
    assert_eq!((inner_cone_rad, outer_cone_rad), (0.0, std::f32::consts::FRAC_PI_4));
    // Equal angles, which exporters write for a hard edge, and what is negative, are repaired with a warning.
    let (hard, warnings) = read(json!({ "type": "spot", "spot": { "innerConeAngle": 0.5, "outerConeAngle": 0.5 } }));
    assert!(matches!(hard.kind, LightKind::Spot { inner_cone_rad, outer_cone_rad: 0.5 } if inner_cone_rad < 0.5));
    assert_eq!(warnings, 1);
    let (dark, warnings) = read(json!({ "type": "point", "intensity": -1, "color": [-1, 0, 0] }));
    assert_eq!((dark.intensity, dark.color_linear, warnings), (0.0, Vec3::ZERO, 2));
    let (unknown, warnings) = read(json!({ "type": "area" }));
    assert_eq!((unknown.intensity, warnings), (0.0, 1));
}
