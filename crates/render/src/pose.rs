//! Where everything was in the previous frame, from which motion is computed.

use crate::draws::Deformation;
use crate::view::View;
use glam::Mat4;
use manypass_scene::{Node, Scene};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The camera and the transforms of a frame. The next frame has its motion vectors from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// From where it was seen.
    pub camera: View,
    nodes: Vec<NodePose>,
    /// `world_from_mesh` of every joint, by skin: nodes share them.
    skins: Vec<Vec<Mat4>>,
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
        let mesh = node.mesh.and_then(|mesh| scene.meshes.get(mesh));
        let default_weights = || mesh.map(|mesh| mesh.default_morph_weights.clone()).unwrap_or_default();
        Self {
            is_visible: node.is_visible,
            world_from_object: node.world_from_object,
            skin: node.skin.filter(|_| mesh.is_some()),
            weights: if node.morph_weights.is_empty() { default_weights() } else { node.morph_weights.clone() },
        }
    }
}

impl Pose {
    /// Captures `scene` as of its last `update_transforms`, seen from `camera`.
    pub fn capture(scene: &Scene, camera: View) -> Self {
        let nodes = scene.nodes.iter().map(|node| NodePose::of(scene, node)).collect();
        Self { camera, nodes, skins: (0..scene.skins.len()).map(|skin| scene.joint_matrices(skin)).collect() }
    }

    /// Whether it may be one of `scene`'s.
    pub(crate) fn is_of(&self, scene: &Scene) -> bool {
        self.nodes.len() == scene.nodes.len()
    }

    /// The table `previous_nodes` of `motion.wgsl`, four texels a node; joints and weights are appended to those of
    /// this frame. A node of `scene` that the pose does not know, or knows with other joints, counts as unmoved.
    pub(crate) fn append_to(&self, scene: &Scene, deformation: &mut Deformation) -> Vec<[f32; 4]> {
        let mut texels = Vec::with_capacity(4 * scene.nodes.len());
        let mut first_joints = BTreeMap::new();
        let count_before =
            |known: &NodePose| known.skin.and_then(|skin| self.skins.get(skin)).map_or(0, |joints| joints.len());
        for (index, node) in scene.nodes.iter().enumerate() {
            let current = NodePose::of(scene, node);
            let count = current.skin.and_then(|skin| scene.skins.get(skin)).map_or(0, |skin| skin.joints.len());
            let known = self.nodes.get(index).filter(|known| count_before(known) == count);
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
        deformation.joint_rows.extend(self.skins.get(skin).into_iter().flatten().flat_map(rows));
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
