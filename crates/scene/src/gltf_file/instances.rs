//! `EXT_mesh_gpu_instancing`: many places for the mesh of one node. Every place becomes a child of the node that shares
//! the mesh; the renderer draws equal meshes together, wherever they come from.
//!
//! Source: the specification of that name (Khronos 3D Formats). Attributes that do not place an instance are passed
//! over, as it allows.

use super::accessor::to_f32;
use super::component::Component;
use super::document::Document;
use super::error::LoadError;
use super::json::Json;
use crate::{Channel, Keyframes, Node, NodeId, Scene, scenes::MAX_DRAWN_PRIMITIVES};
use glam::{Quat, Vec3};

/// Puts a child for every instance below the nodes that have some, and takes their mesh from them.
///
/// # Errors
/// If the attributes are broken, or all instances together are more than [`MAX_DRAWN_PRIMITIVES`].
pub(super) fn place(document: &mut Document, scene: &mut Scene) -> Result<(), LoadError> {
    let mut left = MAX_DRAWN_PRIMITIVES;
    for (index, json) in document.root.objects("nodes")?.iter().enumerate() {
        let Some(extension) = json.extension("EXT_mesh_gpu_instancing")? else { continue };
        let attributes = extension.require_object("attributes")?;
        let Some(count) = count(document, &attributes)? else { continue };
        let Some(node) = scene.nodes.get(index).filter(|node| node.mesh.is_some()) else { continue };
        if node.skin.is_some() {
            let message = "a skin, not the places of instances, says where the mesh is; it is drawn once";
            document.warn(&extension.pointer, message);
            continue;
        }
        let moves_weights = |channel: &Channel| {
            channel.node.0 as usize == index && matches!(channel.keyframes, Keyframes::MorphWeights { .. })
        };
        if scene.animations.iter().flat_map(|animation| &animation.channels).any(moves_weights) {
            document.warn(&extension.pointer, "animated morph weights do not reach instances");
        }
        left = left.checked_sub(count).ok_or_else(|| {
            let message = format!("the file has more than {MAX_DRAWN_PRIMITIVES} instances; split it");
            attributes.error("TRANSLATION", message)
        })?;
        document.spend((count * size_of::<Node>()) as u64, &attributes.pointer)?;
        let shared = Node {
            name: node.name.clone(),
            parent: Some(NodeId(index as u32)),
            mesh: node.mesh,
            morph_weights: node.morph_weights.clone(),
            ..Node::default()
        };
        let weights_bytes = shared.name.len() + size_of_val(shared.morph_weights.as_slice());
        document.spend((count as u64).saturating_mul(weights_bytes as u64), &attributes.pointer)?;
        let places = read_places(document, &attributes, count)?;
        let first = scene.nodes.len() as u32;
        let children = places.into_iter().map(|(translation, rotation, scale)| Node {
            translation,
            rotation,
            scale,
            ..shared.clone()
        });
        scene.nodes.extend(children);
        if let Some(node) = scene.nodes.get_mut(index) {
            node.mesh = None;
            node.morph_weights.clear();
            node.children.extend((first..first + count as u32).map(NodeId));
        }
    }
    Ok(())
}

/// How many instances there are: as many as every attribute has elements; none without attributes.
fn count(document: &Document, attributes: &Json) -> Result<Option<usize>, LoadError> {
    let mut count = None;
    for key in attributes.keys() {
        let Some(index) = attributes.index(key, document.accessors.len(), "accessor")? else { continue };
        let found = document.accessor_header(index, &attributes.at(key))?.count;
        let expected = *count.get_or_insert(found);
        if found != expected {
            let message = format!("expected {expected} elements, as many as the other attributes, found {found}");
            return Err(attributes.error(key, message));
        }
    }
    Ok(count)
}

type Place = (Vec3, Quat, Vec3);

fn read_places(document: &mut Document, attributes: &Json, count: usize) -> Result<Vec<Place>, LoadError> {
    let mut places = vec![(Vec3::ZERO, Quat::IDENTITY, Vec3::ONE); count];
    for ((translation, _, _), value) in places.iter_mut().zip(read(document, attributes, "TRANSLATION")?) {
        *translation = Vec3::from(value);
    }
    let mut is_broken = false;
    for ((_, rotation, _), value) in places.iter_mut().zip(read::<4>(document, attributes, "ROTATION")?) {
        let length = Quat::from_array(value).length();
        is_broken |= !(0.5..2.0).contains(&length);
        *rotation = if length > 0.0 { Quat::from_array(value) / length } else { Quat::IDENTITY };
    }
    if is_broken {
        document.warn(&attributes.at("ROTATION"), "some quaternions are far from unit length; they are normalised");
    }
    for ((_, _, scale), value) in places.iter_mut().zip(read(document, attributes, "SCALE")?) {
        *scale = Vec3::from(value);
    }
    Ok(places)
}

/// The elements of an attribute; none without it. Rotations may be normalised integers, the others are floats.
fn read<const N: usize>(document: &mut Document, attributes: &Json, key: &str) -> Result<Vec<[f32; N]>, LoadError> {
    let Some(index) = attributes.index(key, document.accessors.len(), "accessor")? else { return Ok(Vec::new()) };
    let header = document.accessor_header(index, &attributes.at(key))?;
    let is_packed = N == 4 && header.normalized && matches!(header.component, Component::I8 | Component::I16);
    if header.component != Component::F32 && !is_packed {
        let packed = if N == 4 { " or normalized signed integers of 8 or 16 bits" } else { "" };
        return Err(attributes.error(key, format!("expected floats{packed}")));
    }
    let values = document.read::<f32, N>(index, &attributes.at(key), to_f32)?;
    if values.iter().flatten().any(|value| !value.is_finite()) {
        return Err(attributes.error(key, "expected finite numbers"));
    }
    Ok(values)
}
