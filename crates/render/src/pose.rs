//! Where everything was in the previous frame, from which motion is computed.

use crate::draws::Deformation;
use crate::view::View;
use glam::Mat4;
use manypass_scene::{Node, Scene};
use std::sync::Arc;

/// A posed scene as one camera saw it, kept while the scene moves on.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// From where it was seen.
    pub camera: View,
    nodes: Vec<NodePose>,
}

#[derive(Clone, Debug, PartialEq)]
struct NodePose {
    is_visible: bool,
    world_from_object: Mat4,
    /// `world_from_mesh` of every joint; empty without a skin.
    joints: Vec<Mat4>,
    /// Of every morph target; empty without any.
    weights: Vec<f32>,
}

impl NodePose {
    fn of(scene: &Scene, node: &Node) -> Self {
        let mesh = node.mesh.and_then(|mesh| scene.meshes.get(mesh));
        let default_weights = || mesh.map(|mesh| mesh.default_morph_weights.clone()).unwrap_or_default();
        // A node that draws nothing needs no tables of its own.
        let skin = node.skin.filter(|_| mesh.is_some());
        Self {
            is_visible: node.is_visible,
            world_from_object: node.world_from_object,
            joints: skin.map(|skin| scene.joint_matrices(skin)).unwrap_or_default(),
            weights: if node.morph_weights.is_empty() { default_weights() } else { node.morph_weights.clone() },
        }
    }
}

impl Pose {
    /// Captures `scene` as of its last `update_transforms`, seen from `camera`.
    pub fn capture(scene: &Scene, camera: View) -> Self {
        Self { camera, nodes: scene.nodes.iter().map(|node| NodePose::of(scene, node)).collect() }
    }

    /// Whether it may be one of `scene`'s.
    pub(crate) fn is_of(&self, scene: &Scene) -> bool {
        self.nodes.len() == scene.nodes.len()
    }

    /// The table `previous_nodes` of `motion.wgsl`, four texels a node; joints and weights are appended to those of
    /// this frame. A node of `scene` that the pose does not know, or knows with other joints, counts as unmoved.
    pub(crate) fn append_to(&self, scene: &Scene, deformation: &mut Deformation) -> Vec<[f32; 4]> {
        let mut texels = Vec::with_capacity(4 * scene.nodes.len());
        for (index, node) in scene.nodes.iter().enumerate() {
            let current = NodePose::of(scene, node);
            let known = self.nodes.get(index).filter(|known| known.joints.len() == current.joints.len());
            let pose = known.unwrap_or(&current);
            texels.extend(rows(&pose.world_from_object));
            // Floats count exactly up to 2²⁴, which is more than any texture has rows for.
            let first_joint = (deformation.joint_rows.len() / 3) as f32;
            let first_weight = deformation.morph_weights.len() as f32;
            deformation.joint_rows.extend(pose.joints.iter().flat_map(rows));
            deformation.morph_weights.extend_from_slice(&pose.weights);
            // A mesh may have more targets than the file has weights for.
            let targets = node.mesh.and_then(|mesh| scene.meshes.get(mesh)).map_or(0, most_morph_targets);
            let missing = targets.saturating_sub(pose.weights.len());
            deformation.morph_weights.extend(std::iter::repeat_n(0.0, missing));
            texels.push([first_joint, first_weight, 0.0, 0.0]);
        }
        texels
    }
}

fn most_morph_targets(mesh: &Arc<manypass_scene::Mesh>) -> usize {
    mesh.primitives.iter().map(|primitive| primitive.morph_targets.len()).max().unwrap_or(0)
}

fn rows(matrix: &Mat4) -> [[f32; 4]; 3] {
    [0, 1, 2].map(|row| matrix.row(row).to_array())
}
