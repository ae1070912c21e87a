//! What the picture does not need is never a reason to refuse a glTF file: a default is taken, and one warning counts it.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::{F32, Model, U16, floats, integers, push};
use manypass_scene::{AlphaMode, Interpolation, Keyframes, Projection, Sampler, load_bytes};
use serde_json::{Value, json};

/// A triangle with a material that has a texture, an animation of one channel, and a camera.
fn model() -> Model {
    let mut model = Model::triangle();
    let times = model.accessor(F32, "SCALAR", &floats(&[0.0, 1.0, 2.0]));
    let values = model.accessor(F32, "VEC3", &floats(&[0.0; 9]));
    model.json["animations"] = json!([{
        "samplers": [{ "input": times, "output": values }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
    }]);
    let png = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image::RgbImage::new(1, 1).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let view = model.view(&png);
    model.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    model.json["samplers"] = json!([{}]);
    model.json["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    model.json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    model.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }]);
    model.json["skins"] = json!([]);
    model.primitive()["material"] = json!(0);
    let uvs = floats(&[0.0; 6]);
    model.attribute("TEXCOORD_0", F32, "VEC2", &uvs);
    model
}

/// What is broken in a model.
type Change = fn(&mut Value);

/// A model with a change, and what is said of it.
fn changed(change: impl FnOnce(&mut Value)) -> manypass_scene::LoadedScene {
    let mut model = model();
    change(&mut model.json);
    model.try_load().unwrap()
}

#[test]
fn what_is_broken_and_not_needed_is_drawn_without() {
    let cases: [(&str, Change); 26] = [
        ("at \"/samplers/0/wrapS\": expected 33071, 33648, 10497, found 10242", |json| {
            json["samplers"][0]["wrapS"] = json!(10242)
        }),
        ("/samplers/0/minFilter\": expected 9728", |json| json["samplers"][0]["minFilter"] = json!("sharp")),
        ("/samplers/0/magFilter", |json| json["samplers"][0]["magFilter"] = json!(1)),
        ("/textures/0/sampler\": refers to sampler 9", |json| json["textures"][0]["sampler"] = json!(9)),
        ("/textures/1/source\": refers to image 7", |json| {
            let _ = push(&mut json["textures"], json!({ "source": 7 }));
        }),
        ("interpolation\": expected STEP, LINEAR or CUBICSPLINE, found ROUND", |json| {
            json["animations"][0]["samplers"][0]["interpolation"] = json!("ROUND");
        }),
        ("/channels/0/sampler\": refers to sampler 3", |json| {
            json["animations"][0]["channels"][0]["sampler"] = json!(3)
        }),
        ("/channels/0/target/node\": refers to node 8", |json| {
            json["animations"][0]["channels"][0]["target"]["node"] = json!(8);
        }),
        ("/materials/0/alphaMode\": expected OPAQUE, MASK or BLEND, found DITHER", |json| {
            json["materials"][0]["alphaMode"] = json!("DITHER");
        }),
        ("/nodes/0/name\": expected a string", |json| json["nodes"][0]["name"] = json!(5)),
        ("/meshes/0/name\": expected a string", |json| json["meshes"][0]["name"] = json!([])),
        ("/cameras/0/perspective/yfov\": expected a number above 0; a perspective lens", |json| {
            json["cameras"][0]["perspective"]["yfov"] = json!(0);
        }),
        ("/cameras/0/type", |json| json["cameras"][0]["type"] = json!("fisheye")),
        ("/nodes/0/camera\": refers to camera 4", |json| json["nodes"][0]["camera"] = json!(4)),
        ("/accessors/4/count", |json| {
            {
                let _ = push(
                    &mut json["accessors"],
                    json!({ "componentType": 5126, "type": "VEC3", "bufferView": 0, "count": 99 }),
                );
            };
        }),
        ("/accessors/4/componentType", |json| {
            {
                let _ = push(&mut json["accessors"], json!({ "componentType": 1, "type": "VEC3", "count": 9 }));
            };
        }),
        ("/bufferViews/5/byteLength", |json| {
            let _ = push(&mut json["bufferViews"], json!({ "buffer": 0, "byteLength": 99999 }));
        }),
        ("/bufferViews/5/buffer", |json| {
            let _ = push(&mut json["bufferViews"], json!({ "buffer": 3, "byteLength": 1 }));
        }),
        ("/buffers/1/byteLength", |json| {
            let _ = push(&mut json["buffers"], json!({ "uri": "b.bin", "byteLength": 99999 }));
        }),
        ("/meshes/1/primitives/0/indices\": refers to accessor 90", |json| {
            {
                let _ = push(
                    &mut json["meshes"],
                    json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 90 }] }),
                );
            };
        }),
        ("/materials/1/normalTexture/index\": refers to texture 5", |json| {
            {
                let _ = push(&mut json["materials"], json!({ "normalTexture": { "index": 5 } }));
            };
        }),
        ("/nodes/1/mesh\": refers to mesh 5", |json| {
            let _ = push(&mut json["nodes"], json!({ "mesh": 5 }));
        }),
        ("/nodes/1/rotation", |json| {
            let _ = push(&mut json["nodes"], json!({ "rotation": [0, 0, 0, 9] }));
        }),
        ("/skins/0/joints", |json| {
            let _ = push(&mut json["skins"], json!({ "joints": [70] }));
        }),
        ("/skins/0/joints\": expected at least 1 joint", |json| {
            let _ = push(&mut json["skins"], json!({ "joints": [] }));
        }),
        ("KHR_lights_punctual/lights/0/range", |json| {
            json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "range": 0 }] } });
        }),
    ];
    assert_eq!(model().try_load().unwrap().warnings, [""; 0]);
    for (said, change) in cases {
        let loaded = changed(change);
        assert!(loaded.warnings.len() == 1 && loaded.warnings[0].contains(said), "{said}: {:?}", loaded.warnings);
        assert_eq!(loaded.scene.drawn_primitives(), 1, "{said}");
    }
}

#[test]
fn broken_animations_and_levels_change_nothing() {
    for (said, change) in [
        (
            "/animations/0/samplers\": expected an array; the animation moves nothing",
            (|json: &mut Value| json["animations"][0]["samplers"] = json!(3)) as Change,
        ),
        ("/animations/0/channels\": expected an array; the animation moves nothing", |json| {
            json["animations"][0]["channels"] = json!({});
        }),
        ("/animations/0/channels/0/target\": expected an object", |json| {
            json["animations"][0]["channels"][0]["target"] = json!("node");
        }),
        ("/nodes/0/extensions/MSFT_lod\": expected an object; there are no coarser levels", |json| {
            json["nodes"][0]["extensions"] = json!({ "MSFT_lod": 1 });
        }),
        ("/materials/0/extensions/MSFT_lod/ids\": expected indices of material below 1", |json| {
            json["materials"][0]["extensions"] = json!({ "MSFT_lod": { "ids": [3] } });
        }),
    ] {
        let loaded = changed(change);
        assert!(loaded.warnings.len() == 1 && loaded.warnings[0].contains(said), "{said}: {:?}", loaded.warnings);
        assert_eq!(loaded.scene.drawn_primitives(), 1, "{said}");
        assert_eq!(loaded.scene.animations.len(), 1, "{said}");
    }
}

#[test]
fn the_default_is_what_the_specification_has() {
    let loaded = changed(|json| {
        json["samplers"][0] = json!({ "wrapS": 10242, "wrapT": 1, "minFilter": 2, "magFilter": 3 });
        json["animations"][0]["samplers"][0]["interpolation"] = json!("ROUND");
        json["materials"][0]["alphaMode"] = json!("DITHER");
        json["cameras"][0]["perspective"]["yfov"] = json!(0);
    });
    assert_eq!(loaded.scene.textures[0].sampler, Sampler::default());
    assert_eq!(loaded.scene.animations[0].channels[0].interpolation, Interpolation::Linear);
    assert_eq!(loaded.scene.materials[0].alpha_mode, AlphaMode::Opaque);
    assert!(matches!(loaded.scene.cameras[0].projection, Projection::Perspective { fov_y_rad, .. } if fov_y_rad > 0.5));
    assert_eq!(loaded.warnings.len(), 7, "{:?}", loaded.warnings);
}

#[test]
fn what_is_shown_and_broken_is_refused() {
    for (place, change) in [
        ("/nodes/0/mesh", (|json: &mut Value| json["nodes"][0]["mesh"] = json!(5)) as Change),
        ("/nodes/0/rotation", |json| json["nodes"][0]["rotation"] = json!([0, 0, 0, 9])),
        ("/materials/0/normalTexture/index", |json| json["materials"][0]["normalTexture"] = json!({ "index": 5 })),
        ("/meshes/0/primitives/0/mode", |json| json["meshes"][0]["primitives"][0]["mode"] = json!(9)),
        ("/accessors/0/count", |json| json["accessors"][0]["count"] = json!(99)),
        ("/bufferViews/0/byteLength", |json| json["bufferViews"][0]["byteLength"] = json!(99999)),
        // A joint that is in no scene moves what is shown.
        ("/nodes/1/rotation", |json| {
            let _ = push(&mut json["nodes"], json!({ "rotation": [0, 0, 0, 9] }));
            json["skins"] = json!([{ "joints": [1] }]);
            json["nodes"][0]["skin"] = json!(0);
        }),
    ] {
        let mut model = model();
        change(&mut model.json);
        let error = model.try_load().unwrap_err().to_string();
        assert!(error.contains(place), "{place}: {error}");
    }
}

#[test]
fn keyframes_without_values_are_left_out() {
    let mut model = model();
    let values = model.accessor(F32, "VEC3", &floats(&[1.0; 6]));
    model.json["animations"][0]["samplers"][0]["output"] = json!(values);
    let loaded = model.try_load().unwrap();
    let channel = &loaded.scene.animations[0].channels[0];
    assert_eq!(channel.times_secs, [0.0, 1.0]);
    assert!(matches!(&channel.keyframes, Keyframes::Translation(values) if values.len() == 2));
    assert!(loaded.warnings[0].contains("3 keyframes have 2 values; the first 2 are used"), "{:?}", loaded.warnings);
}

#[test]
fn warnings_of_a_kind_are_one_with_their_count() {
    let loaded = changed(|json| json["samplers"] = json!([{ "wrapS": 1 }, { "wrapS": 2 }, { "wrapS": 3 }]));
    assert_eq!(loaded.warnings.len(), 1);
    assert!(loaded.warnings[0].starts_with("at \"/samplers/0/wrapS\" (first of 3): "), "{:?}", loaded.warnings);
}

#[test]
fn textures_may_be_on_any_two_uv_sets() {
    for (sets, expected) in [([0, 2], [0, 1]), ([2, 3], [0, 1]), ([3, 1], [0, 1]), ([5, 5], [0, 0])] {
        let mut model = model();
        for set in 1..6 {
            let name = format!("TEXCOORD_{set}");
            if sets.contains(&set) {
                model.attribute(&name, F32, "VEC2", &floats(&[set as f32; 6]));
            }
        }
        model.json["materials"][0] = json!({
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": sets[0] } },
            "emissiveTexture": { "index": 0, "texCoord": sets[1] },
        });
        let loaded = model.try_load().unwrap();
        assert_eq!(loaded.warnings, [""; 0], "{sets:?}");
        let (material, primitive) = (&loaded.scene.materials[0], &loaded.scene.meshes[0].primitives[0]);
        let slots = [material.base_color_texture.unwrap().uv_set, material.emissive_texture.unwrap().uv_set];
        assert_eq!(slots, expected, "{sets:?}");
        for (slot, set) in slots.into_iter().zip(sets) {
            let uvs = if slot == 0 { &primitive.uv0 } else { &primitive.uv1 };
            assert_eq!(uvs[0], [set as f32; 2], "{sets:?}");
        }
    }
}

#[test]
fn a_third_uv_set_of_a_material_is_warned_of() {
    let mut model = model();
    for set in [3, 4] {
        model.attribute(&format!("TEXCOORD_{set}"), F32, "VEC2", &floats(&[set as f32; 6]));
    }
    model.json["materials"][0] = json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 0 } },
        "emissiveTexture": { "index": 0, "texCoord": 3 },
        "occlusionTexture": { "index": 0, "texCoord": 4 },
    });
    let loaded = model.try_load().unwrap();
    let said = "at \"/materials/0/occlusionTexture/texCoord\": a material has two UV sets, here 0 and 3; set 0 is used";
    assert_eq!(loaded.warnings.iter().filter(|warning| *warning == said).count(), 1, "{:?}", loaded.warnings);
    let material = &loaded.scene.materials[0];
    let slots = [material.base_color_texture, material.emissive_texture, material.occlusion_texture];
    assert_eq!(slots.map(|texture| texture.unwrap().uv_set), [0, 1, 0]);
    assert_eq!(loaded.scene.meshes[0].primitives[0].uv1[0], [3.0; 2]);
}

#[test]
fn joints_in_no_scene_keep_their_translation() {
    let mut model = Model::triangle();
    let joints = integers(U16, &[0; 12]);
    model.attribute("JOINTS_0", U16, "VEC4", &joints);
    model.attribute("WEIGHTS_0", F32, "VEC4", &floats(&[1.0, 0.0, 0.0, 0.0].repeat(3)));
    model.json["nodes"] =
        json!([{ "mesh": 0, "skin": 0 }, { "translation": [0, 2, 0] }, { "children": [1], "translation": [5, 0, 0] }]);
    model.json["skins"] = json!([{ "joints": [1] }]);
    let loaded = model.try_load().unwrap();
    let matrices = loaded.scene.joint_matrices(0);
    assert_eq!(matrices[0].w_axis.truncate().to_array(), [5.0, 2.0, 0.0]);
    assert_eq!(loaded.scene.drawn_primitives(), 1);
}

#[test]
fn materials_behind_the_last_that_is_used_cost_nothing() {
    let mut model = Model::triangle();
    model.json["materials"] = Value::Array(vec![json!({}); 20_000]);
    model.primitive()["material"] = json!(4999);
    let loaded = model.try_load().unwrap();
    assert_eq!(loaded.scene.materials.len(), 5000);
    assert!(loaded.warnings[0].contains("15000 materials at the end are used by nothing"), "{:?}", loaded.warnings);
}

#[test]
fn images_above_the_limit_are_halved() {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let texel = |x: u32, _: u32| image::Rgb(if x < 8192 { [255_u8, 0, 0] } else { [0, 255, 0] });
    image::RgbImage::from_fn(16_385, 2, texel).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let json = json!({ "asset": { "version": "2.0" }, "images": [{ "uri": "wide.png" }] });
    let mut resolve = |_: &str| Ok(bytes.get_ref().clone());
    let loaded = load_bytes(json.to_string().as_bytes(), &mut resolve, "a.gltf").unwrap();
    let said = "at \"/images/0\": it has 16385 by 2 texels, and 16384 a side are possible; it is halved to 8192 by 1";
    assert!(loaded.warnings.contains(&said.to_owned()), "{:?}", loaded.warnings);
    let pixels = loaded.scene.images[0].decode().unwrap();
    assert_eq!((pixels.width, pixels.height, pixels.data.len()), (8192, 1, 4 * 8192));
    assert_eq!((&pixels.data[..4], &pixels.data[4 * 8191..]), (&[255, 0, 0, 255][..], &[0, 255, 0, 255][..]));
    assert_eq!(loaded.scene.images[0].dimensions().unwrap(), (8192, 1));
}

/// Each node that a scene lists is drawn once, whatever stands above it.
#[test]
fn a_scene_may_list_nodes_that_have_parents() {
    let drawn = |nodes: Value| {
        let loaded = changed(|json| {
            let mesh = json["nodes"][0].clone();
            json["animations"] = json!([]);
            json["nodes"] = json!([{ "children": [1], "translation": [5, 0, 0] }, mesh]);
            json["scenes"] = json!([{ "nodes": nodes }]);
        });
        let scene = &loaded.scene;
        let shown: Vec<_> = scene.visible_nodes().into_iter().filter(|id| scene.node(*id).mesh.is_some()).collect();
        assert_eq!(shown.len(), 1);
        (scene.node(shown[0]).world_from_object.w_axis.x, loaded.warnings.concat())
    };
    assert_eq!(drawn(json!([0])), (5.0, String::new()));
    let (x, warning) = drawn(json!([1]));
    assert!(x == 0.0 && warning.contains("others are shown without theirs"), "{x} {warning}");
    for twice in [json!([0, 1]), json!([1, 0]), json!([0, 0])] {
        let (x, warning) = drawn(twice);
        assert!(x == 5.0 && warning.contains("others are there once"), "{x} {warning}");
    }
}
