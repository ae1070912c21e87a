//! The names behind ids: what `object_id` and `material_id` hold is an index plus 1.

use manypass_scene::{Levels, NodeId, Scene};
use serde_json::{Map, Value, json};

/// The nodes of a scene by index: `{index, name, mesh, parent}`.
pub fn nodes(scene: &Scene) -> Vec<Value> {
    let node = |(index, node): (usize, &manypass_scene::Node)| json!({ "index": index, "name": node.name, "mesh": node.mesh, "parent": node.parent.map(|id| id.0) });
    scene.nodes.iter().enumerate().map(node).collect()
}

/// The materials of a scene by index: `{index, name, shading, layers}`: where its surfaces are shaded
/// ([`manypass::ShadedIn`]), and the layers for which the G-buffer has no room.
pub fn materials(scene: &Scene) -> Vec<Value> {
    let material = |(index, material): (usize, &manypass_scene::Material)| {
        let shading = manypass::ShadedIn::of(material).name();
        json!({ "index": index, "name": material.name, "shading": shading, "layers": manypass::layer_names(material) })
    };
    scene.materials.iter().enumerate().map(material).collect()
}

/// What has levels of detail: `{node or material, name, end_coverage, coarser}`, an index, the share of the picture's
/// area down to which it is shown itself, and of each coarser level the index, the name and its own such share.
pub fn levels(scene: &Scene) -> Vec<Value> {
    fn described<T>(levels: &Levels<T>, named: impl Fn(&T) -> (usize, String)) -> Vec<Value> {
        let coarser = levels.coarser.iter().zip(1..).map(|(coarser, level)| {
            let (index, name) = named(coarser);
            json!({ "index": index, "name": name, "end_coverage": levels.end_coverage(level) })
        });
        coarser.collect()
    }
    let of_node = |(index, node): (usize, &manypass_scene::Node)| {
        let levels = node.levels.as_ref()?;
        let named = |id: &NodeId| (id.0 as usize, scene.node(*id).name.clone());
        let coarser = described(levels, named);
        Some(json!({ "node": index, "name": node.name, "end_coverage": levels.end_coverage(0), "coarser": coarser }))
    };
    let of_material = |(index, material): (usize, &manypass_scene::Material)| {
        let levels = material.levels.as_ref()?;
        let name =
            |index: &usize| scene.materials.get(*index).map(|material| material.name.clone()).unwrap_or_default();
        let coarser = described(levels, |index| (*index, name(index)));
        Some(
            json!({ "material": index, "name": material.name, "end_coverage": levels.end_coverage(0), "coarser": coarser }),
        )
    };
    let nodes = scene.nodes.iter().enumerate().filter_map(of_node);
    nodes.chain(scene.materials.iter().enumerate().filter_map(of_material)).collect()
}

/// Those of [`materials`] that are shaded where they are drawn.
pub fn forward_materials(scene: &Scene) -> Vec<Value> {
    let mut all = materials(scene);
    all.retain(|material| material["shading"] != manypass::ShadedIn::Deferred.name());
    all
}

/// The names of a path; chains of a hundred thousand nodes would otherwise fill the memory.
const PATH_NAMES_MAX: usize = 64;

/// JSON in ASCII of every `object_id` that can occur: the id to the names of the node and of those above it,
/// `root/arm/hand`. A node without a name is `node_INDEX`. Of a path of more than 64 names only those nearest to the
/// node stand there, after `…/`.
pub fn object_ids(scene: &Scene) -> String {
    let mut manifest = Map::new();
    for (index, node) in scene.nodes.iter().enumerate().filter(|(_, node)| node.mesh.is_some()) {
        let name_of =
            |index: usize, name: &str| if name.is_empty() { format!("node_{index}") } else { name.to_owned() };
        let mut path = vec![name_of(index, &node.name)];
        let mut parent = node.parent;
        while let Some(above) = parent.and_then(|id| scene.nodes.get(id.0 as usize)) {
            if path.len() == PATH_NAMES_MAX {
                path.push("…".into());
                break;
            }
            path.push(name_of(parent.map_or(0, |id| id.0 as usize), &above.name));
            parent = above.parent;
        }
        path.reverse();
        manifest.insert((index + 1).to_string(), Value::String(path.join("/")));
    }
    ascii(&Value::Object(manifest))
}

/// JSON in ASCII of every `material_id`: the id to the name. A material without a name is `material_INDEX`; the last id
/// is that of surfaces without a material, `default`.
pub fn material_ids(scene: &Scene) -> String {
    let name = |(index, material): (usize, &manypass_scene::Material)| {
        let name = if material.name.is_empty() { format!("material_{index}") } else { material.name.clone() };
        ((index + 1).to_string(), Value::String(name))
    };
    let mut manifest: Map<String, Value> = scene.materials.iter().enumerate().map(name).collect();
    manifest.insert((scene.materials.len() + 1).to_string(), Value::String("default".into()));
    ascii(&Value::Object(manifest))
}

/// JSON whose letters are all ASCII, because attributes of EXR have no encoding.
pub(crate) fn ascii(value: &Value) -> String {
    let mut text = String::new();
    for letter in value.to_string().chars() {
        if letter.is_ascii() {
            text.push(letter);
        } else {
            let mut units = [0; 2];
            for unit in letter.encode_utf16(&mut units) {
                text.push_str(&format!("\\u{unit:04x}"));
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass_scene::{Material, Node};

    #[test]
    fn ids_have_names() {
        let mut scene = Scene::default();
        let named = |name: &str, mesh| Node { name: name.into(), mesh, ..Node::default() };
        let root = scene.add_node(None, named("Wagen \"ü\"", None));
        let axle = scene.add_node(Some(root), named("", None));
        scene.add_node(Some(axle), named("wheel 🛞", Some(0)));
        scene.materials.push(Material { name: "paint".into(), ..Material::default() });
        scene.materials.push(Material::default());
        let objects = object_ids(&scene);
        assert!(objects.is_ascii());
        let read = |text: &str| -> Value { serde_json::from_str(text).expect("JSON") };
        assert_eq!(read(&objects), json!({ "3": "Wagen \"ü\"/node_1/wheel 🛞" }));
        let expected = json!({ "1": "paint", "2": "material_1", "3": "default" });
        assert_eq!(read(&material_ids(&scene)), expected);
        assert_eq!(nodes(&scene)[2], json!({ "index": 2, "name": "wheel 🛞", "mesh": 0, "parent": 1 }));
    }
}
