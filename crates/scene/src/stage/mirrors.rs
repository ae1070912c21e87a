//! Mirrors of a stage.

use super::names::Pattern;
use super::table::{Placed, Source, Table};
use crate::capture::{LAYERS_ALL, MIRRORS_MAX, Mirror};
use crate::{Diagnostic, NodeId, Scene};
use glam::Vec3;
use std::sync::Arc;

/// An entry of `[[mirrors]]`.
#[derive(Clone, Debug)]
pub(super) struct MirrorEntry {
    nodes: Placed<Pattern>,
    name: Option<String>,
    scale: f32,
    layers: u32,
    quality: Option<String>,
    color_linear: Option<Vec3>,
    roughness: Option<f32>,
}

impl MirrorEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let node = table.text("node").ok_or_else(|| table.fault("node", "`node` is missing"))?;
        Ok(Self {
            nodes: Placed { value: Pattern::new(&node.value), range: node.range },
            name: table.text("name").map(|name| name.value).filter(|name| !name.trim().is_empty()),
            scale: table.number("scale").unwrap_or(1.0),
            layers: table.layers("layers").unwrap_or(LAYERS_ALL),
            quality: table.text("quality").map(|word| word.value),
            color_linear: table.vector("color"),
            roughness: table.number("roughness"),
        })
    }

    /// Makes mirrors of its nodes. Transforms are up to date.
    ///
    /// # Errors
    /// The model has no node of that name, it is not flat, or there are too many.
    pub(super) fn apply(&self, source: &Source, scene: &mut Scene) -> Result<(), Box<Diagnostic>> {
        let pattern = &self.nodes.value;
        let fault = |message: String| source.fault(self.nodes.range.clone(), message);
        let found: Vec<NodeId> = (0..)
            .map(NodeId)
            .zip(&scene.nodes)
            .filter(|(_, node)| pattern.matches(&node.name))
            .map(|(id, _)| id)
            .collect();
        if found.is_empty() {
            let message = format!("the model has no node called `{}`", pattern.text());
            let known = scene.nodes.iter().map(|node| node.name.as_str());
            return Err(source.unknown(self.nodes.range.clone(), message, pattern.text(), known));
        }
        for id in found {
            let node = scene.node(id).name.clone();
            scene.panel(id).map_err(|what| fault(format!("a mirror is flat, and the node `{node}` {what}")))?;
            if scene.mirrors.iter().any(|mirror| mirror.node == id) {
                return Err(fault(format!("the node `{node}` is a mirror already")));
            }
            if scene.mirrors.len() == MIRRORS_MAX {
                return Err(fault(format!("there are more mirrors than {MIRRORS_MAX}")));
            }
            self.polish(scene, id);
            let name = self.name.clone().unwrap_or(node);
            scene.mirrors.push(Mirror {
                scale: self.scale,
                layers: self.layers,
                quality: self.quality.clone(),
                ..Mirror::new(name, id)
            });
        }
        Ok(())
    }

    /// Gives a node materials of its own that are as the mirror is to be.
    fn polish(&self, scene: &mut Scene, id: NodeId) {
        let Scene { nodes, meshes, materials, .. } = scene;
        let Some(node) = nodes.get_mut(id.0 as usize) else { return };
        let Some(mesh) = node.mesh.and_then(|mesh| meshes.get(mesh)) else { return };
        if self.color_linear.is_none() && self.roughness.is_none() {
            return;
        }
        let mut mesh = Arc::unwrap_or_clone(mesh.clone());
        for primitive in &mut mesh.primitives {
            let own = primitive.material.and_then(|material| materials.get(material));
            let mut material = own.cloned().unwrap_or_default();
            if let Some(color) = self.color_linear {
                material.base_color_factor = color.extend(1.0);
                material.base_color_texture = None;
                material.metallic_factor = 1.0;
                material.metallic_roughness_texture = None;
            }
            if let Some(roughness) = self.roughness {
                material.roughness_factor = roughness;
                material.metallic_roughness_texture = None;
            }
            materials.push(material);
            primitive.material = Some(materials.len() - 1);
        }
        meshes.push(mesh.into());
        node.mesh = Some(meshes.len() - 1);
    }
}
