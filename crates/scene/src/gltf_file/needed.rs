//! What is broken in a file and may not be needed: the picture is drawn where nothing in it needs that.

use super::document::Document;
use super::error::LoadError;
use super::faults::List;
use super::json::Json;
use crate::{NodeId, Scene};
use std::collections::BTreeSet;

/// Warns of names that are no strings; the objects have none then.
pub(super) fn check_names(document: &mut Document) -> Result<(), LoadError> {
    for key in
        ["meshes", "materials", "nodes", "scenes", "cameras", "skins", "animations", "images", "textures", "samplers"]
    {
        for json in document.root.objects(key)? {
            if json.has("name") && json.string("name").is_err() {
                document.warn(&json.at("name"), "expected a string; it has no name");
            }
        }
    }
    Ok(())
}

/// Refuses a file whose scene shows something that is broken; warns of what else is.
///
/// # Errors
/// The fault of what is shown.
pub(super) fn check_needed(document: &mut Document, scene: &Scene) -> Result<(), LoadError> {
    if document.faults.0.is_empty() {
        return Ok(());
    }
    let faults = &document.faults;
    let mut checked_skins = BTreeSet::new();
    for NodeId(index) in scene.reachable_nodes() {
        let node = scene.node(NodeId(index));
        faults.check(List::Nodes, index as usize)?;
        if let Some(light) = node.light {
            faults.check(List::Lights, light)?;
        }
        let Some(mesh) = node.mesh else { continue };
        faults.check(List::Meshes, mesh)?;
        if let Some(skin) = node.skin {
            faults.check(List::Skins, skin)?;
            // Joints need not be in the scene. Those of a skin that many nodes share are looked at once.
            let unchecked = scene.skins.get(skin).filter(|_| checked_skins.insert(skin));
            let joints = unchecked.into_iter().flat_map(|skin| &skin.joints);
            joints.into_iter().try_for_each(|joint| faults.check(List::Nodes, joint.0 as usize))?;
        }
        for primitive in scene.meshes.get(mesh).into_iter().flat_map(|mesh| &mesh.primitives) {
            let of_variants = primitive.variant_materials.iter().map(|(_, material)| *material);
            for material in primitive.material.into_iter().chain(of_variants) {
                faults.check(List::Materials, material)?;
                let levels = scene.materials.get(material).and_then(|material| material.levels.as_ref());
                levels
                    .iter()
                    .flat_map(|levels| &levels.coarser)
                    .try_for_each(|level| faults.check(List::Materials, *level))?;
            }
        }
    }
    for error in std::mem::take(&mut document.faults).0.into_values() {
        let pointer = error.pointer().to_owned();
        document.warn(&pointer, &format!("{}; nothing that is shown needs it", error.into_message()));
    }
    Ok(())
}

/// An index of a list, or none where there is no such object.
pub(super) fn index_or_none(
    document: &mut Document,
    json: &Json,
    key: &str,
    length: usize,
    what: &str,
) -> Option<usize> {
    json.index(key, length, what).unwrap_or_else(|error| {
        document.warn(&json.at(key), &format!("{}; it does without", error.into_message()));
        None
    })
}
