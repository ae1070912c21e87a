//! Surfaces as a camera of the scene sees them, which particles meet, and which leave trails.

use crate::{NodeId, Projection, Scene, Topology};
use glam::{Mat4, Vec2, Vec3};

/// Texels along a side.
pub const SIDE: u32 = 256;

/// The nearest surfaces that a camera sees.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenSurfaces {
    /// The camera's space from the world's.
    pub view_from_world: Mat4,
    /// Half the width and height of what it sees, in metres: with parallel rays; else in a distance of 1 m.
    pub half: Vec2,
    /// Whether its rays are parallel.
    pub is_orthographic: bool,
    /// Of [`SIDE`] rows of texels from the top the unit normal in world space and the distance along the camera's axis
    /// in metres, which is infinite where there is nothing.
    pub texels: Vec<[f32; 4]>,
}

impl Scene {
    /// The nearest surfaces in some layers that the camera of a node sees in a square picture, as the animation that was
    /// last posed has them at a time. Skins and morph targets are left out. None if the node has no camera.
    pub fn surfaces_seen(&self, camera: NodeId, layers: u32, time_secs: f32) -> Option<SeenSurfaces> {
        let projection = self.cameras.get(self.nodes.get(camera.0 as usize)?.camera?)?.projection;
        let (half, near_m, is_orthographic) = match projection {
            Projection::Perspective { fov_y_rad, near_m, .. } => (Vec2::splat((0.5 * fov_y_rad).tan()), near_m, false),
            Projection::Orthographic { height_m, near_m, .. } => (Vec2::splat(0.5 * height_m), near_m, true),
        };
        let view_from_world = self.path_of(camera).world_from_object(time_secs).inverse();
        if !view_from_world.is_finite() || !half.is_finite() || half.min_element() <= 0.0 {
            return None;
        }
        let texels = vec![[0.0, 1.0, 0.0, f32::INFINITY]; (SIDE * SIDE) as usize];
        let mut seen = SeenSurfaces { view_from_world, half, is_orthographic, texels };
        for id in self.visible_nodes() {
            let node = self.node(id);
            let Some(mesh) = node.mesh.and_then(|mesh| self.meshes.get(mesh)).filter(|_| node.skin.is_none()) else {
                continue;
            };
            if node.layers & layers == 0 {
                continue;
            }
            let world_from_mesh = self.path_of(id).world_from_object(time_secs);
            for primitive in mesh.primitives.iter().filter(|primitive| primitive.topology == Topology::Triangles) {
                let point = |at: usize| {
                    let index = primitive.indices.get(at).map_or(at, |index| *index as usize);
                    primitive.positions.get(index).map(|at| world_from_mesh.transform_point3(Vec3::from(*at)))
                };
                let count =
                    if primitive.indices.is_empty() { primitive.positions.len() } else { primitive.indices.len() };
                for first in (0..count / 3).map(|triangle| 3 * triangle) {
                    if let (Some(a), Some(b), Some(c)) = (point(first), point(first + 1), point(first + 2)) {
                        seen.add([a, b, c], near_m);
                    }
                }
            }
        }
        Some(seen)
    }
}

impl SeenSurfaces {
    /// Draws a triangle of world space. What reaches behind the near plane is left out.
    fn add(&mut self, triangle: [Vec3; 3], near_m: f32) {
        let Some(mut normal) = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).try_normalize() else {
            return;
        };
        let views = triangle.map(|at| self.view_from_world.transform_point3(at));
        if views.iter().any(|view| !view.is_finite() || -view.z < near_m) {
            return;
        }
        // Both sides are met.
        let towards = self.view_from_world.transform_vector3(normal);
        let outwards = if self.is_orthographic { towards.z } else { -towards.dot(views[0]) };
        if outwards < 0.0 {
            normal = -normal;
        }
        let side = SIDE as f32;
        let scale = |view: Vec3| if self.is_orthographic { 1.0 } else { -1.0 / view.z };
        let corner = |view: Vec3| {
            let ndc = view.truncate() * scale(view) / self.half;
            (0.5 + 0.5 * ndc * Vec2::new(1.0, -1.0)) * side
        };
        let [a, b, c] = views.map(corner);
        // What is linear over the picture: the distance, or in perspective one divided by it.
        let linear = views.map(|view| if self.is_orthographic { -view.z } else { -1.0 / view.z });
        let area = (b - a).perp_dot(c - a);
        if !area.is_finite() || area == 0.0 {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f32, high: f32| {
            (low - 0.5).ceil().clamp(0.0, side) as u32..((high - 0.5).floor() + 1.0).clamp(0.0, side) as u32
        };
        for y in range(low.y, high.y) {
            for x in range(low.x, high.x) {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let shares =
                    [(c - b).perp_dot(at - b) / area, (a - c).perp_dot(at - c) / area, (b - a).perp_dot(at - a) / area];
                if shares.iter().any(|share| *share < 0.0) {
                    continue;
                }
                let value: f32 = shares.iter().zip(linear).map(|(share, linear)| share * linear).sum();
                let distance_m = if self.is_orthographic { value } else { value.recip() };
                if let Some(texel) = self.texels.get_mut((y * SIDE + x) as usize).filter(|texel| distance_m < texel[3])
                {
                    *texel = [normal.x, normal.y, normal.z, distance_m];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::framing::look_along;
    use crate::primitives::{cube, plane};
    use crate::{Camera, Mesh, Node};

    #[test]
    fn a_camera_from_above_sees_a_box_on_a_floor() {
        let mut scene = Scene::default();
        scene.meshes.push(Mesh { primitives: vec![plane(4.0)], ..Mesh::default() }.into());
        scene.meshes.push(Mesh { primitives: vec![cube(Vec3::ONE)], ..Mesh::default() }.into());
        scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
        let thing = Node { mesh: Some(1), translation: Vec3::new(0.5, 0.5, -0.5), ..Node::default() };
        scene.add_node(None, thing);
        let rotation = look_along(Vec3::NEG_Y, Vec3::NEG_Z).expect("a direction");
        for projection in [
            Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 10.0 },
            Projection::Perspective { fov_y_rad: 2.0 * 0.4f32.atan(), near_m: 0.1, far_m: None },
        ] {
            scene.cameras = vec![Camera { name: String::new(), projection, aspect: None }];
            let eye = Node { camera: Some(0), translation: 5.0 * Vec3::Y, rotation, ..Node::default() };
            let camera = scene.add_node(None, eye);
            scene.update_transforms();
            let seen = scene.surfaces_seen(camera, u32::MAX, 0.0).expect("a camera");
            // Up in the picture is -Z, to the right +X.
            let at =
                |x: f32, y: f32| seen.texels[((y * SIDE as f32) as u32 * SIDE + (x * SIDE as f32) as u32) as usize];
            for (texel, distance_m) in [(at(0.62, 0.38), 4.0), (at(0.3, 0.3), 5.0), (at(0.3, 0.7), 5.0)] {
                assert!((texel[3] - distance_m).abs() < 1e-4 && texel[1] > 0.999, "{texel:?} {distance_m}");
            }
            scene.remove_node(camera);
        }
        assert_eq!(scene.surfaces_seen(NodeId(0), u32::MAX, 0.0), None);
    }
}
