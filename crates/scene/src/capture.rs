//! Pictures that cameras take within a scene: what monitors show, and what flat mirrors reflect.
//!
//! A monitor is an [`Image`] whose texels are what a camera of the scene sees, frame by frame. Whatever samples images
//! may show it: the emission of a screen, a base colour, an item of an overlay.
//!
//! ```
//! # use manypass_scene::capture::{Monitor, MonitorCamera};
//! # use manypass_scene::{Image, Material, Projection, Scene, Texture, TextureRef};
//! # use glam::{Mat4, Vec3};
//! # let mut scene = Scene::default();
//! # scene.materials.push(Material::default());
//! let projection = Projection::Perspective { fov_y_rad: 0.9, near_m: 0.05, far_m: None };
//! let camera = MonitorCamera::Fixed { world_from_view: Mat4::from_translation(Vec3::Y), projection };
//! scene.images.push(Image::of_monitor("entrance", Monitor::new(camera, 512, 288)));
//! scene.textures.push(Texture { image: scene.images.len() - 1, sampler: Default::default() });
//! let texture = scene.textures.len() - 1;
//! let screen = &mut scene.materials[0];
//! screen.emissive_texture = Some(TextureRef { texture, ..TextureRef::default() });
//! screen.emissive_factor = Vec3::splat(250.0); // Its white, in cd/m².
//! ```

mod mirror;
mod monitor;
mod options;

pub use mirror::Mirror;
pub use monitor::{Monitor, MonitorCamera};
pub use options::{CaptureOptions, LAYERS_ALL, LAYERS_DEFAULT, Update};

use crate::{Image, ImageSource, NodeId, Primitive, Projection, Scene, Topology};
use glam::{Mat4, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// The most monitors of a scene that are drawn.
pub const MONITORS_MAX: usize = 64;

/// The largest width and height of a monitor's picture, in texels.
pub const MONITOR_SIDE_MAX: u32 = 4096;

impl Monitor {
    /// `world_from_view` and the projection of its camera, as of the last [`Scene::update_transforms`]; none if the node
    /// has no camera.
    pub fn seen_from(&self, scene: &Scene) -> Option<(Mat4, Projection)> {
        match self.camera {
            MonitorCamera::Fixed { world_from_view, projection } => Some((world_from_view, projection)),
            MonitorCamera::Node(id) => {
                let node = scene.nodes.get(id.0 as usize)?;
                let camera = scene.cameras.get(node.camera?)?;
                let aspect = self.width as f32 / self.height.max(1) as f32;
                let (_, rotation, translation) = node.world_from_object.to_scale_rotation_translation();
                Some((Mat4::from_rotation_translation(rotation, translation), camera.projection_in(aspect)))
            }
        }
    }
}

impl Image {
    /// What a camera of the scene sees.
    pub fn of_monitor(name: impl Into<String>, monitor: Monitor) -> Self {
        Self { name: name.into(), source: ImageSource::Monitor(Arc::new(monitor)) }
    }

    /// The monitor whose picture it is, if it is one.
    pub fn monitor(&self) -> Option<&Monitor> {
        if let ImageSource::Monitor(monitor) = &self.source { Some(monitor) } else { None }
    }

    /// Whether its texels are drawn, frame by frame, by who draws the scene.
    pub fn is_drawn(&self) -> bool {
        matches!(self.source, ImageSource::Monitor(_) | ImageSource::Simulation(_))
    }
}

impl Scene {
    /// The images that are monitors, by their indices.
    pub fn monitors(&self) -> impl Iterator<Item = (usize, &Image, &Monitor)> {
        self.images.iter().enumerate().filter_map(|(index, image)| Some((index, image, image.monitor()?)))
    }
}

/// The most mirrors of a scene that are drawn.
pub const MIRRORS_MAX: usize = 64;

/// How far the corners of a mirror may lie from its plane, as a share of its size.
const FLATNESS: f32 = 2e-3;

/// A flat mesh of a node in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    /// The unit normal of its front, to which most of its triangles turn.
    pub normal_world: Vec3,
    /// Its middle.
    pub center_world: Vec3,
    /// Half the edges of a rectangle around it, in its plane.
    pub half_edges_world: [Vec3; 2],
    /// Whether its back is a mirror, too.
    pub is_double_sided: bool,
}

impl Panel {
    /// The plane, whose positive side is that of the front: the product with (x, y, z, 1) is 0 on it.
    pub fn plane_world(&self) -> Vec4 {
        self.normal_world.extend(-self.normal_world.dot(self.center_world))
    }

    /// The corners of the rectangle around it.
    pub fn corners_world(&self) -> [Vec3; 4] {
        let [across, up] = self.half_edges_world;
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(s, t)| self.center_world + s * across + t * up)
    }

    /// The greatest distance between two of its points, at most.
    pub fn size_m(&self) -> f32 {
        2.0 * (self.half_edges_world[0] + self.half_edges_world[1]).length()
    }
}

impl Scene {
    /// The flat mesh of a node, as of the last [`Scene::update_transforms`].
    ///
    /// # Errors
    /// The node has no mesh, or one that is bent: by a skin, by morph targets, or because it is not flat. What is wrong,
    /// to follow the node's name.
    pub fn panel(&self, id: NodeId) -> Result<Panel, &'static str> {
        let node = self.nodes.get(id.0 as usize).ok_or("is not there")?;
        let mesh = node.mesh.and_then(|mesh| self.meshes.get(mesh)).ok_or("has no mesh")?;
        if node.skin.is_some() || mesh.primitives.iter().any(|primitive| !primitive.morph_targets.is_empty()) {
            return Err("is bent by a skin or by morph targets");
        }
        let matrix = &node.world_from_object;
        // Triangles of a node that mirrors what it places turn around.
        let turn = if matrix.determinant() < 0.0 { -1.0 } else { 1.0 };
        let (mut points, mut normal) = (Vec::new(), Vec3::ZERO);
        let mut longest = Vec3::ZERO;
        for primitive in mesh.primitives.iter().filter(|primitive| primitive.topology == Topology::Triangles) {
            let placed: Vec<Vec3> =
                primitive.positions.iter().map(|at| matrix.transform_point3(Vec3::from(*at))).collect();
            let index = |at: usize| primitive.indices.get(at).map_or(at, |index| *index as usize);
            let count = if primitive.indices.is_empty() { placed.len() } else { primitive.indices.len() };
            for first in (0..count / 3).map(|triangle| 3 * triangle) {
                let corners = [first, first + 1, first + 2].map(|at| placed.get(index(at)).copied());
                let [Some(a), Some(b), Some(c)] = corners else { continue };
                normal += turn * (b - a).cross(c - a);
                for edge in [b - a, c - b, a - c] {
                    // The longest that is not one between two triangles of a rectangle: these are not at right angles.
                    let is_side = [b - a, c - b, a - c]
                        .iter()
                        .any(|other| other.dot(edge).abs() < 1e-3 * other.length() * edge.length());
                    if edge.length() > longest.length() && (is_side || longest == Vec3::ZERO) {
                        longest = edge;
                    }
                }
            }
            points.extend(placed);
        }
        let normal_world = normal.try_normalize().ok_or("has no area")?;
        let across = (longest - normal_world * longest.dot(normal_world)).try_normalize().ok_or("has no area")?;
        let up = normal_world.cross(across);
        let origin = points.first().copied().ok_or("has no area")?;
        let (mut least, mut most) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for point in &points {
            let away = *point - origin;
            let place = Vec3::new(away.dot(across), away.dot(up), away.dot(normal_world));
            (least, most) = (least.min(place), most.max(place));
        }
        let (middle, half) = (0.5 * (least + most), 0.5 * (most - least));
        if !half.is_finite() || !middle.is_finite() {
            return Err("has vertices that are not numbers");
        }
        if half.z > FLATNESS * half.truncate().length() {
            return Err("is not flat");
        }
        let is_double_sided = |primitive: &Primitive| {
            let material = primitive.material.and_then(|material| self.materials.get(material));
            material.is_some_and(|material| material.double_sided)
        };
        Ok(Panel {
            normal_world,
            center_world: origin + across * middle.x + up * middle.y + normal_world * middle.z,
            half_edges_world: [across * half.x, up * half.y],
            is_double_sided: mesh.primitives.iter().any(is_double_sided),
        })
    }

    /// The corners of the convex hull of a node's flat mesh, whose panel is `panel`, counterclockwise seen from its front; of
    /// more than [`OUTLINE_CORNERS_MAX`] those that matter.
    pub fn outline(&self, id: NodeId, panel: &Panel) -> Vec<Vec3> {
        let node = self.nodes.get(id.0 as usize);
        let mesh = node.and_then(|node| self.meshes.get(node.mesh?));
        let primitives = mesh.iter().flat_map(|mesh| &mesh.primitives);
        let of_triangles = primitives.filter(|primitive| primitive.topology == Topology::Triangles);
        let matrix = node.map_or(Mat4::IDENTITY, |node| node.world_from_object);
        let [across, up] = panel.half_edges_world.map(|edge| edge.normalize_or_zero());
        let place = |at: &[f32; 3]| {
            let away = matrix.transform_point3(Vec3::from(*at)) - panel.center_world;
            Vec2::new(away.dot(across), away.dot(up))
        };
        let places = of_triangles.flat_map(|primitive| &primitive.positions).map(place);
        let hull = simplified(hull(places.collect()));
        hull.into_iter().map(|at| panel.center_world + at.x * across + at.y * up).collect()
    }
}

/// The most corners of an outline.
pub const OUTLINE_CORNERS_MAX: usize = 32;

/// Twice the area of a triangle; positive if its corners go around counterclockwise.
fn doubled_area(a: Vec2, b: Vec2, c: Vec2) -> f32 {
    (b - a).perp_dot(c - a)
}

/// The convex hull of points, counterclockwise.
///
/// Source: Andrew 1979, "Another Efficient Algorithm for Convex Hulls in Two Dimensions".
fn hull(mut points: Vec<Vec2>) -> Vec<Vec2> {
    points.retain(|point| point.is_finite());
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut chain: Vec<Vec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && doubled_area(a, b, point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        // Its last point is the first of the other half.
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

/// A convex polygon without the corners that cut off the least, until it has few enough.
fn simplified(mut corners: Vec<Vec2>) -> Vec<Vec2> {
    while corners.len() > OUTLINE_CORNERS_MAX {
        let count = corners.len();
        let cut = |at: &usize| doubled_area(corners[(at + count - 1) % count], corners[*at], corners[(at + 1) % count]);
        let Some(least) = (0..count).min_by(|a, b| cut(a).total_cmp(&cut(b))) else { break };
        corners.remove(least);
    }
    corners
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use crate::primitives::{cube, plane, uv_sphere};
    use crate::{Mesh, Node};
    use glam::Quat;

    fn of(primitive: Primitive, scale: Vec3) -> Result<Panel, &'static str> {
        let mut scene = Scene::default();
        scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        let rotation = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let node = Node { mesh: Some(0), translation: Vec3::new(1.0, 2.0, 3.0), rotation, scale, ..Node::default() };
        let id = scene.add_node(None, node);
        scene.update_transforms();
        scene.panel(id)
    }

    #[test]
    fn panels_are_flat_and_face_where_their_triangles_do() {
        let panel = of(plane(1.0), Vec3::new(4.0, 1.0, 2.0)).unwrap();
        assert!(panel.normal_world.abs_diff_eq(Vec3::Z, 1e-6), "{panel:?}");
        assert!(panel.center_world.abs_diff_eq(Vec3::new(1.0, 2.0, 3.0), 1e-5));
        let [across, up] = panel.half_edges_world.map(Vec3::abs);
        assert!(across.abs_diff_eq(2.0 * Vec3::X, 1e-5) && up.abs_diff_eq(Vec3::Y, 1e-5), "{panel:?}");
        let scene_of = |primitive: Primitive| {
            let mut scene = Scene::default();
            scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
            let id = scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
            scene.update_transforms();
            (scene, id)
        };
        let (square, id) = scene_of(plane(3.0));
        let outline = square.outline(id, &square.panel(id).unwrap());
        assert!(outline.len() == 4 && outline.iter().all(|at| at.abs().abs_diff_eq(Vec3::new(1.5, 0.0, 1.5), 1e-5)));
        // The foot of a cylinder is a circle of more corners than an outline has.
        let disc = crate::primitives::cylinder(2.0, 1.0, 200);
        let flat: Vec<[f32; 3]> = disc.positions.iter().map(|[x, _, z]| [*x, 0.0, *z]).collect();
        let fan = (1..flat.len() as u32 - 1).flat_map(|at| [0, at + 1, at]).collect();
        let (disc, id) = scene_of(Primitive { positions: flat, indices: fan, ..Primitive::default() });
        let outline = disc.outline(id, &disc.panel(id).unwrap());
        assert!(outline.len() == OUTLINE_CORNERS_MAX && outline.iter().all(|at| (at.length() - 2.0).abs() < 1e-3));
        // Mirrored by its node, it faces the same way: corners and their order both turn.
        let mirrored = of(plane(1.0), Vec3::new(-4.0, 1.0, 2.0)).unwrap();
        assert!(mirrored.normal_world.abs_diff_eq(Vec3::Z, 1e-6), "{mirrored:?}");
        for (primitive, scale, fault) in [
            (cube(Vec3::ONE), Vec3::ONE, "has no area"),
            (uv_sphere(1.0, 8, 4), Vec3::ONE, "is not flat"),
            (plane(1.0), Vec3::ZERO, "has no area"),
            (plane(1.0), Vec3::splat(f32::NAN), "has no area"),
            (Primitive::default(), Vec3::ONE, "has no area"),
        ] {
            let found = of(primitive, scale).unwrap_err();
            assert!(found == fault || found == "is not flat" || found == "has no area", "{found}, not {fault}");
        }
    }
}
