//! Images, textures and materials with known answers.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::{Model, push};
use image::{ColorType, DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb, Rgba};
use manypass_scene::{
    AlphaMode, Material, Sampler, ShadingModel, TextureRef, TextureTransform, Wrap, load_bytes, load_path,
};
use manypass_testkit::data_uri;
use serde_json::{Value, json};

/// A 2 by 2 picture of one colour as a file.
fn encoded(color: ColorType, format: ImageFormat) -> Vec<u8> {
    let [r, g, b, a] = [255_u8, 128, 0, 64];
    let wide = |byte: u8| u16::from(byte) * 257;
    let picture: DynamicImage = match color {
        ColorType::L8 => ImageBuffer::from_pixel(2, 2, Luma([g])).into(),
        ColorType::La8 => ImageBuffer::from_pixel(2, 2, LumaA([g, a])).into(),
        ColorType::Rgb8 => ImageBuffer::from_pixel(2, 2, Rgb([r, g, b])).into(),
        ColorType::Rgba8 => ImageBuffer::from_pixel(2, 2, Rgba([r, g, b, a])).into(),
        ColorType::L16 => ImageBuffer::from_pixel(2, 2, Luma([wide(g)])).into(),
        ColorType::La16 => ImageBuffer::from_pixel(2, 2, LumaA([wide(g), wide(a)])).into(),
        ColorType::Rgb16 => ImageBuffer::from_pixel(2, 2, Rgb([r, g, b].map(wide))).into(),
        ColorType::Rgba16 => ImageBuffer::from_pixel(2, 2, Rgba([r, g, b, a].map(wide))).into(),
        other => panic!("no picture of {other:?}"),
    };
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn images_of_every_kind_are_read_from_views_files_and_data_uris() {
    use ColorType::{L8, L16, La8, La16, Rgb8, Rgb16, Rgba8, Rgba16};
    let png = [L8, La8, Rgb8, Rgba8, L16, La16, Rgb16, Rgba16].map(|color| (color, ImageFormat::Png));
    let others =
        [(L8, ImageFormat::Jpeg), (Rgb8, ImageFormat::Jpeg), (Rgb8, ImageFormat::WebP), (Rgba8, ImageFormat::WebP)];
    for (color, format) in png.into_iter().chain(others) {
        let file = encoded(color, format);
        let red_and_blue = if matches!(color, L8 | La8 | L16 | La16) { [128, 128] } else { [255, 0] };
        let alpha = if matches!(color, La8 | Rgba8 | La16 | Rgba16) { 64 } else { 255 };
        let expected = [red_and_blue[0], 128, red_and_blue[1], alpha];
        let mut model = Model::triangle();
        let view = model.view(&file);
        push(&mut model.json["images"], json!({ "bufferView": view, "mimeType": "image/png" }));
        push(&mut model.json["images"], json!({ "uri": data_uri("image/png", &file) }));
        push(&mut model.json["images"], json!({ "uri": "some%20picture.png" }));
        model.json["buffers"][0]["byteLength"] = json!(model.buffer.len());
        let mut resolve = |uri: &str| Ok(if uri == "some picture.png" { file.clone() } else { model.buffer.clone() });
        let loaded = load_bytes(model.json.to_string().as_bytes(), &mut resolve, "model").unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        for image in &loaded.scene.images {
            assert_eq!(image.dimensions().unwrap(), (2, 2));
            let pixels = image.decode().unwrap();
            let near = pixels.data.chunks_exact(4).all(|p| p.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 2));
            // JPEG is lossy; nothing else is.
            assert!(near && pixels.data.len() == 16, "{color:?} {format:?}: {:?}", pixels.data);
            assert!(format == ImageFormat::Jpeg || pixels.data == expected.repeat(4), "{color:?} {format:?}");
        }
    }
}

/// A PNG that says it is of this size, with the bytes of a small one.
fn lying_png(width: u32, height: u32) -> Vec<u8> {
    let mut file = encoded(ColorType::Rgba8, ImageFormat::Png);
    file[16..20].copy_from_slice(&width.to_be_bytes());
    file[20..24].copy_from_slice(&height.to_be_bytes());
    let mut crc = u32::MAX;
    for &byte in &file[12..29] {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
        }
    }
    file[29..33].copy_from_slice(&(!crc).to_be_bytes());
    file
}

#[test]
fn images_that_claim_too_much_are_white_with_a_warning() {
    let load = |files: &[Vec<u8>]| {
        let mut model = Model::triangle();
        model.json["images"] = files.iter().map(|file| json!({ "uri": data_uri("image/png", file) })).collect();
        model.try_load().unwrap()
    };
    for (width, height) in [(1 << 30, 1 << 30), (2_000_000, 1), (1, u32::MAX >> 1), (0, 4)] {
        let loaded = load(&[lying_png(width, height)]);
        assert_eq!(loaded.scene.images[0].dimensions().unwrap(), (1, 1), "{width} {height}");
        assert!(loaded.warnings[0].contains("/images/0"), "{:?}", loaded.warnings);
    }
    // One that is only too large to be drawn is halved.
    let loaded = load(&[lying_png(20_000, 1)]);
    assert_eq!(loaded.scene.images[0].dimensions().unwrap(), (10_000, 1));
    let [warning, ..] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
    assert!(warning.contains("/images/0") && warning.contains("halved to 10000 by 1"), "{warning}");
    // One that fits its limit is only found out when it is decoded.
    assert!(load(&[lying_png(4096, 4096)]).scene.images[0].decode().is_err());
    let loaded = load(&vec![lying_png(8192, 8192); 6]);
    let whites = loaded.scene.images.iter().filter(|image| image.dimensions().unwrap() == (1, 1)).count();
    // Warnings of a kind are one.
    assert_eq!((whites, loaded.warnings.len()), (2, 1), "{:?}", loaded.warnings);
    assert!(
        loaded.warnings[0].contains("(first of 2)") && loaded.warnings[0].contains("1024 MiB"),
        "{:?}",
        loaded.warnings
    );
    for broken in [&b""[..], b"GIF89a", &lying_png(2, 2)[..20]] {
        assert_eq!(load(&[broken.to_vec()]).scene.images[0].decode().unwrap().data, [255; 4]);
    }
}

#[test]
fn materials_do_without_an_image_that_cannot_be_read() {
    // White is no flat normal: the map would tilt every surface by 55°.
    let there = data_uri("image/png", &encoded(ColorType::Rgba8, ImageFormat::Png));
    let mut model = Model::triangle();
    model.json["images"] = json!([{ "uri": "data:image/png;base64,AAAA" }, { "uri": there }]);
    model.json["textures"] =
        json!([{ "source": 0 }, { "source": 1 }, { "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    model.json["materials"] = json!([{
        "normalTexture": { "index": 0 }, "occlusionTexture": { "index": 1 }, "emissiveTexture": { "index": 2 },
    }]);
    let loaded = model.try_load().unwrap();
    let material = &loaded.scene.materials[0];
    assert_eq!((material.normal_texture, material.emissive_texture), (None, None));
    assert!(material.occlusion_texture.is_some());
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    assert!(loaded.warnings[0].contains("materials do without it"), "{:?}", loaded.warnings);
}

#[test]
fn an_image_outside_the_folder_is_not_read() {
    let folder = std::env::temp_dir().join(format!("manypass-image-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("in")).unwrap();
    std::fs::write(folder.join("secret.png"), encoded(ColorType::Rgba8, ImageFormat::Png)).unwrap();
    let json = json!({ "asset": { "version": "2.0" }, "images": [{ "uri": "../secret.png" }] });
    std::fs::write(folder.join("in/model.gltf"), json.to_string()).unwrap();
    let loaded = load_path(&folder.join("in/model.gltf")).unwrap();
    assert_eq!(loaded.scene.images[0].decode().unwrap().data, [255; 4]);
    assert!(loaded.warnings[0].contains("folder"), "{:?}", loaded.warnings);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn samplers_of_every_mode_are_read() {
    let filters = [
        (9728, false, None),
        (9729, true, None),
        (9984, false, Some(false)),
        (9985, true, Some(false)),
        (9986, false, Some(true)),
        (9987, true, Some(true)),
    ];
    let wraps = [(10497, Wrap::Repeat), (33648, Wrap::MirroredRepeat), (33071, Wrap::ClampToEdge)];
    for (number, min_linear, mip_linear) in filters {
        for (i, (wrap_s, wrap_u)) in wraps.into_iter().enumerate() {
            let (wrap_t, wrap_v) = wraps[(i + 1) % 3];
            let mag = 9728 + i % 2;
            let mut model = textured();
            model.json["samplers"] =
                json!([{ "minFilter": number, "magFilter": mag, "wrapS": wrap_s, "wrapT": wrap_t }]);
            model.json["textures"] = json!([{ "source": 0, "sampler": 0 }, { "source": 0 }]);
            let textures = model.load().scene.textures;
            let expected = Sampler { wrap_u, wrap_v, mag_linear: mag == 9729, min_linear, mip_linear };
            assert_eq!((textures[0].sampler, textures[1].sampler), (expected, Sampler::default()));
        }
    }
    for wrong in [json!({ "minFilter": 1 }), json!({ "magFilter": 9984 }), json!({ "wrapS": 33069 })] {
        // A texture is drawn as by a sampler that does not say it.
        let mut model = textured();
        model.json["samplers"] = json!([wrong]);
        model.json["textures"][0]["sampler"] = json!(0);
        let loaded = model.try_load().unwrap();
        assert_eq!(loaded.scene.textures[0].sampler, Sampler::default());
        let [warning] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
        assert!(warning.contains("/samplers/0/") && warning.ends_with("; the default is used"), "{warning}");
    }
}

/// A triangle with an image and a texture.
fn textured() -> Model {
    let mut model = Model::triangle();
    let file = encoded(ColorType::Rgba8, ImageFormat::Png);
    model.json["images"] = json!([{ "uri": data_uri("image/png", &file) }]);
    model.json["textures"] = json!([{ "source": 0 }]);
    model
}

fn material(model: Model) -> Material {
    model.load().scene.materials[0].clone()
}

#[test]
fn every_slot_has_its_texture_uv_set_and_transform() {
    let slot = |i: u32| {
        json!({ "index": 0, "texCoord": i % 2, "extensions": { "KHR_texture_transform":
            { "offset": [i, 0.5], "rotation": f64::from(i) * 0.25, "scale": [2, -(f64::from(i))] } } })
    };
    let mut model = textured();
    model.json["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": slot(0), "metallicRoughnessTexture": slot(1) },
        "normalTexture": slot(2), "occlusionTexture": slot(3), "emissiveTexture": slot(4),
    }]);
    model.json["materials"][0]["normalTexture"]["scale"] = json!(-0.5);
    model.json["materials"][0]["occlusionTexture"]["strength"] = json!(0.25);
    let material = material(model);
    assert_eq!((material.normal_scale, material.occlusion_strength), (-0.5, 0.25));
    let slots = [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.occlusion_texture,
        material.emissive_texture,
    ];
    for (i, slot) in slots.into_iter().enumerate() {
        let number = i as f32;
        let offset = glam::vec2(number, 0.5);
        let transform = TextureTransform { offset, rotation_rad: number * 0.25, scale: glam::vec2(2.0, -number) };
        assert_eq!(slot, Some(TextureRef { texture: 0, uv_set: i as u32 % 2, transform }), "slot {i}");
    }
}

#[test]
fn the_uv_set_of_a_transform_wins() {
    let mut model = textured();
    model.json["materials"] = json!([{ "emissiveTexture": { "index": 0, "texCoord": 0,
        "extensions": { "KHR_texture_transform": { "texCoord": 1 } } } }]);
    let texture = material(model).emissive_texture.unwrap();
    assert_eq!((texture.uv_set, texture.transform), (1, TextureTransform::default()));
}

#[test]
fn materials_say_what_they_are() {
    let read = |json: Value| {
        let mut model = Model::triangle();
        model.json["materials"] = json!([json]);
        material(model)
    };
    let defaults = Material::default();
    assert_eq!(read(json!({})), defaults);
    assert_eq!((defaults.metallic_factor, defaults.roughness_factor), (1.0, 1.0));
    assert_eq!(read(json!({ "alphaMode": "MASK" })).alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    let masked = read(json!({ "alphaMode": "MASK", "alphaCutoff": 0.75, "doubleSided": true }));
    assert_eq!((masked.alpha_mode, masked.double_sided), (AlphaMode::Mask { cutoff: 0.75 }, true));
    assert_eq!(read(json!({ "alphaMode": "BLEND" })).alpha_mode, AlphaMode::Blend);
    let unlit = read(json!({ "extensions": { "KHR_materials_unlit": {} } }));
    assert_eq!(unlit.shading_model, ShadingModel::Unlit);
    let glowing = read(json!({ "emissiveFactor": [0.5, 1, 0],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 4 } } }));
    assert_eq!(glowing.emissive_factor.to_array(), [2.0, 4.0, 0.0]);
    let metal = read(json!({ "pbrMetallicRoughness":
        { "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0, "roughnessFactor": 0.25 } }));
    assert_eq!(metal.base_color_factor.to_array(), [0.1, 0.2, 0.3, 0.4]);
    assert_eq!((metal.metallic_factor, metal.roughness_factor), (0.0, 0.25));
}

#[test]
fn factors_out_of_range_are_clamped_with_a_warning() {
    let mut model = Model::triangle();
    model.json["materials"] = json!([{ "emissiveFactor": [-1, 2, 0], "alphaCutoff": -1, "pbrMetallicRoughness":
        { "baseColorFactor": [-5, 1e30, 0.5, 9], "metallicFactor": 1.0000001, "roughnessFactor": -0.5 } }]);
    let loaded = model.try_load().unwrap();
    let material = &loaded.scene.materials[0];
    assert_eq!(material.base_color_factor.to_array(), [0.0, 1.0, 0.5, 1.0]);
    assert_eq!((material.metallic_factor, material.roughness_factor), (1.0, 0.0));
    assert_eq!(material.emissive_factor.to_array(), [0.0, 2.0, 0.0]);
    assert_eq!(loaded.warnings.len(), 5, "{:?}", loaded.warnings);
    assert!(loaded.warnings[0].contains("/materials/0/pbrMetallicRoughness/baseColorFactor"), "{:?}", loaded.warnings);
}

#[test]
fn webp_is_taken_before_its_fallback() {
    let mut model = textured();
    let file = encoded(ColorType::Rgb8, ImageFormat::WebP);
    model.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    push(&mut model.json["images"], json!({ "uri": data_uri("image/webp", &file) }));
    model.json["textures"] = json!([{ "source": 0, "extensions": { "EXT_texture_webp": { "source": 1 } } }]);
    assert_eq!(model.load().scene.textures[0].image, 1);
}
