//! What rays from one point meet: a cube of 16 × 16 rays a side, into which every triangle is drawn.

use crate::turns::{Turns, in_slices};
use crate::{AlphaMode, Node, NodeId, Primitive, Scene, Topology};
use glam::{Mat3, Vec2, Vec3, Vec3Swizzles};
use std::ops::Range;

/// Rays along an edge of the cube.
const SIDE: usize = 16;

/// What one ray meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// Of length 1.
    pub direction_world: Vec3,
    /// The solid angle that it stands for, in steradians.
    pub solid_angle_sr: f32,
    /// To the first surface; infinite where there is none.
    pub distance_m: f32,
    /// Whether the first surface faces the point.
    pub is_faced: bool,
    /// A vertex of the first surface: how many come before it among those of [`solids`].
    pub first_vertex: Option<usize>,
    /// To the last surface; 0 where there is none.
    pub last_m: f32,
    /// Whether the last surface shows its back to the point, as a solid's outside does.
    pub last_is_back: bool,
    /// A vertex of the last surface, counted as that of the first.
    pub last_vertex: Option<usize>,
}

/// All rays from one point.
pub(super) struct Panorama {
    rays: Vec<Ray>,
    /// The directions before they were brought to length 1: their largest component is 1.
    directions: Vec<Vec3>,
}

/// A triangle as a point sees it.
struct Triangle {
    /// Relative to the point.
    corners: [Vec3; 3],
    /// Six times the volume between it and the point; its sign is that of the winding.
    volume: f32,
    is_front: bool,
    /// One of its vertices, counted as [`Ray::first_vertex`].
    vertex: usize,
}

/// A corner of a triangle.
struct Corner {
    /// Relative to the point.
    place: Vec3,
    /// The side of the cube through which it is seen.
    face: usize,
    /// Which row of rays and which column come before it: a triangle between two of either meets none.
    after: [i32; 2],
}

impl Panorama {
    /// From `eye_world`, past blended and skinned surfaces.
    pub(super) async fn new(scene: &Scene, eye_world: Vec3, turns: &mut Turns<'_>) -> Self {
        let directions: Vec<Vec3> = (0..6 * SIDE * SIDE).map(direction).collect();
        let ray = |direction: &Vec3| Ray {
            direction_world: direction.normalize(),
            solid_angle_sr: (4.0 / (SIDE * SIDE) as f32) / direction.length().powi(3),
            distance_m: f32::INFINITY,
            is_faced: false,
            first_vertex: None,
            last_m: 0.0,
            last_is_back: false,
            last_vertex: None,
        };
        let mut panorama = Self { rays: directions.iter().map(ray).collect(), directions };
        let mut vertices_before = 0;
        for (id, primitive) in solids(scene) {
            let node = scene.node(id);
            panorama.draw_primitive((scene, node), primitive, eye_world, vertices_before, turns).await;
            vertices_before += primitive.positions.len();
        }
        panorama
    }

    pub(super) fn rays(&self) -> &[Ray] {
        &self.rays
    }

    async fn draw_primitive(
        &mut self,
        (scene, node): (&Scene, &Node),
        primitive: &Primitive,
        eye_world: Vec3,
        vertices_before: usize,
        turns: &mut Turns<'_>,
    ) {
        let world_from_object = node.world_from_object;
        let corner = |position: &[f32; 3]| {
            let place = world_from_object.transform_point3(Vec3::from(*position)) - eye_world;
            let face = main_face(place);
            let cell = cell(on_face(place, face));
            Corner { place, face, after: [cell.x as i32, cell.y as i32] }
        };
        let mut corners: Vec<Corner> = Vec::with_capacity(primitive.positions.len());
        let place = |range: Range<usize>| {
            let positions = primitive.positions.get(range).unwrap_or_default();
            corners.extend(positions.iter().map(corner));
        };
        in_slices(primitive.positions.len(), turns, place).await;
        let linear = Mat3::from_mat4(world_from_object);
        let is_mirrored = linear.determinant() < 0.0;
        let material = primitive.material.and_then(|material| scene.materials.get(material));
        // Both sides of such a surface are drawn; which one is meant to be seen, only its normals tell.
        let normals = if material.is_some_and(|material| material.double_sided) { &primitive.normals[..] } else { &[] };
        let world_from_normal = linear.inverse().transpose();
        let is_front = |[a, b, c]: [usize; 3], triangle: &[Vec3; 3], volume: f32| match (
            normals.get(a),
            normals.get(b),
            normals.get(c),
        ) {
            (Some(p), Some(q), Some(r)) => {
                let normal = world_from_normal * (Vec3::from(*p) + Vec3::from(*q) + Vec3::from(*r));
                normal.dot(triangle[0] + triangle[1] + triangle[2]) < 0.0
            }
            _ => (volume < 0.0) != is_mirrored,
        };
        let mut draw = |indices: [usize; 3]| {
            let [Some(a), Some(b), Some(c)] = indices.map(|index| corners.get(index)) else { return };
            let triangle = [a.place, b.place, c.place];
            let is_on_one_face = a.face == b.face && a.face == c.face;
            let is_between = |i: usize| a.after[i] == b.after[i] && a.after[i] == c.after[i];
            if is_on_one_face && (is_between(0) || is_between(1)) {
                return;
            }
            let volume = triangle[0].dot(triangle[1].cross(triangle[2]));
            let is_front = is_front(indices, &triangle, volume);
            let triangle = Triangle { corners: triangle, volume, is_front, vertex: vertices_before + indices[0] };
            let faces = if is_on_one_face { a.face..a.face + 1 } else { 0..6 };
            faces.for_each(|face| self.draw_on_face(&triangle, face));
        };
        let mut left = triangles(primitive);
        in_slices(left.len(), turns, |range| left.by_ref().take(range.len()).for_each(&mut draw)).await;
    }

    fn draw_on_face(&mut self, triangle: &Triangle, face: usize) {
        let corners = triangle.corners.map(|corner| on_face(corner, face));
        let all = |is_outside: fn(Vec3) -> bool| corners.into_iter().all(is_outside);
        if all(|p| p.x <= 0.0) || all(|p| p.y > p.x) || all(|p| p.y < -p.x) || all(|p| p.z > p.x) || all(|p| p.z < -p.x)
        {
            return;
        }
        let (columns, rows) = if corners.iter().all(|p| p.x > 0.0) {
            let cells = corners.map(cell);
            (between(cells.map(|cell| cell.x)), between(cells.map(|cell| cell.y)))
        } else {
            (0..SIDE, 0..SIDE)
        };
        let [a, b, c] = triangle.corners;
        let edges = [b.cross(c), c.cross(a), a.cross(b)];
        for row in rows {
            for column in columns.clone() {
                self.meet((face * SIDE + row) * SIDE + column, &edges, triangle);
            }
        }
    }

    /// A ray meets a triangle where it is a sum of the corners with no negative weight; those are triple products.
    fn meet(&mut self, index: usize, edges: &[Vec3; 3], triangle: &Triangle) {
        let Triangle { volume, is_front, vertex, .. } = *triangle;
        let (Some(ray), Some(direction)) = (self.rays.get_mut(index), self.directions.get(index)) else { return };
        let weights = edges.map(|edge| direction.dot(edge) * volume.signum());
        let sum = weights[0] + weights[1] + weights[2];
        if weights.iter().any(|weight| *weight < 0.0) || sum <= 0.0 || volume == 0.0 {
            return;
        }
        let distance_m = volume.abs() / sum * direction.length();
        if distance_m < ray.distance_m {
            (ray.distance_m, ray.is_faced, ray.first_vertex) = (distance_m, is_front, Some(vertex));
        }
        if distance_m > ray.last_m && distance_m.is_finite() {
            (ray.last_m, ray.last_is_back, ray.last_vertex) = (distance_m, !is_front, Some(vertex));
        }
    }
}

/// What can be a wall: the primitives of visible nodes that are neither blended nor skinned.
pub(super) fn solids(scene: &Scene) -> impl Iterator<Item = (NodeId, &Primitive)> {
    let of_node = move |id: NodeId| {
        let node = scene.node(id);
        let mesh = node.mesh.and_then(|mesh| scene.meshes.get(mesh));
        let primitives = mesh.into_iter().flat_map(|mesh| &mesh.primitives);
        primitives.filter(move |primitive| is_solid(scene, node, primitive)).map(move |primitive| (id, primitive))
    };
    scene.visible_nodes().into_iter().flat_map(of_node)
}

/// The vertices of each triangle.
pub(super) fn triangles(primitive: &Primitive) -> impl ExactSizeIterator<Item = [usize; 3]> {
    let count = if primitive.indices.is_empty() { primitive.positions.len() } else { primitive.indices.len() };
    (0..count / 3).map(move |i| {
        [3 * i, 3 * i + 1, 3 * i + 2]
            .map(|corner| primitive.indices.get(corner).map_or(corner, |index| *index as usize))
    })
}

/// Whether a primitive can be a wall.
fn is_solid(scene: &Scene, node: &Node, primitive: &Primitive) -> bool {
    let material = primitive.material.and_then(|material| scene.materials.get(material));
    let is_blended = material.is_some_and(|material| material.alpha_mode == AlphaMode::Blend);
    let is_skinned = node.skin.is_some() && !primitive.joints.is_empty();
    primitive.topology == Topology::Triangles && !is_blended && !is_skinned
}

/// The side of the cube through which a direction goes: +X, −X, +Y, −Y, +Z, −Z.
fn main_face(direction: Vec3) -> usize {
    let axis = direction.abs().max_position();
    2 * axis + usize::from(direction[axis] < 0.0)
}

/// Along the outward axis of a side of the cube, and along its edges.
fn on_face(direction: Vec3, face: usize) -> Vec3 {
    let Vec3 { x, y, z } = direction;
    let along = match face / 2 {
        0 => Vec3::new(x, y, z),
        1 => Vec3::new(y, z, x),
        _ => Vec3::new(z, x, y),
    };
    if face.is_multiple_of(2) { along } else { along * Vec3::new(-1.0, 1.0, 1.0) }
}

/// Where on a side of the cube a direction goes through it: from 0.5, whole numbers are the rays, which begin with 1.
fn cell(on_face: Vec3) -> Vec2 {
    (on_face.yz() / on_face.x + 1.0) * (0.5 * SIDE as f32) + 0.5
}

/// The rays between the outermost of three places.
fn between(places: [f32; 3]) -> Range<usize> {
    let [a, b, c] = places;
    let first_after = |place: f32| place.clamp(0.0, SIDE as f32) as usize;
    // A ray at the very place counts: the exact test follows.
    first_after(a.min(b).min(c) - 1.0)..first_after(a.max(b).max(c) + 0.001)
}

/// The direction of a ray, its largest component of length 1.
fn direction(index: usize) -> Vec3 {
    let (face, row, column) = (index / (SIDE * SIDE), index / SIDE % SIDE, index % SIDE);
    let middle = |cell: usize| (2.0 * cell as f32 + 1.0) / SIDE as f32 - 1.0;
    let (u, v) = (middle(column), middle(row));
    let outward = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    match face / 2 {
        0 => Vec3::new(outward, u, v),
        1 => Vec3::new(v, outward, u),
        _ => Vec3::new(u, v, outward),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_go_through_their_side_and_fill_the_sphere() {
        let mut sum = 0.0;
        for index in 0..6 * SIDE * SIDE {
            let direction = direction(index);
            assert_eq!(main_face(direction), index / (SIDE * SIDE));
            let on_face = on_face(direction, index / (SIDE * SIDE));
            let cell = |place: f32| ((place + 1.0) * 0.5 * SIDE as f32) as usize;
            assert_eq!((on_face.x, cell(on_face.z), cell(on_face.y)), (1.0, index / SIDE % SIDE, index % SIDE));
            sum += (4.0 / (SIDE * SIDE) as f32) / direction.length().powi(3);
        }
        assert!((sum - 4.0 * std::f32::consts::PI).abs() < 0.02, "{sum}");
    }
}
