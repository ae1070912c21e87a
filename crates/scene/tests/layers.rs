//! The extensions of materials as they are read.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use glam::Vec3;
use manypass_scene::gltf_file::load_bytes;
use manypass_scene::material::LightEncoding;
use manypass_scene::{LayerMap, Material};
use serde_json::{Value, json};

fn read(material: Value) -> (Material, Vec<String>) {
    // One white texel.
    let image = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAG7buVgAAAABJRU5ErkJggg==";
    let file = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [] }],
        "materials": [material],
        "textures": [{ "source": 0 }, { "source": 0 }],
        "images": [{ "uri": image }],
    });
    let loaded = load_bytes(file.to_string().as_bytes(), &mut |_| Err("none".into()), "a.gltf").unwrap();
    (loaded.scene.materials[0].clone(), loaded.warnings)
}

fn extension(name: &str, value: Value) -> Value {
    json!({ "extensions": { name: value } })
}

#[test]
fn every_layer_is_read_with_its_maps() {
    let map = |index: u32| json!({ "index": index, "texCoord": 1 });
    let (material, _) = read(json!({ "extensions": {
        "KHR_materials_ior": { "ior": 1.33 },
        "KHR_materials_specular": {
            "specularFactor": 0.5, "specularTexture": map(0),
            "specularColorFactor": [1, 2, 3], "specularColorTexture": map(1),
        },
        "KHR_materials_clearcoat": {
            "clearcoatFactor": 0.7, "clearcoatTexture": map(0), "clearcoatRoughnessFactor": 0.2,
            "clearcoatRoughnessTexture": map(1), "clearcoatNormalTexture": { "index": 0, "scale": 0.5 },
        },
        "KHR_materials_sheen": {
            "sheenColorFactor": [0.1, 0.2, 0.3], "sheenColorTexture": map(0),
            "sheenRoughnessFactor": 0.4, "sheenRoughnessTexture": map(0),
        },
        "KHR_materials_anisotropy": { "anisotropyStrength": 0.6, "anisotropyRotation": 1.5, "anisotropyTexture": map(1) },
        "KHR_materials_iridescence": {
            "iridescenceFactor": 1, "iridescenceTexture": map(0), "iridescenceIor": 1.8,
            "iridescenceThicknessMinimum": 50, "iridescenceThicknessMaximum": 500, "iridescenceThicknessTexture": map(1),
        },
        "KHR_materials_transmission": { "transmissionFactor": 0.9, "transmissionTexture": map(0) },
        "KHR_materials_volume": {
            "thicknessFactor": 2, "thicknessTexture": map(1), "attenuationDistance": 3, "attenuationColor": [1, 0.5, 0],
        },
        "KHR_materials_dispersion": { "dispersion": 0.3 },
        "KHR_materials_diffuse_transmission": {
            "diffuseTransmissionFactor": 0.25, "diffuseTransmissionTexture": map(0),
            "diffuseTransmissionColorFactor": [0, 1, 0], "diffuseTransmissionColorTexture": map(1),
        },
    } }));
    // No extension has these.
    let of_stages = [LayerMap::Height, LayerMap::DetailNormal, LayerMap::DetailColor];
    let is_there = |map: LayerMap| material.layer_texture(map).is_some();
    assert!(LayerMap::ALL.into_iter().all(|map| is_there(map) != of_stages.contains(&map)));
    let specular = material.specular.unwrap();
    assert_eq!((material.ior, specular.weight.factor, specular.color.factor), (1.33, 0.5, Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!(specular.color.texture.map(|map| (map.texture, map.uv_set)), Some((1, 1)));
    let coat = material.clearcoat.unwrap();
    assert_eq!((coat.weight.factor, coat.roughness.factor, coat.normal_scale), (0.7, 0.2, 0.5));
    let sheen = material.sheen.unwrap();
    assert_eq!((sheen.color.factor, sheen.roughness.factor), (Vec3::new(0.1, 0.2, 0.3), 0.4));
    let anisotropy = material.anisotropy.unwrap();
    assert_eq!((anisotropy.strength, anisotropy.rotation_rad), (0.6, 1.5));
    let film = material.iridescence.unwrap();
    assert_eq!((film.ior, film.thickness_min_nm, film.thickness_max_nm), (1.8, 50.0, 500.0));
    let volume = material.volume.unwrap();
    assert_eq!((volume.thickness.factor, volume.attenuation_distance_m), (2.0, 3.0));
    assert_eq!(volume.attenuation_color, Vec3::new(1.0, 0.5, 0.0));
    let scattered = material.diffuse_transmission.unwrap();
    assert_eq!((scattered.weight.factor, scattered.color.factor), (0.25, Vec3::Y));
    assert_eq!((material.transmission.unwrap().factor, material.dispersion), (0.9, 0.3));
}

#[test]
fn layers_without_weight_are_none_and_wrong_numbers_are_said() {
    for (name, value) in [
        ("KHR_materials_clearcoat", json!({ "clearcoatRoughnessFactor": 0.5 })),
        ("KHR_materials_sheen", json!({ "sheenRoughnessFactor": 0.5 })),
        ("KHR_materials_anisotropy", json!({})),
        ("KHR_materials_iridescence", json!({})),
        ("KHR_materials_transmission", json!({})),
        ("KHR_materials_volume", json!({ "attenuationDistance": 1 })),
        ("KHR_materials_diffuse_transmission", json!({})),
    ] {
        assert_eq!(read(extension(name, value)).0, Material::default(), "{name}");
    }
    let warned = |name: &str, value: Value| {
        let (material, warnings) = read(extension(name, value));
        assert_eq!(warnings.iter().filter(|warning| warning.contains(name)).count(), 1, "{name}: {warnings:?}");
        material
    };
    assert_eq!(warned("KHR_materials_ior", json!({ "ior": 0.5 })).ior, 1.0);
    let coat = warned("KHR_materials_clearcoat", json!({ "clearcoatFactor": 7 })).clearcoat.unwrap();
    assert_eq!(coat.weight.factor, 1.0);
    let volume = json!({ "thicknessFactor": 1, "attenuationDistance": -1 });
    assert_eq!(warned("KHR_materials_volume", volume).volume.unwrap().attenuation_distance_m, f32::INFINITY);
}

#[test]
fn light_maps_lie_on_the_second_uv_set_unless_they_say_another() {
    let name = "MOZ_lightmap";
    let (material, warnings) = read(extension(name, json!({ "index": 1, "intensity": 2.5 })));
    let light_map = material.light_map.unwrap();
    let texture = light_map.light.texture.unwrap();
    assert_eq!(
        (light_map.light.factor, light_map.encoding, texture.texture, texture.uv_set),
        (2.5, LightEncoding::Linear, 1, 1)
    );
    assert!(!warnings.iter().any(|warning| warning.contains("materials")), "{warnings:?}");
    let transform = json!({ "KHR_texture_transform": { "scale": [2, 3] } });
    let (material, _) = read(extension(name, json!({ "index": 0, "texCoord": 0, "extensions": transform })));
    let light_map = material.light_map.unwrap();
    let texture = light_map.light.texture.unwrap();
    assert_eq!((light_map.light.factor, texture.uv_set, texture.transform.scale.y), (1.0, 0, 3.0));
    let (material, warnings) = read(extension(name, json!({ "index": 0, "intensity": -1 })));
    assert_eq!(material.light_map.unwrap().light.factor, 0.0);
    assert_eq!(warnings.iter().filter(|warning| warning.contains(name)).count(), 1, "{warnings:?}");
}

#[test]
fn directions_of_baked_light_lie_as_the_light_or_are_left_out() {
    let read_with = |light: Value, direction: Value| {
        let mut light = light;
        light["extensions"]["MANYPASS_light_direction"] = direction;
        let (material, warnings) = read(extension("MOZ_lightmap", light));
        let warnings: Vec<String> = warnings.into_iter().filter(|line| line.contains("light_direction")).collect();
        (material.light_map.unwrap(), warnings)
    };
    let (light_map, warnings) = read_with(json!({ "index": 1 }), json!({ "directionTexture": { "index": 0 } }));
    let direction = light_map.direction.unwrap();
    assert_eq!((direction.texture, direction.uv_set, warnings), (0, 1, Vec::new()));
    let on_first = json!({ "index": 1, "texCoord": 0 });
    let (light_map, warnings) = read_with(on_first.clone(), json!({ "directionTexture": { "index": 0 } }));
    assert_eq!((light_map.direction.unwrap().uv_set, warnings), (0, Vec::new()));
    let scaled = json!({ "KHR_texture_transform": { "scale": [2, 2] } });
    for (light, direction) in [
        (json!({ "index": 1 }), json!({})),
        (json!({ "index": 1 }), json!(7)),
        (json!({ "index": 1 }), json!({ "directionTexture": [] })),
        (json!({ "index": 1 }), json!({ "directionTexture": {} })),
        (json!({ "index": 1 }), json!({ "directionTexture": { "index": 99 } })),
        (json!({ "index": 1 }), json!({ "directionTexture": { "index": -1 } })),
        (json!({ "index": 1 }), json!({ "directionTexture": { "index": 0, "texCoord": 0 } })),
        (on_first, json!({ "directionTexture": { "index": 0, "texCoord": 1 } })),
        (json!({ "index": 1 }), json!({ "directionTexture": { "index": 0, "extensions": scaled } })),
    ] {
        let (light_map, warnings) = read_with(light, direction.clone());
        assert_eq!((light_map.direction, light_map.light.texture.map(|of| of.texture)), (None, Some(1)));
        let is_told = matches!(&warnings[..], [one] if one.contains("normal maps do not change baked light"));
        assert!(is_told, "{direction}: {warnings:?}");
    }
}

#[test]
fn specular_glossiness_is_a_dielectric_that_reflects_its_colour() {
    let (material, _) = read(extension(
        "KHR_materials_pbrSpecularGlossiness",
        json!({
            "diffuseFactor": [0.1, 0.2, 0.3, 0.4], "diffuseTexture": { "index": 0 },
            "specularFactor": [0.9, 0.8, 0.7], "glossinessFactor": 0.75, "specularGlossinessTexture": { "index": 1 },
        }),
    ));
    assert_eq!((material.base_color_factor.to_array(), material.metallic_factor), ([0.1, 0.2, 0.3, 0.4], 0.0));
    assert_eq!((material.ior, material.roughness_factor), (0.0, 0.25));
    let specular = material.specular.unwrap();
    assert_eq!((specular.color.factor, specular.glossiness), (Vec3::new(0.9, 0.8, 0.7), Some(0.75)));
    assert_eq!(material.base_color_texture.map(|map| map.texture), Some(0));
}
