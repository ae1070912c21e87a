//! Files of extensions that say the same in another way, beside files that say it plainly: their pictures are the same.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common;
use crate::common::files::{File, assert_twins};
use image::codecs::{png::PngEncoder, webp::WebPEncoder};
use image::{ExtendedColorType, ImageEncoder};
use manypass_scene::{Image, ImageSource, Scene};
use manypass_testkit::compare::{Picture, flip};
use manypass_testkit::ktx2;
use manypass_testkit::needs::assets;
use serde_json::json;
use std::path::Path;

fn scene(folder: &Path, file: &str) -> Scene {
    File::read(&folder.join(file)).scene()
}

/// The pictures look different.
#[track_caller]
fn assert_unlike(first: &Picture, second: &Picture) {
    let mean = flip(first, second).mean();
    assert!(mean > 0.02, "the mean FLIP is {mean}");
}

#[test]
fn compressed_meshes_look_as_their_uncompressed_twins() {
    let Some(folder) = assets("") else { return };
    let sample = |name: &str, kind: &str| {
        let suffix = if kind == "glTF-Binary" { "glb" } else { "gltf" };
        format!("khronos-sample-assets/Models/{name}/{kind}/{name}.{suffix}")
    };
    // Positions are rounded to 11 or 14 bits, normals to 8 or 10.
    for (packed, plain, most) in [
        (sample("Box", "glTF-Draco"), sample("Box", "glTF"), 0.0005),
        (sample("Duck", "glTF-Draco"), sample("Duck", "glTF-Binary"), 0.008),
        (sample("CesiumMan", "glTF-Draco"), sample("CesiumMan", "glTF-Binary"), 0.008),
        (sample("MorphPrimitivesTest", "glTF-Draco"), sample("MorphPrimitivesTest", "glTF-Binary"), 0.008),
        (sample("Duck", "glTF-Quantized"), sample("Duck", "glTF-Binary"), 0.006),
        ("loaders.gl/BoxTextured_meshopt.glb".into(), sample("BoxTextured", "glTF-Binary"), 0.004),
    ] {
        assert_twins(&packed, [&scene(&folder, &packed), &scene(&folder, &plain)], most);
    }
}

/// A square of a metre that shows an image alone, which an extension names, or none.
fn square(image: &[u8], mime: &str, extension: Option<&str>) -> Scene {
    let mut buffer = Vec::new();
    for values in [
        &[-0.5_f32, -0.5, 0.0, 0.5, -0.5, 0.0, 0.5, 0.5, 0.0, -0.5, 0.5, 0.0][..],
        &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
    ] {
        buffer.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    }
    buffer.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    buffer.extend(image);
    let view = |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let source = json!({ "source": 0 });
    let json = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "extensionsUsed": ["KHR_materials_unlit", "KHR_texture_basisu", "EXT_texture_webp"],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2, "material": 0,
        }] }],
        "materials": [{
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
            "extensions": { "KHR_materials_unlit": {} },
        }],
        "images": [{ "bufferView": 3, "mimeType": mime }],
        "textures": [extension.map_or(source.clone(), |extension| json!({ "extensions": { extension: source } }))],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4,
              "min": [-0.5, -0.5, 0.0], "max": [0.5, 0.5, 0.0] },
            { "bufferView": 1, "componentType": 5126, "type": "VEC2", "count": 4 },
            { "bufferView": 2, "componentType": 5123, "type": "SCALAR", "count": 6 },
        ],
        "bufferViews": [view(0, 48), view(48, 32), view(80, 12), view(92, image.len())],
        "buffers": [{ "uri": "", "byteLength": buffer.len() }],
    });
    File::new(json, buffer).scene()
}

/// Its texels as PNG.
fn plain(texels: &[u8], [width, height]: [u32; 2]) -> Scene {
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(texels, width, height, ExtendedColorType::Rgba8).unwrap();
    square(&png, "image/png", None)
}

fn basis(container: &[u8]) -> Scene {
    square(container, "image/ktx2", Some("KHR_texture_basisu"))
}

#[test]
fn compressed_images_look_as_their_uncompressed_twins() {
    // Blocks of one colour, which need no reader to know.
    let color = |x: u32, y: u32| [(x * 16) as u8, (y * 16) as u8, ((x ^ y) * 8) as u8 + 64, 255];
    let blocks: Vec<u8> = (0..256).flat_map(|i| ktx2::solid_block(color(i % 16, i / 16))).collect();
    let texels: Vec<u8> = (0..64 * 64).flat_map(|i| color(i % 64 / 4, i / 64 / 4)).collect();
    let twin = plain(&texels, [64, 64]);
    assert_twins("UASTC, by hand", [&basis(&ktx2::picture(0, [64, 64], 0, &[&blocks])), &twin], 0.0005);
    let mut webp = Vec::new();
    WebPEncoder::new_lossless(&mut webp).encode(&texels, 64, 64, ExtendedColorType::Rgba8).unwrap();
    assert_twins("WebP", [&square(&webp, "image/webp", Some("EXT_texture_webp")), &twin], 0.0);
    // Files of other programs, of which the GPU gets blocks where it takes them, beside their texels as PNG. What the
    // texels are is judged in `crates/scene/tests/ktx2.rs`.
    let Some(folder) = assets("threejs/ktx2") else { return };
    for file in ["2d_rgba8.ktx2", "2d_etc1s.ktx2", "2d_uastc.ktx2"] {
        let bytes = std::fs::read(folder.join(file)).unwrap();
        let image = Image { name: file.into(), source: ImageSource::Encoded(bytes.clone().into()) };
        let decoded = image.decode().unwrap();
        let twin = plain(&decoded.data, [decoded.width, decoded.height]);
        assert_twins(file, [&basis(&bytes), &twin], 0.01);
    }
}

#[test]
fn instances_look_as_nodes_of_their_own() {
    let Some(folder) = assets("khronos-sample-assets/Models/SimpleInstancing/glTF-Binary") else { return };
    let instanced = File::read(&folder.join("SimpleInstancing.glb"));
    let mut plain = instanced.clone();
    let node = &mut plain.json["nodes"][0];
    let attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"].clone();
    let accessor = |name: &str| attributes[name].as_u64().unwrap() as usize;
    let places = instanced.floats::<3>(accessor("TRANSLATION"));
    let turns = instanced.floats::<4>(accessor("ROTATION"));
    let sizes = instanced.floats::<3>(accessor("SCALE"));
    let written = |i: usize| json!({ "mesh": 0, "translation": places[i], "rotation": turns[i], "scale": sizes[i] });
    plain.json["nodes"] = (0..places.len()).map(written).collect();
    plain.json["scenes"][0]["nodes"] = (0..places.len()).collect();
    plain.json["extensionsUsed"] = json!([]);
    plain.json["extensionsRequired"] = json!([]);
    let picture = assert_twins("instancing", [&instanced.scene(), &plain.scene()], 0.0);
    // It is seen where instances are missing.
    plain.json["scenes"][0]["nodes"] = (0..places.len() / 2).collect();
    let half = plain.scene();
    let mut renderer = common::renderer();
    let view = common::framed(&instanced.scene().posed_bounds_world());
    assert_unlike(&picture, &common::files::picture(&mut renderer, &half, view));
}

#[test]
fn hidden_nodes_look_as_if_they_were_not_there() {
    let Some(folder) = assets("luma") else { return };
    let file = File::read(&folder.join("CubeVisibility.glb"));
    // The first cube and those below it are hidden, the last one blinks: `KHR_animation_pointer` moves a truth value.
    let keys: Vec<f32> = file.floats::<1>(3).into_iter().flatten().collect();
    let view = &file.json["bufferViews"][4];
    let from = view["byteOffset"].as_u64().unwrap() as usize
        + file.json["accessors"][4]["byteOffset"].as_u64().unwrap_or(0) as usize;
    let shown = &file.buffer[from..from + keys.len()];
    let mut scenes = Vec::new();
    for is_shown in [1, 0] {
        let key = shown[..keys.len() - 1].iter().position(|value| *value == is_shown).unwrap();
        let mut posed = file.scene();
        posed.pose(0, 0.5 * (keys[key] + keys[key + 1]));
        posed.update_transforms();
        let mut plain = file.clone();
        plain.json["nodes"][0]["children"] = if is_shown == 1 { json!([4, 5]) } else { json!([4]) };
        for node in plain.json["nodes"].as_array_mut().unwrap() {
            node.as_object_mut().unwrap().remove("extensions");
        }
        for name in ["animations", "extensionsUsed", "extensionsRequired"] {
            plain.json.as_object_mut().unwrap().remove(name);
        }
        let name = format!("visibility, the last is {}", if is_shown == 1 { "shown" } else { "hidden" });
        assert_twins(&name, [&posed, &plain.scene()], 0.0);
        scenes.push(posed);
    }
    let mut renderer = common::renderer();
    let view = common::framed(&scenes[0].posed_bounds_world());
    let [shown, hidden] = [&scenes[0], &scenes[1]].map(|scene| common::files::picture(&mut renderer, scene, view));
    assert_unlike(&shown, &hidden);
}

#[test]
fn pointers_look_as_the_values_that_they_animate() {
    let Some(folder) = assets("") else { return };
    // Channels of nodes, as pointers.
    let plain = File::read(&folder.join("khronos-sample-assets/Models/BoxAnimated/glTF-Binary/BoxAnimated.glb"));
    let mut pointed = plain.clone();
    for channel in pointed.json["animations"][0]["channels"].as_array_mut().unwrap() {
        let target = &mut channel["target"];
        let pointer = format!("/nodes/{}/{}", target["node"], target["path"].as_str().unwrap());
        *target = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } });
    }
    pointed.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    let at = |file: &File, seconds: f32| {
        let mut scene = file.scene();
        scene.pose(0, seconds);
        scene.update_transforms();
        scene
    };
    let pictures: Vec<Picture> = [0.0, 1.6, 2.6]
        .map(|seconds| {
            let name = format!("BoxAnimated at {seconds} s");
            assert_twins(&name, [&at(&pointed, seconds), &at(&plain, seconds)], 0.0)
        })
        .to_vec();
    assert_unlike(&pictures[0], &pictures[1]);
    // The colour of a material, between two keys.
    let pointed = File::read(&folder.join("luma/AnimatedColorsCube.glb"));
    let keys: Vec<f32> = pointed.floats::<1>(12).into_iter().flatten().collect();
    let colors = pointed.floats::<4>(13);
    let key = colors.windows(2).position(|pair| pair[0] != pair[1]).unwrap();
    let mut plain = pointed.clone();
    plain.json["animations"][0]["channels"].as_array_mut().unwrap().remove(2);
    plain.json["extensionsUsed"] = json!([]);
    let middle: Vec<f32> = colors[key].iter().zip(colors[key + 1]).map(|(a, b)| a + 0.25 * (b - a)).collect();
    plain.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!(middle);
    let seconds = keys[key] + 0.25 * (keys[key + 1] - keys[key]);
    let (pointed, plain) = (at(&pointed, seconds), at(&plain, seconds));
    assert_twins("AnimatedColorsCube", [&pointed, &plain], 0.0005);
    assert!(pointed.materials[0].base_color_factor != pointed.materials[1].base_color_factor);
}
