//! Mirrors of a stage.

use super::names::Pattern;
use super::table::{Placed, Source, Table};
use crate::capture::{LAYERS_ALL, MIRRORS_MAX, Mirror};
use crate::framing::look_along;
use crate::primitives::plane;
use crate::{Diagnostic, Material, Mesh, Node, NodeId, Primitive, Scene};
use glam::{Quat, Vec2, Vec3};
use std::ops::Range;
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

/// What is a mirror.
#[derive(Clone, Debug)]
enum Surface {
    /// Nodes of the model.
    Nodes(Placed<Pattern>),
    /// A rectangle of the stage's own.
    New { position: Vec3, rotation: Quat, size_m: Vec2, range: Range<usize> },
}

/// The reflectance of a mirror of the stage's own where nobody says: that of silver behind glass, about.
const COLOR: Vec3 = Vec3::splat(0.93);

/// The largest side.
const SIZE_MAX_M: f32 = 1e6;

impl MirrorEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        Ok(Self {
            surface: surface(table)?,
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
            Surface::New { position, rotation, size_m, range } => {
                let (name, id) = self.put(scene, (*position, *rotation, *size_m));
                return self.push(scene, name, id, |message| source.fault(range.clone(), message));
            }
        };
        let pattern = &nodes.value;
        let fault = |message: String| source.fault(nodes.range.clone(), message);
        let found: Vec<NodeId> = (0..)
            .map(NodeId)
            .zip(&scene.nodes)
            .filter(|(_, node)| pattern.matches(&node.name))
            .map(|(id, _)| id)
            .collect();
        if found.is_empty() {
            let message = format!("the model has no node called `{}`", pattern.text());
            let known = scene.nodes.iter().map(|node| node.name.as_str());
            return Err(source.unknown(nodes.range.clone(), message, pattern.text(), known));
        }
        for id in found {
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

    /// Adds a rectangle to every scene of the file.
    fn put(&self, scene: &mut Scene, (position, rotation, size_m): (Vec3, Quat, Vec2)) -> (String, NodeId) {
        scene.materials.push(Material {
            name: "mirror".into(),
            base_color_factor: self.color_linear.unwrap_or(COLOR).extend(1.0),
            metallic_factor: 1.0,
            roughness_factor: self.roughness.unwrap_or(0.0),
            ..Material::default()
        });
        let material = Some(scene.materials.len() - 1);
        let square = Primitive { material, ..plane(1.0) };
        scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
        let name = self.name.clone().unwrap_or_else(|| "mirror".into());
        let node = Node {
            name: name.clone(),
            mesh: Some(scene.meshes.len() - 1),
            translation: position,
            // The plane faces up, and its v runs down the picture.
            rotation: rotation * Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
            scale: Vec3::new(size_m.x, 1.0, size_m.y),
            ..Node::default()
        };
        let id = scene.add_node(None, node);
        scene.scenes.iter_mut().for_each(|roots| roots.roots.push(id));
        scene.update_transforms();
        (name, id)
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

/// What is a mirror: nodes of the model, or a rectangle.
fn surface(table: &Table<'_>) -> Result<Surface, Box<Diagnostic>> {
    let of_rectangle = ["position", "facing", "size_m"];
    let given = of_rectangle.into_iter().find(|key| table.place(key).is_some());
    match (table.text("node"), given) {
        (Some(_), Some(key)) => {
            Err(table.fault(key, format!("`node` is a surface of the model; leave out `{key}`, or `node`")))
        }
        (Some(node), None) => Ok(Surface::Nodes(Placed { value: Pattern::new(&node.value), range: node.range })),
        (None, _) => {
            let (position, facing, size_m) = (table.vector("position"), table.vector("facing"), table.pair("size_m"));
            let (Some(position), Some(facing), Some(size_m)) = (position, facing, size_m) else {
                let message =
                    "a mirror needs `node`, a flat surface of the model, or `position`, `facing` and `size_m`";
                return Err(table.source.fault(table.range.clone(), message));
            };
            // It looks back along what it faces.
            let rotation = look_along(-facing, Vec3::Y);
            let rotation =
                rotation.ok_or_else(|| table.fault("facing", "`facing` is a direction, and has no length"))?;
            if size_m.min_element() <= 0.0 || size_m.max_element() > SIZE_MAX_M {
                let message = format!("`size_m` is a width and a height above 0, of at most {SIZE_MAX_M} metres");
                return Err(table.fault("size_m", message));
            }
            Ok(Surface::New { position, rotation, size_m, range: table.range.clone() })
        }
    }
}
