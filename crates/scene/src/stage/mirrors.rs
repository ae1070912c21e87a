//! Mirrors of a stage.

use super::surfaces::{FACING, Surface, nodes_called};
use super::table::{Source, Table};
use crate::capture::{LAYERS_ALL, MIRRORS_MAX, Mirror};
use crate::{Diagnostic, Material, NodeId, Scene};
use glam::Vec3;
use std::sync::Arc;

/// An entry of `[[mirrors]]`.
#[derive(Clone, Debug)]
pub(super) struct MirrorEntry {
    surface: Surface,
    name: Option<String>,
    scale: f32,
    layers: u32,
    quality: Option<String>,
    color_linear: Option<Vec3>,
    roughness: Option<f32>,
}

/// The reflectance of a mirror of the stage's own where nobody says: that of silver behind glass, about.
const COLOR: Vec3 = Vec3::splat(0.93);

impl MirrorEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        Ok(Self {
            surface: Surface::read(table, "a mirror", FACING)?,
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
        let nodes = match &self.surface {
            Surface::Nodes(nodes) => nodes,
            Surface::New(rectangle) => {
                let name = self.name.clone().unwrap_or_else(|| "mirror".into());
                let material = Material {
                    name: "mirror".into(),
                    base_color_factor: self.color_linear.unwrap_or(COLOR).extend(1.0),
                    metallic_factor: 1.0,
                    roughness_factor: self.roughness.unwrap_or(0.0),
                    ..Material::default()
                };
                let id = rectangle.put(scene, &name, material);
                return self.push(scene, name, id, |message| source.fault(rectangle.range.clone(), message));
            }
        };
        let fault = |message: String| source.fault(nodes.range.clone(), message);
        for id in nodes_called(nodes, source, scene)? {
            let node = scene.node(id).name.clone();
            if scene.mirrors.iter().any(|mirror| mirror.node == id) {
                return Err(fault(format!("the node `{node}` is a mirror already")));
            }
            self.polish(scene, id);
            let name = self.name.clone().unwrap_or(node);
            self.push(scene, name, id, fault)?;
        }
        Ok(())
    }

    /// Makes a mirror of a node.
    fn push(
        &self,
        scene: &mut Scene,
        name: String,
        id: NodeId,
        fault: impl Fn(String) -> Box<Diagnostic>,
    ) -> Result<(), Box<Diagnostic>> {
        scene.panel(id).map_err(|what| fault(format!("a mirror is flat, and the node `{name}` {what}")))?;
        if scene.mirrors.len() == MIRRORS_MAX {
            return Err(fault(format!("there are more mirrors than {MIRRORS_MAX}")));
        }
        scene.mirrors.push(Mirror {
            scale: self.scale,
            layers: self.layers,
            quality: self.quality.clone(),
            ..Mirror::new(name, id)
        });
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
                // Metal without layers, whatever it was.
                material = Material {
                    name: material.name,
                    base_color_factor: color.extend(1.0),
                    metallic_factor: 1.0,
                    roughness_factor: 0.0,
                    normal_texture: material.normal_texture,
                    normal_scale: material.normal_scale,
                    has_normals_down: material.has_normals_down,
                    double_sided: material.double_sided,
                    casts_shadow: material.casts_shadow,
                    ..Material::default()
                };
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
