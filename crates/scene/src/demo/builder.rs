//! What demos are built with.

use crate::framing::look_along;
use crate::{Material, Mesh, Node, Primitive, Scene};
use glam::Vec3;

/// A scene that code builds, piece by piece.
#[derive(Default)]
pub(super) struct Demo {
    pub(super) scene: Scene,
}

impl Demo {
    pub(super) fn material(&mut self, name: &str, color: [f32; 3], metallic: f32, roughness: f32) -> usize {
        self.scene.materials.push(Material {
            name: name.into(),
            base_color_factor: Vec3::from(color).extend(1.0),
            metallic_factor: metallic,
            roughness_factor: roughness,
            ..Material::default()
        });
        self.scene.materials.len() - 1
    }

    pub(super) fn mesh(&mut self, mut primitive: Primitive, material: usize) -> usize {
        primitive.material = Some(material);
        self.scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        self.scene.meshes.len() - 1
    }

    pub(super) fn put(&mut self, mesh: usize, translation: Vec3, scale: Vec3) {
        self.scene.add_node(None, Node { mesh: Some(mesh), translation, scale, ..Node::default() });
    }
}

/// A node that looks, or shines, from a place to another.
pub(super) fn pose(eye: Vec3, target: Vec3) -> Node {
    let rotation = look_along(target - eye, Vec3::Y).unwrap_or_default();
    Node { translation: eye, rotation, ..Node::default() }
}
