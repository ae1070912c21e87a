//! Decals: pictures that a box throws onto the surfaces within it, such as cracks, stains, markings and leaves.
//!
//! ```
//! # use manypass_scene::Scene;
//! # use manypass_scene::decal::{Decal, DecalLook};
//! # use glam::Vec3;
//! # let mut scene = Scene::default();
//! let puddle = DecalLook { color: Vec3::splat(0.02), roughness: 0.05, ..DecalLook::default() };
//! let puddle = DecalLook { opacity: puddle.opacity.with_roughness(1.0), ..puddle };
//! let mut decal = Decal::new("puddle", puddle);
//! // One metre wide and long, on what lies within 0.5 m of the floor.
//! decal.place(Vec3::ZERO, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::ONE);
//! scene.decals.push(decal);
//! ```

mod picture;

pub use picture::{Decal, DecalLook, DecalOpacity};

use crate::{NodeId, Scene};
use glam::Mat4;
use std::collections::HashSet;

/// The most decals of a scene that are drawn.
pub const DECALS_MAX: usize = 4096;

impl Scene {
    /// `world_from_box` of every decal that is shown, as of the last [`Scene::update_transforms`], and its index: those
    /// of hidden nodes, and boxes without volume, are left out.
    pub fn shown_decals(&self) -> Vec<(usize, Mat4)> {
        let visible: HashSet<NodeId> = match self.decals.iter().any(|decal| decal.node.is_some()) {
            true => self.visible_nodes().into_iter().collect(),
            false => HashSet::new(),
        };
        let placed = |(index, decal): (usize, &Decal)| {
            let world_from_parent = match decal.node {
                Some(node) if !visible.contains(&node) => return None,
                Some(node) => self.nodes.get(node.0 as usize)?.world_from_object,
                None => Mat4::IDENTITY,
            };
            let world_from_box = world_from_parent * decal.parent_from_box;
            (!Decal::is_flat(&world_from_box)).then_some((index, world_from_box))
        };
        self.decals.iter().enumerate().filter_map(placed).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Node;
    use glam::Vec3;

    #[test]
    fn a_box_lies_where_it_is_put() {
        let mut decal = Decal::new("crack", DecalLook::default());
        decal.place(Vec3::new(1.0, 2.0, 3.0), Vec3::NEG_Y * 5.0, Vec3::NEG_Z, Vec3::new(4.0, 2.0, 0.5));
        let at = |x, y, z| decal.parent_from_box.transform_point3(Vec3::new(x, y, z));
        // The upper right corner of the picture, on the side from which it is thrown.
        assert!(at(0.5, 0.5, 0.5).abs_diff_eq(Vec3::new(3.0, 2.25, 2.0), 1e-6));
        // A direction along `up` has a picture, too.
        decal.place(Vec3::ZERO, Vec3::NEG_Y, Vec3::Y, Vec3::ONE);
        assert!((decal.parent_from_box.determinant() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn decals_go_with_their_node_and_flat_ones_are_left_out() {
        let mut scene = Scene::default();
        let node = scene.add_node(None, Node { translation: Vec3::X, ..Node::default() });
        let on = |node| Decal { node, ..Decal::new("a", DecalLook::default()) };
        let flat = |axis| Decal { parent_from_box: Mat4::from_scale(axis), ..on(None) };
        scene.decals = vec![on(Some(node)), flat(Vec3::new(1.0, 1.0, 0.0)), flat(Vec3::splat(f32::NAN)), on(None)];
        scene.decals.push(on(Some(NodeId(7))));
        scene.update_transforms();
        assert_eq!(scene.shown_decals(), [(0, Mat4::from_translation(Vec3::X)), (3, Mat4::IDENTITY)]);
        scene.node_mut(node).is_visible = false;
        assert_eq!(scene.shown_decals(), [(3, Mat4::IDENTITY)]);
    }
}
