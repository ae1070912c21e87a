//! Light maps as a glTF file.

use crate::apply::{PageTextures, remade};
use crate::encode::Encoding;
use crate::{BakeError, BakedMaps};
use manypass_scene::gltf_file::{Numbers, Parts};
use manypass_scene::material::LightEncoding;
use manypass_scene::{NodeId, Primitive, Scene};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// The extension of light maps, which Mozilla Hubs began.
const LIGHT_MAP: &str = "MOZ_lightmap";
/// The extension of light maps with directions.
const LIGHT_DIRECTION: &str = "MANYPASS_light_direction";
const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
const INSTANCES: &str = "EXT_mesh_gpu_instancing";
const DRACO: &str = "KHR_draco_mesh_compression";

/// Removes an extension of an object, and its list of them if that is empty then.
fn remove_extension(object: &mut Value, name: &str) -> bool {
    let Some(extensions) = object.get_mut("extensions").and_then(Value::as_object_mut) else { return false };
    let was_there = extensions.remove(name).is_some();
    if extensions.is_empty()
        && let Some(object) = object.as_object_mut()
    {
        object.remove("extensions");
    }
    was_there
}

/// Every instance becomes a node of its own, as the scene has them: each has a place of its own in the maps.
fn spread_instances(parts: &mut Parts, scene: &Scene) {
    let count = parts.list("nodes").len();
    let has_instances = |node: &Value| node.pointer(&format!("/extensions/{INSTANCES}")).is_some();
    if !parts.list("nodes").iter().any(has_instances) {
        return;
    }
    let mut spread = BTreeSet::new();
    for (index, node) in scene.nodes.iter().enumerate().skip(count) {
        // What a stage adds is no instance.
        let Some(NodeId(parent)) = node.parent else { break };
        if !parts.list("nodes").get(parent as usize).is_some_and(has_instances) {
            break;
        }
        let mesh = parts.json["nodes"][parent as usize]["mesh"].clone();
        let instance = json!({
            "name": node.name,
            "mesh": mesh,
            "translation": node.translation.to_array(),
            "rotation": node.rotation.to_array(),
            "scale": node.scale.to_array(),
        });
        parts.push("nodes", instance);
        spread.insert(parent as usize);
        let parent = &mut parts.json["nodes"][parent as usize];
        match parent.get_mut("children").and_then(Value::as_array_mut) {
            Some(children) => children.push(index.into()),
            None => parent["children"] = json!([index]),
        }
    }
    for index in spread {
        let node = &mut parts.json["nodes"][index];
        if remove_extension(node, INSTANCES)
            && let Some(node) = node.as_object_mut()
        {
            node.remove("mesh");
            node.remove("weights");
        }
    }
    if !parts.list("nodes").iter().any(has_instances) {
        parts.forget_extension(INSTANCES);
    }
}

/// A primitive of a file with other vertices.
fn rewrite(parts: &mut Parts, json: &Value, primitive: &Primitive) -> Value {
    let mut written = json.as_object().cloned().unwrap_or_default();
    let had_tangents = json.pointer("/attributes/TANGENT").is_some();
    let mut attributes = Map::new();
    let mut give = |name: &str, numbers: Numbers, is_there: bool| {
        if is_there {
            attributes.insert(name.into(), parts.append_accessor(numbers).into());
        }
    };
    give("POSITION", Numbers::Vec3(&primitive.positions), true);
    give("NORMAL", Numbers::Vec3(&primitive.normals), !primitive.normals.is_empty());
    give("TANGENT", Numbers::Vec4(&primitive.tangents), had_tangents && !primitive.tangents.is_empty());
    give("TEXCOORD_0", Numbers::Vec2(&primitive.uv0), !primitive.uv0.is_empty());
    give("TEXCOORD_1", Numbers::Vec2(&primitive.uv1), true);
    give("COLOR_0", Numbers::Vec4(&primitive.colors), !primitive.colors.is_empty());
    // Sets are counted without gaps.
    if primitive.uv0.is_empty()
        && let Some(second) = attributes.get("TEXCOORD_1").cloned()
    {
        attributes.insert("TEXCOORD_0".into(), second);
    }
    written.insert("attributes".into(), attributes.into());
    written.insert("indices".into(), parts.append_accessor(Numbers::Indices(&primitive.indices)).into());
    written.remove("mode");
    let mut written = Value::from(written);
    remove_extension(&mut written, DRACO);
    written
}

impl BakedMaps {
    /// Puts them into the file that `scene`, of which they were made, was read from: surfaces have a second UV set, their
    /// materials `MOZ_lightmap`, and what nothing refers to any more is gone.
    ///
    /// # Errors
    /// The encoder of images fails.
    pub fn write(&self, parts: &mut Parts, scene: &Scene, encoding: Encoding) -> Result<(), BakeError> {
        let unreferenced = parts.unreferenced();
        spread_instances(parts, scene);
        let sampler = json!({ "magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071 });
        let sampler = parts.push("samplers", sampler);
        let pages = self.textures(encoding, |file| {
            let image = parts.append_image(&file.name, file.mime_type, &file.bytes);
            let Some(extension) = file.extension else {
                return parts.push("textures", json!({ "sampler": sampler, "source": image }));
            };
            parts.use_extension(extension);
            parts.push("textures", json!({ "sampler": sampler, "extensions": { extension: { "source": image } } }))
        })?;
        let mut materials: BTreeMap<(Option<u64>, u32), usize> = BTreeMap::new();
        for (id, of_node) in self.by_node() {
            let NodeId(node) = id;
            let Some(index) = parts.json["nodes"][node as usize]["mesh"].as_u64() else { continue };
            let placed = scene.node(id);
            let Some(mesh) = placed.mesh.and_then(|mesh| scene.meshes.get(mesh)) else { continue };
            let is_mirrored = placed.world_from_object.determinant() < 0.0;
            let mut written = parts.json["meshes"][index as usize].clone();
            for of in of_node {
                let Some(primitive) = mesh.primitives.get(of.place.primitive) else { continue };
                let json = written["primitives"][of.place.primitive].take();
                let mut json = rewrite(parts, &json, &remade(primitive, of, is_mirrored));
                let mut baked = |material: Option<u64>| {
                    *materials.entry((material, of.page)).or_insert_with(|| {
                        let of_page = pages.get(of.page as usize).copied().unwrap_or_default();
                        with_maps(parts, material, (of_page, encoding, self.is_emission))
                    })
                };
                json["material"] = baked(json.get("material").and_then(Value::as_u64)).into();
                let variants = json.pointer_mut("/extensions/KHR_materials_variants/mappings");
                for mapping in variants.and_then(Value::as_array_mut).into_iter().flatten() {
                    mapping["material"] = baked(mapping["material"].as_u64()).into();
                }
                written["primitives"][of.place.primitive] = json;
            }
            let mesh = parts.push("meshes", written);
            parts.json["nodes"][node as usize]["mesh"] = mesh.into();
        }
        if !self.light.is_empty() && !self.is_emission {
            parts.use_extension(LIGHT_MAP);
        }
        if !self.direction.is_empty() {
            parts.use_extension(LIGHT_DIRECTION);
        }
        parts.prune(&unreferenced);
        for name in [
            DRACO,
            LIGHT_MAP,
            LIGHT_DIRECTION,
            "MOZ_texture_rgbe",
            "MANYPASS_texture_exr",
            "KHR_materials_pbrSpecularGlossiness",
        ] {
            if !mentions(&parts.json, name) {
                parts.forget_extension(name);
            }
        }
        Ok(())
    }
}

/// Whether anything in a file has a key of this name.
fn mentions(json: &Value, name: &str) -> bool {
    match json {
        Value::Object(object) => object.iter().any(|(key, value)| key == name || mentions(value, name)),
        Value::Array(list) => list.iter().any(|value| mentions(value, name)),
        _ => false,
    }
}

/// Makes a material send out the light of a texture, and send back next to nothing else.
fn put_emission(material: &mut Value, texture: usize, factor: f32) {
    material["emissiveTexture"] = json!({ "index": texture, "texCoord": 1 });
    // Factors end at 1, and strengths begin at nothing.
    material["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
    material["extensions"][EMISSIVE_STRENGTH] = json!({ "emissiveStrength": factor });
    // These take the place of what follows, or add to it.
    remove_extension(material, "KHR_materials_pbrSpecularGlossiness");
    remove_extension(material, "KHR_materials_diffuse_transmission");
    let plain = &mut material["pbrMetallicRoughness"];
    let alpha = plain.pointer("/baseColorFactor/3").and_then(Value::as_f64).unwrap_or(1.0);
    plain["baseColorFactor"] = json!([0.0, 0.0, 0.0, alpha]);
    plain["metallicFactor"] = 0.0.into();
}

/// A copy of a material, or the default one, with the maps of a page.
fn with_maps(
    parts: &mut Parts,
    material: Option<u64>,
    (of_page, encoding, is_emission): (PageTextures, Encoding, bool),
) -> usize {
    let original = material.and_then(|index| parts.list("materials").get(index as usize));
    let mut material = original.cloned().unwrap_or_else(|| json!({}));
    // Maps of a bake before lie on the UV set that is exchanged.
    remove_extension(&mut material, LIGHT_MAP);
    if material.pointer("/occlusionTexture/texCoord").is_some_and(|set| set == 1)
        && let Some(material) = material.as_object_mut()
    {
        material.remove("occlusionTexture");
    }
    if let Some((texture, factor)) = of_page.light.filter(|_| is_emission) {
        let shines = material["emissiveFactor"].as_array().is_some_and(|of| of.iter().any(|part| *part != 0.0));
        if !shines {
            put_emission(&mut material, texture, factor);
            parts.use_extension(EMISSIVE_STRENGTH);
        }
    } else if let Some((texture, factor)) = of_page.light {
        let mut map = json!({ "index": texture, "texCoord": 1, "intensity": factor });
        if encoding.of_material() == LightEncoding::Rgbm {
            map["extras"]["encoding"] = "rgbm".into();
        }
        if let Some(texture) = of_page.direction {
            map["extensions"][LIGHT_DIRECTION]["directionTexture"] = json!({ "index": texture, "texCoord": 1 });
        }
        material["extensions"][LIGHT_MAP] = map;
    }
    if let Some(texture) = of_page.occlusion {
        material["occlusionTexture"] = json!({ "index": texture, "texCoord": 1 });
    }
    parts.push("materials", material)
}
