//! The arena of nodes.

use crate::{Aabb, Animation, Camera, Image, Light, Material, Mesh, Skin, Texture};
use glam::{Mat4, Quat, Vec3};

/// A node's place in [`Scene::nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// A place in the scene, and what is there.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The name in the file; empty if it has none.
    pub name: String,
    /// The parent; none for a root.
    pub parent: Option<NodeId>,
    /// The children.
    pub children: Vec<NodeId>,
    /// Translation from the parent, in metres.
    pub translation: Vec3,
    /// Rotation from the parent.
    pub rotation: Quat,
    /// Scale from the parent.
    pub scale: Vec3,
    /// A matrix that stands in for translation, rotation and scale where a file gives one that does not decompose.
    pub matrix: Option<Mat4>,
    /// Index into [`Scene::meshes`].
    pub mesh: Option<usize>,
    /// Index into [`Scene::skins`].
    pub skin: Option<usize>,
    /// Index into [`Scene::cameras`].
    pub camera: Option<usize>,
    /// Index into [`Scene::lights`].
    pub light: Option<usize>,
    /// The weights of the mesh's morph targets; empty means the mesh's own.
    pub morph_weights: Vec<f32>,
    /// `world_from_object`, as of the last [`Scene::update_transforms`].
    pub world_from_object: Mat4,
}

impl Default for Node {
    fn default() -> Self {
        Self {
            name: String::new(),
            parent: None,
            children: Vec::new(),
            translation: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            scale: Vec3::ONE,
            matrix: None,
            mesh: None,
            skin: None,
            camera: None,
            light: None,
            morph_weights: Vec::new(),
            world_from_object: Mat4::IDENTITY,
        }
    }
}

impl Node {
    /// `parent_from_object`.
    pub fn local_matrix(&self) -> Mat4 {
        self.matrix
            .unwrap_or_else(|| Mat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation))
    }
}

/// Everything that can be drawn.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// All nodes; only those reachable from `roots` are drawn.
    pub nodes: Vec<Node>,
    /// The nodes without a parent that are drawn.
    pub roots: Vec<NodeId>,
    /// Geometry.
    pub meshes: Vec<Mesh>,
    /// Surfaces.
    pub materials: Vec<Material>,
    /// Images with samplers.
    pub textures: Vec<Texture>,
    /// Images.
    pub images: Vec<Image>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// Skins.
    pub skins: Vec<Skin>,
    /// Animations.
    pub animations: Vec<Animation>,
}

impl Scene {
    /// The node at `id`.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// The node at `id`, to change.
    pub fn node_mut(&mut self, id: NodeId) -> &mut Node {
        &mut self.nodes[id.0 as usize]
    }

    /// Adds `node` below `parent`, or as a root.
    pub fn add_node(&mut self, parent: Option<NodeId>, mut node: Node) -> NodeId {
        let id = NodeId(self.nodes.len() as u32);
        node.parent = parent;
        self.nodes.push(node);
        match parent {
            Some(parent) => self.node_mut(parent).children.push(id),
            None => self.roots.push(id),
        }
        id
    }

    /// Every node reachable from the roots, parents before children.
    pub fn visible_nodes(&self) -> Vec<NodeId> {
        let mut order = self.roots.clone();
        let mut next = 0;
        while next < order.len() {
            order.extend_from_slice(&self.node(order[next]).children);
            next += 1;
        }
        order
    }

    /// Recomputes `world_from_object` of every node that is drawn.
    pub fn update_transforms(&mut self) {
        for id in self.visible_nodes() {
            let parent = self.node(id).parent.map_or(Mat4::IDENTITY, |parent| self.node(parent).world_from_object);
            let node = self.node_mut(id);
            node.world_from_object = parent * node.local_matrix();
        }
    }

    /// The box around everything that is drawn, in world space, as of the last [`Scene::update_transforms`].
    pub fn bounds_world(&self) -> Aabb {
        self.visible_nodes().into_iter().fold(Aabb::EMPTY, |bounds, id| {
            let node = self.node(id);
            let Some(mesh) = node.mesh.and_then(|mesh| self.meshes.get(mesh)) else { return bounds };
            mesh.primitives
                .iter()
                .fold(bounds, |bounds, primitive| bounds.union(&primitive.bounds.transformed(&node.world_from_object)))
        })
    }
}
