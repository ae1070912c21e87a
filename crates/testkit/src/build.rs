//! Scenes put together by hand, of triangles alone; [`crate::raycast::World::of_scene`] shows them to the ray caster.

use glam::{Mat3, Quat, Vec3};
use manypass_scene::{Camera, Light, Material, Mesh, Node, NodeId, Primitive, Projection, Scene};

/// A scene that grows.
#[derive(Clone, Debug, Default)]
pub struct SceneBuilder {
    /// What is there already.
    pub scene: Scene,
}

/// The rotation of a node whose −Z points along `forward`, which need not have length 1.
pub fn rotation_along(forward: Vec3) -> Quat {
    let forward = forward.normalize();
    let right = forward.cross(if forward.y.abs() > 0.99 { Vec3::NEG_Z } else { Vec3::Y }).normalize();
    Quat::from_mat3(&Mat3::from_cols(right, right.cross(forward), -forward)).normalize()
}

/// A rough dielectric of a grey colour.
pub fn grey(albedo: f32) -> Material {
    Material { base_color_factor: Vec3::splat(albedo).extend(1.0), metallic_factor: 0.0, ..Material::default() }
}

impl SceneBuilder {
    /// Nothing but a camera at `eye_world` that looks at `target_world`.
    pub fn new(eye_world: Vec3, target_world: Vec3, projection: Projection) -> Self {
        let mut builder = Self::default();
        builder.scene.cameras.push(Camera { name: "camera".into(), projection, aspect: None });
        let rotation = rotation_along(target_world - eye_world);
        builder.scene.add_node(None, Node { translation: eye_world, rotation, camera: Some(0), ..Node::default() });
        builder
    }

    /// Adds a node that draws `primitive`.
    pub fn put(&mut self, mut primitive: Primitive, material: Material, node: Node) -> NodeId {
        primitive.material = Some(self.scene.materials.len());
        self.scene.materials.push(material);
        let mesh = Some(self.scene.meshes.len());
        self.scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        self.scene.add_node(None, Node { mesh, ..node })
    }

    /// Adds a node that gives light.
    pub fn light(&mut self, light: Light, translation: Vec3, direction: Vec3) -> NodeId {
        self.scene.lights.push(light);
        let light = Some(self.scene.lights.len() - 1);
        self.scene.add_node(None, Node { translation, rotation: rotation_along(direction), light, ..Node::default() })
    }

    /// The scene, with transforms up to date.
    pub fn finish(mut self) -> Scene {
        self.scene.update_transforms();
        self.scene
    }
}

/// A node at a place.
pub fn at(translation: Vec3) -> Node {
    Node { translation, ..Node::default() }
}
