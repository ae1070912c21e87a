//! Portals: two flat places that lead into each other.
//!
//! ```
//! # use manypass_scene::portal::Portal;
//! # use manypass_scene::{Mesh, Node, Scene, primitives::plane};
//! # use glam::{Quat, Vec3};
//! # use std::f32::consts::FRAC_PI_2;
//! # let mut scene = Scene::default();
//! # scene.meshes.push(Mesh { primitives: vec![plane(1.0)], ..Mesh::default() }.into());
//! let rotation = Quat::from_rotation_x(FRAC_PI_2); // The plane faces +Z.
//! let mut door = |z: f32| {
//!     scene.add_node(None, Node { mesh: Some(0), rotation, translation: Vec3::new(0.0, 1.0, z), ..Node::default() })
//! };
//! let ends = [door(0.0), door(-20.0)];
//! let ball = scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
//! scene.add_portal(Portal::new("door", ends), &[ball]);
//! ```

mod ends;

pub use ends::{Portal, PortalTraveller};

use crate::capture::Panel;
use crate::framing::look_along;
use crate::{Node, NodeId, Scene};
use glam::{Mat4, Quat, Vec3};
use std::f32::consts::PI;

/// The most portals of a scene that are drawn.
pub const PORTALS_MAX: usize = 16;

/// The frame of a flat place: x to the right and y up as one looks at its front, z out of it.
fn frame(panel: &Panel) -> Mat4 {
    let rotation = look_along(-panel.normal_world, Vec3::Y).unwrap_or_default();
    Mat4::from_rotation_translation(rotation, panel.center_world)
}

/// From what goes into the front of one flat place to what comes out of the front of another.
pub fn through(from: &Panel, to: &Panel) -> Mat4 {
    frame(to) * Mat4::from_quat(Quat::from_rotation_y(PI)) * frame(from).inverse()
}

impl Scene {
    /// Adds a portal that nodes, with all below them, go through: meshes without a skin, and lights. A mesh that is half
    /// through is drawn at both ends; a light whose range reaches an end shines out of the other one, as if it stood as far
    /// behind that.
    pub fn add_portal(&mut self, mut portal: Portal, carried: &[NodeId]) {
        let mut all: Vec<NodeId> = Vec::new();
        for id in carried.iter().filter(|id| (id.0 as usize) < self.nodes.len()) {
            if !all.contains(id) {
                all.push(*id);
            }
        }
        let mut next = 0;
        while next < all.len() {
            let inner: Vec<NodeId> = self.node(all[next]).children.clone();
            all.extend(inner.into_iter().filter(|id| !all.contains(id)).collect::<Vec<_>>());
            next += 1;
        }
        for id in all {
            let node = self.node(id);
            if node.mesh.is_none() && node.light.is_none() || node.skin.is_some() {
                continue;
            }
            let image = Node {
                parent: None,
                children: Vec::new(),
                camera: None,
                levels: None,
                is_visible: false,
                name: format!("{} ({})", node.name, portal.name),
                ..node.clone()
            };
            for end in 0..2 {
                let image = self.add_node(None, image.clone());
                self.scenes.iter_mut().for_each(|roots| roots.roots.push(image));
                portal.carried.push(PortalTraveller { node: id, image, end });
            }
        }
        self.portals.push(portal);
        self.update_transforms();
    }

    /// Puts what stands for nodes that are half through portals where it is to be. Says whether anything changed.
    pub(crate) fn carry_through_portals(&mut self) -> bool {
        if self.portals.iter().all(|portal| portal.carried.is_empty()) {
            return false;
        }
        let visible = self.visible_nodes();
        let mut changes = Vec::new();
        for portal in &self.portals {
            let panels = portal.nodes.map(|id| self.panel(id).ok());
            for PortalTraveller { node, image, end } in &portal.carried {
                let (Some(from), Some(to)) = (panels[*end], panels[1 - *end]) else { continue };
                let is_there = visible.contains(node) && self.goes_into(*node, &from);
                let matrix = through(&from, &to) * self.node(*node).world_from_object;
                let known = self.node(*image);
                if known.is_visible != is_there || is_there && known.matrix != Some(matrix) {
                    changes.push((*image, is_there, matrix));
                }
            }
        }
        for (image, is_there, matrix) in &changes {
            let node = self.node_mut(*image);
            (node.is_visible, node.matrix) = (*is_there, Some(*matrix));
        }
        !changes.is_empty()
    }

    /// Whether a node's mesh crosses a flat place, or its light reaches the front of it.
    fn goes_into(&self, id: NodeId, panel: &Panel) -> bool {
        let node = self.node(id);
        let place = |at: Vec3| {
            let away = at - panel.center_world;
            let [across, up] = panel.half_edges_world;
            let share = |edge: Vec3| away.dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE);
            Vec3::new(share(across), share(up), away.dot(panel.normal_world))
        };
        let crosses = node.mesh.is_some() && !node.bounds_world.is_empty() && {
            let corners = node.bounds_world.corners().map(place);
            let least = corners.into_iter().fold(Vec3::INFINITY, Vec3::min);
            let most = corners.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max);
            least.z < 0.0 && most.z > 0.0 && least.x < 1.0 && most.x > -1.0 && least.y < 1.0 && most.y > -1.0
        };
        let light = node.light.and_then(|light| self.lights.get(light));
        let shines = light.is_some_and(|light| {
            let at = node.world_from_object.w_axis.truncate();
            let near = place(at);
            let [across, up] = panel.half_edges_world;
            let nearest = panel.center_world + across * near.x.clamp(-1.0, 1.0) + up * near.y.clamp(-1.0, 1.0);
            near.z > 0.0 && light.range_m.is_none_or(|range_m| at.distance(nearest) < range_m)
        });
        crosses || shines
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use crate::primitives::{cube, plane};
    use crate::{Light, Mesh};

    /// Two doors of 2 by 2 metres, at the origin and 10 m to the right, which faces right; and a cube.
    fn doors() -> (Scene, NodeId) {
        let mut scene = Scene::default();
        scene.meshes.push(Mesh { primitives: vec![plane(2.0)], ..Mesh::default() }.into());
        scene.meshes.push(Mesh { primitives: vec![cube(Vec3::splat(0.5))], ..Mesh::default() }.into());
        let mut door = |facing: Vec3, translation: Vec3| {
            let rotation = look_along(-facing, Vec3::Y).unwrap() * Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
            scene.add_node(None, Node { mesh: Some(0), translation, rotation, ..Node::default() })
        };
        let ends = [door(Vec3::Z, Vec3::ZERO), door(Vec3::X, 10.0 * Vec3::X)];
        let body = scene.add_node(None, Node { mesh: Some(1), translation: Vec3::Z, ..Node::default() });
        scene.add_portal(Portal::new("door", ends), &[body, NodeId(1000)]);
        (scene, body)
    }

    #[test]
    fn what_goes_into_a_front_comes_out_of_the_other() {
        let (scene, _) = doors();
        let [from, to] = scene.portals[0].nodes.map(|id| scene.panel(id).unwrap());
        let matrix = through(&from, &to);
        // A step before the one is a step behind the other, and what is to the right stays so as one walks on.
        for (at, expected) in [
            (Vec3::ZERO, Vec3::new(10.0, 0.0, 0.0)),
            (Vec3::Z, Vec3::new(9.0, 0.0, 0.0)),
            (Vec3::new(0.5, 1.0, -1.0), Vec3::new(11.0, 1.0, 0.5)),
        ] {
            assert!(matrix.transform_point3(at).abs_diff_eq(expected, 1e-5), "{}", matrix.transform_point3(at));
        }
        assert!((through(&to, &from) * matrix).abs_diff_eq(Mat4::IDENTITY, 1e-5));
    }

    #[test]
    fn what_is_half_through_is_at_both_ends() {
        let (mut scene, body) = doors();
        let visible = |scene: &Scene| {
            scene.portals[0].carried.iter().filter(|carried| scene.node(carried.image).is_visible).count()
        };
        assert_eq!((scene.portals[0].carried.len(), visible(&scene)), (2, 0));
        scene.node_mut(body).translation = Vec3::new(0.2, 0.0, 0.1);
        scene.update_transforms();
        assert_eq!(visible(&scene), 1);
        let image = scene.node(scene.portals[0].carried[0].image);
        assert!(image.world_from_object.w_axis.truncate().abs_diff_eq(Vec3::new(9.9, 0.0, 0.2), 1e-5));
        assert!(image.bounds_world.center().abs_diff_eq(Vec3::new(9.9, 0.0, 0.2), 1e-5));
        assert_eq!(scene.update_transforms(), 0);
        // Beside the door it goes nowhere.
        scene.node_mut(body).translation = Vec3::new(4.0, 0.0, 0.1);
        scene.update_transforms();
        assert_eq!(visible(&scene), 0);
        // Light goes through where it is before a door, and reaches it.
        scene.lights.push(Light { range_m: Some(3.0), ..Light::default() });
        scene.node_mut(body).light = Some(0);
        let (mut lit, portal) = (scene.clone(), scene.portals[0].clone());
        lit.portals.clear();
        lit.add_portal(Portal { carried: Vec::new(), ..portal }, &[body]);
        for (translation, count) in [(Vec3::new(0.0, 0.0, 2.5), 1), (Vec3::new(0.0, 0.0, 3.5), 0), (Vec3::NEG_Z, 0)] {
            lit.node_mut(body).translation = translation;
            lit.update_transforms();
            assert_eq!(visible(&lit), count, "{translation}");
        }
    }
}
