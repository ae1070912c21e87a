//! Where everything was in the previous frame, from which motion is computed.

mod deformation;

pub(crate) use deformation::{Deformation, Joints};

use crate::view::View;
use glam::Mat4;
use manypass_scene::{Node, Scene};
use std::collections::BTreeMap;
use std::sync::Arc;

/// So many nodes are kept together: what of them is as it was is shared by poses.
const CHUNK_NODES: usize = 256;

/// The camera and the transforms of a frame. The next frame has its motion vectors from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// From where it was seen.
    pub camera: View,
    scene: Arc<ScenePose>,
}

/// Where everything was.
#[derive(Debug)]
struct ScenePose {
    /// That of the scene's nodes.
    version: u64,
    node_count: usize,
    /// By [`CHUNK_NODES`].
    chunks: Vec<Arc<[NodePose]>>,
    /// `world_from_mesh` of every joint, by skin: nodes share them.
    skins: Vec<Vec<Mat4>>,
}

impl PartialEq for ScenePose {
    fn eq(&self, other: &Self) -> bool {
        let are_same = |(a, b): (&Arc<[NodePose]>, &Arc<[NodePose]>)| Arc::ptr_eq(a, b) || a == b;
        std::ptr::eq(self, other)
            || self.node_count == other.node_count
                && self.chunks.iter().zip(&other.chunks).all(are_same)
                && self.skins == other.skins
    }
}

#[derive(Clone, Debug, PartialEq)]
struct NodePose {
    is_visible: bool,
    world_from_object: Mat4,
    /// Of what is drawn.
    skin: Option<usize>,
    /// Of every morph target; empty without any.
    weights: Vec<f32>,
}

impl NodePose {
    fn of(scene: &Scene, node: &Node) -> Self {
        let weights = weights_of(scene, node).to_vec();
        Self {
            is_visible: node.is_visible,
            world_from_object: node.world_from_object,
            skin: skin_of(scene, node),
            weights,
        }
    }

    fn is_of(&self, scene: &Scene, node: &Node) -> bool {
        self.is_visible == node.is_visible
            && self.world_from_object == node.world_from_object
            && self.skin == skin_of(scene, node)
            && self.weights == weights_of(scene, node)
    }
}

fn skin_of(scene: &Scene, node: &Node) -> Option<usize> {
    let has_mesh = node.mesh.is_some_and(|mesh| mesh < scene.meshes.len());
    node.skin.filter(|_| has_mesh)
}

fn weights_of<'s>(scene: &'s Scene, node: &'s Node) -> &'s [f32] {
    let mesh = node.mesh.and_then(|mesh| scene.meshes.get(mesh));
    let default_weights = mesh.map_or(&[][..], |mesh| &mesh.default_morph_weights);
    if node.morph_weights.is_empty() { default_weights } else { &node.morph_weights }
}

impl Pose {
    /// Captures `scene` as of its last `update_transforms`, seen from `camera`.
    pub fn capture(scene: &Scene, camera: View) -> Self {
        Self::capture_after(scene, camera, None)
    }

    /// As [`Self::capture`]. It shares with `before` what has not moved since.
    pub(crate) fn capture_after(scene: &Scene, camera: View, before: Option<&Self>) -> Self {
        let before = before.map(|before| &before.scene);
        let version = scene.nodes.version();
        // Skins may be others though no node is.
        if let Some(same) = before.filter(|before| before.version == version && scene.skins.is_empty()) {
            return Self { camera, scene: same.clone() };
        }
        let chunk_of = |(at, nodes): (usize, &[Node])| {
            let is_same = |known: &&Arc<[NodePose]>| {
                known.len() == nodes.len() && known.iter().zip(nodes).all(|(known, node)| known.is_of(scene, node))
            };
            let known = before.and_then(|before| before.chunks.get(at)).filter(is_same);
            known.cloned().unwrap_or_else(|| nodes.iter().map(|node| NodePose::of(scene, node)).collect())
        };
        let chunks = scene.nodes.chunks(CHUNK_NODES).enumerate().map(chunk_of).collect();
        let skins = (0..scene.skins.len()).map(|skin| scene.joint_matrices(skin)).collect();
        Self { camera, scene: Arc::new(ScenePose { version, node_count: scene.nodes.len(), chunks, skins }) }
    }

    /// Whether it may be one of `scene`'s.
    pub(crate) fn is_of(&self, scene: &Scene) -> bool {
        self.scene.node_count == scene.nodes.len()
    }

    /// The version of the nodes that it was captured of.
    pub(crate) fn nodes_version(&self) -> u64 {
        self.scene.version
    }

    fn node(&self, index: usize) -> Option<&NodePose> {
        self.scene.chunks.get(index / CHUNK_NODES)?.get(index % CHUNK_NODES)
    }

    /// The table `previous_nodes` of `motion.wgsl`, four texels a node; joints and weights are appended to those of
    /// this frame. A node of `scene` that the pose does not know, or knows with other joints, counts as unmoved.
    pub(crate) fn append_to(&self, scene: &Scene, deformation: &mut Deformation) -> Vec<[f32; 4]> {
        let mut texels = Vec::with_capacity(4 * scene.nodes.len());
        let mut first_joints = BTreeMap::new();
        let count_before =
            |known: &NodePose| known.skin.and_then(|skin| self.scene.skins.get(skin)).map_or(0, |joints| joints.len());
        for (index, node) in scene.nodes.iter().enumerate() {
            let current = NodePose::of(scene, node);
            let count = current.skin.and_then(|skin| scene.skins.get(skin)).map_or(0, |skin| skin.joints.len());
            let known = self.node(index).filter(|known| count_before(known) == count);
            let pose = known.unwrap_or(&current);
            texels.extend(rows(&pose.world_from_object));
            let first_joint = match (known, pose.skin) {
                (_, None) => 0,
                (Some(_), Some(skin)) => {
                    *first_joints.entry(skin).or_insert_with(|| self.append_joints(skin, deformation))
                }
                (None, Some(skin)) => deformation.first_joint(scene, skin),
            };
            // Floats count exactly up to 2²⁴, which is more than any texture has rows for.
            let first_joint = first_joint as f32;
            let first_weight = deformation.morph_weights.len() as f32;
            deformation.morph_weights.extend_from_slice(&pose.weights);
            // A mesh may have more targets than the file has weights for.
            let targets = node.mesh.and_then(|mesh| scene.meshes.get(mesh)).map_or(0, most_morph_targets);
            let missing = targets.saturating_sub(pose.weights.len());
            deformation.morph_weights.extend(std::iter::repeat_n(0.0, missing));
            texels.push([first_joint, first_weight, 0.0, 0.0]);
        }
        texels
    }

    /// Appends the joints of a skin, and gives the place of the first.
    fn append_joints(&self, skin: usize, deformation: &mut Deformation) -> u32 {
        let first = (deformation.joint_rows.len() / 3) as u32;
        deformation.joint_rows.extend(self.scene.skins.get(skin).into_iter().flatten().flat_map(rows));
        first
    }
}

fn most_morph_targets(mesh: &Arc<manypass_scene::Mesh>) -> usize {
    mesh.primitives.iter().map(|primitive| primitive.morph_targets.len()).max().unwrap_or(0)
}

fn rows(matrix: &Mat4) -> [[f32; 4]; 3] {
    [0, 1, 2].map(|row| matrix.row(row).to_array())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use manypass_scene::{Mesh, Projection, Skin};

    #[test]
    fn what_has_not_moved_is_shared() {
        let mut scene = Scene { meshes: vec![Mesh::default().into()], ..Scene::default() };
        let nodes = (0..CHUNK_NODES + 3).map(|_| scene.add_node(None, Node { mesh: Some(0), ..Node::default() }));
        let nodes: Vec<_> = nodes.collect();
        scene.update_transforms();
        let projection = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None };
        let camera = View { world_from_view: Mat4::IDENTITY, projection };
        let before = Pose::capture(&scene, camera);
        let still = Pose::capture_after(&scene, camera, Some(&before));
        assert!(Arc::ptr_eq(&before.scene, &still.scene) && still == before);
        scene.node_mut(nodes[CHUNK_NODES]).translation = Vec3::X;
        scene.update_transforms();
        let moved = Pose::capture_after(&scene, camera, Some(&before));
        let shared = before.scene.chunks.iter().zip(&moved.scene.chunks).map(|(a, b)| Arc::ptr_eq(a, b));
        assert_eq!((shared.collect::<Vec<_>>(), moved == before), (vec![true, false], false));
        assert_eq!(moved, Pose::capture(&scene, camera));
    }

    #[test]
    fn nodes_of_one_skin_share_its_joints() {
        const COUNT: usize = 50;
        let mut scene = Scene { meshes: vec![Mesh::default().into()], ..Scene::default() };
        let skinned = || Node { mesh: Some(0), skin: Some(0), ..Node::default() };
        let joints = (0..COUNT).map(|_| scene.add_node(None, skinned())).collect();
        scene.skins.push(Skin { joints, ..Skin::default() });
        scene.update_transforms();
        let projection = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None };
        let before = Pose::capture(&scene, View { world_from_view: Mat4::IDENTITY, projection });
        for node in &mut scene.nodes {
            node.translation = Vec3::X;
        }
        scene.update_transforms();
        let mut deformation = Deformation::default();
        let now = deformation.first_joint(&scene, 0);
        assert_eq!((now, deformation.first_joint(&scene, 0)), (0, 0));
        let texels = before.append_to(&scene, &mut deformation);
        // Once as they are, and once as they were.
        assert_eq!(deformation.joint_rows.len(), 2 * 3 * COUNT);
        let x_of = |joint: usize| deformation.joint_rows[3 * joint][3];
        assert_eq!([0, COUNT - 1, COUNT, 2 * COUNT - 1].map(x_of), [1.0, 1.0, 0.0, 0.0]);
        let places: Vec<f32> = texels.chunks_exact(4).map(|node| node[3][0]).collect();
        assert_eq!(places, [COUNT as f32; COUNT]);
        // Of another number of joints nothing is known: they count as unmoved.
        scene.skins[0].joints.pop();
        let mut deformation = Deformation::default();
        let texels = before.append_to(&scene, &mut deformation);
        assert_eq!(deformation.joint_rows.len(), 3 * (COUNT - 1));
        assert!(texels.chunks_exact(4).all(|node| node[3][0] == 0.0));
    }
}
