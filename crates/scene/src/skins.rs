//! What nodes that share a skin share of a pose: a file may have thousands of both.

use crate::{Aabb, Scene};
use glam::Mat4;
use std::collections::BTreeMap;

/// Skins as of the transforms of a scene, while these stay.
#[derive(Debug, Default)]
pub(crate) struct PosedSkins {
    /// [`Scene::joint_matrices`] by skin.
    matrices: BTreeMap<usize, Vec<Mat4>>,
    /// By skin, mesh and primitive.
    bounds: BTreeMap<(usize, usize, usize), Aabb>,
}

impl PosedSkins {
    /// A box in world space around all that the joints of a skin make of a box of a mesh.
    pub fn bounds(&mut self, skin: usize, local: &Aabb, scene: &Scene) -> Aabb {
        let matrices = self.matrices.entry(skin).or_insert_with(|| scene.joint_matrices(skin));
        let boxes = matrices.iter().map(|world_from_mesh| local.transformed(world_from_mesh));
        boxes.fold(Aabb::EMPTY, |bounds, posed| bounds.union(&posed))
    }

    /// The same of a primitive that has one box whatever the node: of a skin, a mesh and a place in the mesh.
    pub fn bounds_of(&mut self, of: (usize, usize, usize), local: &Aabb, scene: &Scene) -> Aabb {
        if let Some(known) = self.bounds.get(&of) {
            return *known;
        }
        let bounds = self.bounds(of.0, local, scene);
        self.bounds.insert(of, bounds);
        bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mesh, MorphTarget, Node, Primitive, Skin};
    use glam::Vec3;
    use std::sync::Arc;

    #[test]
    fn nodes_of_one_skin_have_boxes_of_their_own() {
        let box_of = |size: f32| Aabb { min: Vec3::ZERO, max: Vec3::splat(size) };
        let skinned = |size: f32| Primitive { joints: vec![[0; 4]], bounds: box_of(size), ..Primitive::default() };
        let target = MorphTarget { positions: vec![[0.0, 0.0, 5.0]], ..MorphTarget::default() };
        let morphed = Primitive { morph_targets: vec![target], ..skinned(1.0) };
        let rigid = Primitive { bounds: box_of(1.0), ..Primitive::default() };
        let meshes = [vec![skinned(1.0)], vec![skinned(2.0)], vec![morphed], vec![skinned(1.0), rigid]];
        let mesh = |primitives: Vec<Primitive>| Arc::new(Mesh { primitives, ..Mesh::default() });
        let mut scene = Scene { meshes: meshes.map(mesh).into(), ..Scene::default() };
        let joints = [3.0, 4.0].map(|x| {
            let translation = Vec3::X * x;
            scene.add_node(None, Node { translation, ..Node::default() })
        });
        scene.skins.push(Skin { joints: joints.to_vec(), ..Skin::default() });
        // Of a mesh twice, and of each of the others; the node's own place counts for what is rigid alone.
        let nodes = [(0, 0.0), (0, 0.0), (1, 0.0), (2, 0.0), (2, 1.0), (3, 0.0)].map(|(mesh, weight)| {
            let (translation, morph_weights) = (Vec3::Y * 9.0, vec![weight]);
            let node = Node { mesh: Some(mesh), skin: Some(0), translation, morph_weights, ..Node::default() };
            scene.add_node(None, node)
        });
        scene.update_transforms();
        let bounds = |scene: &Scene| nodes.map(|id| (scene.node(id).bounds_world.min, scene.node(id).bounds_world.max));
        let from = Vec3::X * 3.0;
        let expected = [
            (from, Vec3::new(5.0, 1.0, 1.0)),
            (from, Vec3::new(5.0, 1.0, 1.0)),
            (from, Vec3::new(6.0, 2.0, 2.0)),
            (from, Vec3::new(5.0, 1.0, 1.0)),
            (from, Vec3::new(5.0, 1.0, 6.0)),
            (Vec3::ZERO, Vec3::new(5.0, 10.0, 1.0)),
        ];
        assert_eq!(bounds(&scene), expected);
        // All of them follow a joint.
        scene.node_mut(joints[0]).translation = Vec3::X * -1.0;
        scene.update_transforms();
        let expected = expected.map(|(min, max)| (Vec3::new(-1.0, min.y, min.z), max));
        assert_eq!(bounds(&scene), expected);
    }
}
