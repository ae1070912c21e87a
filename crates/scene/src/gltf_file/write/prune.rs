//! What nothing refers to any more leaves a file.

use super::Parts;
use crate::gltf_file::extensions::SUPPORTED_EXTENSIONS;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// An index that may be somewhere.
fn index(value: Option<&mut Value>, visit: &mut dyn FnMut(&mut Value)) {
    if let Some(value) = value.filter(|value| value.is_u64()) {
        visit(value);
    }
}

fn each<'v>(value: Option<&'v mut Value>) -> Box<dyn Iterator<Item = &'v mut Value> + 'v> {
    match value {
        Some(Value::Array(list)) => Box::new(list.iter_mut()),
        Some(Value::Object(object)) => Box::new(object.values_mut()),
        _ => Box::new(std::iter::empty()),
    }
}

/// Every index of a mesh.
fn visit_meshes(json: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    each(json.get_mut("nodes")).for_each(|node| index(node.get_mut("mesh"), visit));
}

/// Every index of an accessor.
fn visit_accessors(json: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for primitive in each(json.get_mut("meshes")).flat_map(|mesh| each(mesh.get_mut("primitives"))) {
        each(primitive.get_mut("attributes")).for_each(|attribute| index(Some(attribute), visit));
        index(primitive.get_mut("indices"), visit);
        each(primitive.get_mut("targets")).flat_map(|target| each(Some(target))).for_each(|of| index(Some(of), visit));
    }
    for sampler in each(json.get_mut("animations")).flat_map(|animation| each(animation.get_mut("samplers"))) {
        index(sampler.get_mut("input"), visit);
        index(sampler.get_mut("output"), visit);
    }
    each(json.get_mut("skins")).for_each(|skin| index(skin.get_mut("inverseBindMatrices"), visit));
    for node in each(json.get_mut("nodes")) {
        let attributes = node.pointer_mut("/extensions/EXT_mesh_gpu_instancing/attributes");
        each(attributes).for_each(|attribute| index(Some(attribute), visit));
    }
    for grid in each(json.pointer_mut("/extensions/MANYPASS_probes/grids")) {
        ["light", "sources", "places", "distances"].into_iter().for_each(|key| index(grid.get_mut(key), visit));
    }
}

/// Every index of a buffer view.
fn visit_views(json: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for accessor in each(json.get_mut("accessors")) {
        index(accessor.get_mut("bufferView"), visit);
        index(accessor.pointer_mut("/sparse/indices/bufferView"), visit);
        index(accessor.pointer_mut("/sparse/values/bufferView"), visit);
    }
    each(json.get_mut("images")).for_each(|image| index(image.get_mut("bufferView"), visit));
    let places = json.pointer_mut("/extensions/MANYPASS_surroundings/places");
    each(places).for_each(|place| index(place.get_mut("picture"), visit));
    for primitive in each(json.get_mut("meshes")).flat_map(|mesh| each(mesh.get_mut("primitives"))) {
        index(primitive.pointer_mut("/extensions/KHR_draco_mesh_compression/bufferView"), visit);
    }
}

/// Every index of a material.
fn visit_materials(json: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for primitive in each(json.get_mut("meshes")).flat_map(|mesh| each(mesh.get_mut("primitives"))) {
        index(primitive.get_mut("material"), visit);
        let mappings = primitive.pointer_mut("/extensions/KHR_materials_variants/mappings");
        each(mappings).for_each(|mapping| index(mapping.get_mut("material"), visit));
    }
    for material in each(json.get_mut("materials")) {
        each(material.pointer_mut("/extensions/MSFT_lod/ids")).for_each(|of| index(Some(of), visit));
    }
}

/// Every index of a texture: `index` of whatever is in a material.
fn visit_textures(json: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    fn within(value: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
        if value.is_object() {
            index(value.get_mut("index"), visit);
        }
        let parts = value.as_object_mut().into_iter().flatten().filter(|(key, _)| *key != "extras");
        parts.for_each(|(_, value)| within(value, visit));
    }
    each(json.get_mut("materials")).for_each(|material| within(material, visit));
}

/// Every index of an image.
fn visit_images(json: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for texture in each(json.get_mut("textures")) {
        index(texture.get_mut("source"), visit);
        each(texture.get_mut("extensions")).for_each(|extension| index(extension.get_mut("source"), visit));
    }
}

/// Every index of a sampler of textures.
fn visit_samplers(json: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    each(json.get_mut("textures")).for_each(|texture| index(texture.get_mut("sampler"), visit));
}

type Visit = fn(&mut Value, &mut dyn FnMut(&mut Value));

/// Lists whose objects files may hold although nothing refers to them, those that refer to others first.
const KEPT: [(&str, Visit); 4] = [
    ("materials", visit_materials),
    ("textures", visit_textures),
    ("images", visit_images),
    ("samplers", visit_samplers),
];

/// Objects that nothing refers to, list by list.
#[derive(Clone, Debug, Default)]
pub struct UnreferencedObjects([BTreeSet<u64>; KEPT.len()]);

/// Leaves out of a list what `visit` finds no index of, and counts anew.
fn compact(json: &mut Value, key: &str, visit: Visit, kept: &BTreeSet<u64>) {
    let mut used = kept.clone();
    visit(json, &mut |index| {
        used.extend(index.as_u64());
    });
    let Some(list) = json.get_mut(key).and_then(Value::as_array_mut) else { return };
    let mut number = 0;
    list.retain(|_| {
        number += 1;
        used.contains(&(number - 1))
    });
    if list.is_empty()
        && let Some(root) = json.as_object_mut()
    {
        root.remove(key);
    }
    let places: BTreeMap<u64, usize> = used.iter().enumerate().map(|(place, index)| (*index, place)).collect();
    visit(json, &mut |index| {
        let now = index.as_u64().and_then(|index| places.get(&index));
        *index = now.copied().map_or(Value::Null, Value::from);
    });
}

impl Parts {
    /// The materials, textures, images and samplers that nothing refers to.
    pub fn unreferenced(&mut self) -> UnreferencedObjects {
        let mut unreferenced = UnreferencedObjects::default();
        for (indices, (key, visit)) in unreferenced.0.iter_mut().zip(KEPT) {
            indices.extend(0..self.list(key).len() as u64);
            visit(&mut self.json, &mut |index| {
                if let Some(index) = index.as_u64() {
                    indices.remove(&index);
                }
            });
        }
        unreferenced
    }

    /// Leaves out meshes, accessors, buffer views and bytes that nothing refers to, and materials, textures, images and
    /// samplers that are none of `kept`. A file that uses extensions which are not [`SUPPORTED_EXTENSIONS`] keeps them all,
    /// because those may refer to anything; one with pointers of animations its meshes and materials.
    pub fn prune(&mut self, kept: &UnreferencedObjects) {
        let is_known = |name: &Value| SUPPORTED_EXTENSIONS.iter().any(|known| name == known);
        if !self.list("extensionsUsed").iter().all(is_known) {
            return;
        }
        let none = BTreeSet::new();
        if !self.list("extensionsUsed").iter().any(|name| name == "KHR_animation_pointer") {
            compact(&mut self.json, "meshes", visit_meshes, &none);
            for (kept, (key, visit)) in kept.0.iter().zip(KEPT) {
                compact(&mut self.json, key, visit, kept);
            }
        }
        compact(&mut self.json, "accessors", visit_accessors, &none);
        compact(&mut self.json, "bufferViews", visit_views, &none);
        let old = std::mem::take(&mut self.binary);
        let mut views = self.json["bufferViews"].take();
        for view in each(Some(&mut views)) {
            self.keep_bytes(view, &old);
            each(view.get_mut("extensions")).for_each(|extension| self.keep_bytes(extension, &old));
        }
        if views.is_array() {
            self.json["bufferViews"] = views;
        } else if let Some(root) = self.json.as_object_mut() {
            root.remove("bufferViews");
        }
    }

    /// Copies the bytes of a view, or of an extension of one, and says where they lie now.
    fn keep_bytes(&mut self, view: &mut Value, old: &[u8]) {
        let number = |key: &str| view.get(key).and_then(Value::as_u64).map(|number| number as usize);
        let (Some(0), Some(length)) = (number("buffer"), number("byteLength")) else { return };
        let offset = number("byteOffset").unwrap_or(0);
        let bytes = old.get(offset..offset.saturating_add(length)).unwrap_or_default();
        view["byteOffset"] = self.append_bytes(bytes).into();
    }
}
