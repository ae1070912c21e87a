//! Adding to a scene and changing what is in it, by ids and by names.

use crate::{Camera, Light, Material, Mesh, Node, NodeId, Primitive, Projection, Scene};
use std::sync::Arc;

impl From<Primitive> for Mesh {
    /// A mesh without a name that draws one primitive.
    fn from(primitive: Primitive) -> Self {
        Self { primitives: vec![primitive], ..Self::default() }
    }
}

impl Scene {
    /// Adds a mesh, or a primitive as a mesh of its own. Gives its index, for [`Node::mesh`].
    ///
    /// ```
    /// use manypass_scene::{Material, Node, Primitive, Scene, primitives};
    ///
    /// let mut scene = Scene::default();
    /// let red = scene.add_material(Material { base_color_factor: [0.8, 0.1, 0.1, 1.0].into(), ..Default::default() });
    /// let ball = scene.add_mesh(Primitive { material: Some(red), ..primitives::uv_sphere(0.5, 32, 16) });
    /// let left = scene.add_node(None, Node { mesh: Some(ball), ..Default::default() });
    /// scene.node_mut(left).translation.x = -1.0;
    /// scene.materials[red].roughness_factor = 0.2;
    /// ```
    pub fn add_mesh(&mut self, mesh: impl Into<Mesh>) -> usize {
        self.meshes.push(Arc::new(mesh.into()));
        self.meshes.len() - 1
    }

    /// Adds a material. Gives its index, for [`Primitive::material`].
    pub fn add_material(&mut self, material: Material) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds a light, and `node` as a root that holds it. The node's place and rotation are the light's: it shines along
    /// the node's −Z.
    ///
    /// ```
    /// use manypass_scene::{Light, Node, Scene};
    ///
    /// let mut scene = Scene::default();
    /// let lamp = scene.add_light(Light::default(), Node { translation: [0.0, 2.0, 0.0].into(), ..Default::default() });
    /// scene.node_mut(lamp).translation.y = 3.0;
    /// scene.light_mut(lamp).expect("the node has a light").intensity = 40.0;
    /// ```
    pub fn add_light(&mut self, light: Light, node: Node) -> NodeId {
        self.lights.push(light);
        self.add_node(None, Node { light: Some(self.lights.len() - 1), ..node })
    }

    /// Adds a camera, and `node` as a root that holds it. The camera looks along the node's −Z, with its +Y up. The first
    /// camera of a scene is the one that pictures are drawn from where nobody says.
    pub fn add_camera(&mut self, projection: Projection, node: Node) -> NodeId {
        self.cameras.push(Camera { name: node.name.clone(), projection, aspect: None });
        self.add_node(None, Node { camera: Some(self.cameras.len() - 1), ..node })
    }

    /// The light that the node `id` holds, if it holds one.
    pub fn light(&self, id: NodeId) -> Option<&Light> {
        self.lights.get(self.nodes.get(id.0 as usize)?.light?)
    }

    /// The light that the node `id` holds, to change. Nodes that share a light all change.
    pub fn light_mut(&mut self, id: NodeId) -> Option<&mut Light> {
        self.lights.get_mut(self.nodes.get(id.0 as usize)?.light?)
    }

    /// The mesh of the node `id`, to change. Nodes that share a mesh all change. Where another scene, or whoever draws
    /// this one, holds the mesh too, this copies it first.
    pub fn mesh_mut(&mut self, id: NodeId) -> Option<&mut Mesh> {
        self.meshes.get_mut(self.nodes.get(id.0 as usize)?.mesh?).map(Arc::make_mut)
    }

    /// The first node of this name, hidden ones too.
    ///
    /// ```
    /// # use manypass_scene::{Light, Node, Scene};
    /// # let mut scene = Scene::default();
    /// # scene.add_light(Light::default(), Node { name: "Lamp".into(), ..Default::default() });
    /// if let Some(light) = scene.node_named("Lamp").and_then(|id| scene.light_mut(id)) {
    ///     light.intensity *= 2.0;
    /// }
    /// # assert_eq!(scene.lights[0].intensity, 2.0);
    /// ```
    pub fn node_named(&self, name: &str) -> Option<NodeId> {
        self.nodes.iter().position(|node| node.name == name).map(|index| NodeId(index as u32))
    }

    /// The index of the first material of this name.
    pub fn material_named(&self, name: &str) -> Option<usize> {
        self.materials.iter().position(|material| material.name == name)
    }

    /// The indices of the materials of the mesh of the node `id`, each once, in the order of its primitives.
    pub fn materials_of(&self, id: NodeId) -> Vec<usize> {
        let mesh = self.nodes.get(id.0 as usize).and_then(|node| self.meshes.get(node.mesh?));
        let mut materials: Vec<usize> = Vec::new();
        for material in mesh.iter().flat_map(|mesh| &mesh.primitives).filter_map(|primitive| primitive.material) {
            if !materials.contains(&material) {
                materials.push(material);
            }
        }
        materials
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives;
    use glam::Vec3;

    fn scene() -> (Scene, NodeId, NodeId) {
        let mut scene = Scene::default();
        let [red, blue] =
            ["red", "blue"].map(|name| scene.add_material(Material { name: name.into(), ..Material::default() }));
        let of = |material: usize| Primitive { material: Some(material), ..primitives::cube(Vec3::ONE) };
        let mesh = scene.add_mesh(Mesh { primitives: vec![of(blue), of(red), of(blue)], ..Mesh::default() });
        let boxes = scene.add_node(None, Node { name: "boxes".into(), mesh: Some(mesh), ..Node::default() });
        let lamp = scene.add_light(Light::default(), Node { name: "lamp".into(), ..Node::default() });
        (scene, boxes, lamp)
    }

    #[test]
    fn what_is_added_is_found_by_name() {
        let (scene, boxes, lamp) = scene();
        assert_eq!((scene.node_named("boxes"), scene.node_named("lamp")), (Some(boxes), Some(lamp)));
        assert_eq!((scene.node_named("door"), scene.material_named("green")), (None, None));
        assert_eq!(scene.materials_of(boxes), [1, 0]);
        assert_eq!(scene.material_named("blue"), Some(1));
        assert!(scene.materials_of(lamp).is_empty());
        assert_eq!(scene.roots, [boxes, lamp]);
    }

    #[test]
    fn a_scene_is_seen_through_its_first_camera() {
        let (mut scene, ..) = scene();
        assert_eq!(scene.first_camera(1.0), None);
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        let id = scene.add_camera(projection, Node { translation: Vec3::Z, ..Node::default() });
        scene.update_transforms();
        assert_eq!(scene.first_camera(1.0), Some((scene.node(id).world_from_object, projection)));
    }

    #[test]
    fn what_is_changed_by_the_node_is_changed_in_the_scene() {
        let (mut scene, boxes, lamp) = scene();
        let before = scene.meshes[0].clone();
        scene.light_mut(lamp).unwrap().intensity = 7.0;
        scene.mesh_mut(boxes).unwrap().primitives.truncate(1);
        assert_eq!(scene.lights[0].intensity, 7.0);
        assert_eq!(scene.light(lamp), Some(&scene.lights[0]));
        // Whoever holds the mesh as it was keeps it.
        assert_eq!((scene.meshes[0].primitives.len(), before.primitives.len()), (1, 3));
        assert!(scene.light_mut(boxes).is_none() && scene.mesh_mut(lamp).is_none());
        assert!(scene.light(NodeId(99)).is_none() && scene.mesh_mut(NodeId(99)).is_none());
    }
}
