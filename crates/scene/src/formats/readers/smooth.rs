//! Normals for meshes that have none: faces that meet at less than a crease share theirs.

use super::two_sided::backs;
use super::vertex_corners::corners_by_vertex;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Two faces whose normals differ by at most this angle are one smooth surface. The thousandth keeps cylinders of
/// twelve sides smooth whatever rounding does to them.
const CREASE_DEG: f64 = 30.001;

/// The most faces at one edge that a face is compared with. Two are usual; more are broken or made to be slow.
const COMPARED_AT_AN_EDGE: usize = 8;

/// Whether a face is one smooth surface with its neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Smoothing {
    /// With those that it meets at less than a crease.
    #[default]
    ByAngle,
    /// With none.
    Flat,
    /// With those of the same number, however they meet.
    Group(u32),
    /// The same, for faces that are the backs of others.
    BackOfGroup(u32),
}

/// A mesh whose vertices were split where normals differ.
#[derive(Debug, Default)]
pub(super) struct SmoothMesh {
    /// Which of the former vertices each vertex is.
    pub(super) source: Vec<u32>,
    /// A unit vector each.
    pub(super) normals: Vec<[f32; 3]>,
    /// Three for each face, in its order.
    pub(super) indices: Vec<u32>,
}

/// Splits the vertices of a list of triangles at creases. The normal of a vertex is the mean of those of its faces,
/// weighted by their angles there (Thürmer & Wüthrich 1998). Backs of other faces ([`super::two_sided`]) are smoothed
/// apart from fronts, because their normals would cancel each other out. Vertices at one place must be one vertex.
/// `smoothing` is that of a face; indices must be below the number of positions.
pub(super) fn smooth(positions: &[[f32; 3]], indices: &[u32], smoothing: impl Fn(usize) -> Smoothing) -> SmoothMesh {
    let position = |vertex: u32| Vec3::from(at(positions, vertex as usize)).as_dvec3();
    let normals: Vec<Vec3> = indices
        .chunks_exact(3)
        .map(|face| match *face {
            [a, b, c] => {
                let a = position(a);
                (position(b) - a).cross(position(c) - a).normalize_or_zero().as_vec3()
            }
            _ => Vec3::ZERO,
        })
        .collect();
    let mut is_back = vec![false; normals.len()];
    for (back, _) in backs(normals.len(), |face| indices.get(3 * face..3 * face + 3).unwrap_or_default()) {
        if let Some(slot) = is_back.get_mut(back) {
            *slot = true;
        }
    }
    let cosine = CREASE_DEG.to_radians().cos() as f32;
    let are_joined = |a: usize, b: usize| match (smoothing(a), smoothing(b)) {
        _ if at(&is_back, a) != at(&is_back, b) => false,
        (Smoothing::ByAngle, Smoothing::ByAngle) => at(&normals, a).dot(at(&normals, b)) >= cosine,
        (Smoothing::Group(a), Smoothing::Group(b)) | (Smoothing::BackOfGroup(a), Smoothing::BackOfGroup(b)) => a == b,
        _ => false,
    };
    let (starts, order) = corners_by_vertex(positions.len(), indices);
    let mut smoothed = SmoothMesh { indices: vec![0; indices.len()], ..SmoothMesh::default() };
    let mut around = CornerFan::default();
    for (vertex, range) in starts.windows(2).enumerate() {
        let corners = match *range {
            [start, end] => order.get(start as usize..end as usize).unwrap_or_default(),
            _ => &[],
        };
        around.join(corners, indices, are_joined);
        around.add_vertices(vertex as u32, corners, &mut smoothed, |corner| {
            let normal = at(&normals, corner as usize / 3).as_dvec3();
            let [next, last] = [1, 2].map(|step| position(at(indices, neighbour(corner, step))));
            let here = position(vertex as u32);
            let angle_rad = (next - here).angle_between(last - here);
            if angle_rad.is_finite() { normal * angle_rad } else { DVec3::ZERO }
        });
    }
    smoothed
}

/// Places without their copies, and which of them each position is at: many programs write one vertex for every face.
pub(super) fn weld(positions: impl Iterator<Item = [f32; 3]>) -> (Vec<[f32; 3]>, Vec<u32>) {
    let (mut places, mut known) = (Vec::new(), HashMap::new());
    let place = |position: [f32; 3]| {
        // Both zeros are one place.
        *known.entry(position.map(|value| (value + 0.0).to_bits())).or_insert_with(|| {
            places.push(position);
            places.len() as u32 - 1
        })
    };
    let of_positions = positions.map(place).collect();
    (places, of_positions)
}

fn at<T: Copy + Default>(values: &[T], index: usize) -> T {
    values.get(index).copied().unwrap_or_default()
}

/// The corner of the same face that comes `step` later.
fn neighbour(corner: u32, step: u32) -> usize {
    (corner - corner % 3 + (corner % 3 + step) % 3) as usize
}

/// The corners at one vertex, joined where their faces are; kept for its memory.
#[derive(Debug, Default)]
struct CornerFan {
    /// The vertex at the other end of an edge, and the place of a corner whose face has it.
    edges: Vec<(u32, u32)>,
    /// For every corner one that it is joined with, or itself.
    joined: Vec<u32>,
    sums: Vec<DVec3>,
    vertex_of: Vec<u32>,
}

impl CornerFan {
    fn root(&mut self, mut place: u32) -> u32 {
        loop {
            let next = at(&self.joined, place as usize);
            if next == place {
                return place;
            }
            let after = at(&self.joined, next as usize);
            if let Some(slot) = self.joined.get_mut(place as usize) {
                *slot = after;
            }
            place = after;
        }
    }

    fn join(&mut self, corners: &[u32], indices: &[u32], are_joined: impl Fn(usize, usize) -> bool) {
        self.joined.clear();
        self.joined.extend(0..corners.len() as u32);
        self.edges.clear();
        for (place, &corner) in corners.iter().enumerate() {
            self.edges.extend([1, 2].map(|step| (at(indices, neighbour(corner, step)), place as u32)));
        }
        self.edges.sort_unstable();
        let face = |place: u32| at(corners, place as usize) as usize / 3;
        for i in 1..self.edges.len() {
            let (end, place) = at(&self.edges, i);
            for j in (i.saturating_sub(COMPARED_AT_AN_EDGE)..i).rev() {
                let (other_end, other) = at(&self.edges, j);
                if other_end != end {
                    break;
                }
                if are_joined(face(place), face(other)) {
                    let (a, b) = (self.root(place), self.root(other));
                    if let Some(slot) = self.joined.get_mut(a.max(b) as usize) {
                        *slot = a.min(b);
                    }
                }
            }
        }
    }

    /// Adds a vertex for each set of joined corners.
    fn add_vertices(&mut self, vertex: u32, corners: &[u32], to: &mut SmoothMesh, weighted: impl Fn(u32) -> DVec3) {
        self.sums.clear();
        self.sums.resize(corners.len(), DVec3::ZERO);
        self.vertex_of.clear();
        self.vertex_of.resize(corners.len(), u32::MAX);
        for (place, &corner) in corners.iter().enumerate() {
            let root = self.root(place as u32) as usize;
            if let Some(sum) = self.sums.get_mut(root) {
                *sum += weighted(corner);
            }
        }
        for (place, &corner) in corners.iter().enumerate() {
            let root = self.root(place as u32) as usize;
            let Some(new) = self.vertex_of.get_mut(root) else { continue };
            if *new == u32::MAX {
                *new = to.source.len() as u32;
                to.source.push(vertex);
                to.normals.push(at(&self.sums, root).normalize_or(DVec3::Y).as_vec3().to_array());
            }
            if let Some(slot) = to.indices.get_mut(corner as usize) {
                *slot = *new;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A procedural shape with one vertex at each place.
    fn welded(primitive: &crate::Primitive) -> (Vec<[f32; 3]>, Vec<u32>) {
        let (mut positions, mut places) = (Vec::new(), HashMap::new());
        let place = |&i: &u32| {
            let position = primitive.positions[i as usize];
            *places.entry(position.map(|v| (v * 1e5).round() as i32)).or_insert_with(|| {
                positions.push(position);
                positions.len() as u32 - 1
            })
        };
        let indices = primitive.indices.iter().map(place).collect();
        (positions, indices)
    }

    #[test]
    fn cubes_keep_their_edges_and_spheres_lose_theirs() {
        let (positions, indices) = welded(&crate::primitives::cube(Vec3::ONE));
        assert_eq!(positions.len(), 8);
        let cube = smooth(&positions, &indices, |_| Smoothing::ByAngle);
        assert_eq!((cube.source.len(), cube.indices.len()), (24, 36));
        assert!(cube.normals.iter().all(|&n| Vec3::from(n).abs().max_element() == 1.0), "{:?}", cube.normals);

        let (positions, indices) = welded(&crate::primitives::uv_sphere(2.0, 24, 12));
        let sphere = smooth(&positions, &indices, |_| Smoothing::ByAngle);
        assert_eq!(sphere.source.len(), positions.len());
        for (&source, &normal) in sphere.source.iter().zip(&sphere.normals) {
            let expected = Vec3::from(positions[source as usize]).normalize();
            assert!(expected.dot(Vec3::from(normal)) > 0.9995, "{expected} {normal:?}");
        }
        assert_eq!(smooth(&positions, &indices, |_| Smoothing::Flat).source.len(), indices.len());
        let (positions, indices) = welded(&crate::primitives::cube(Vec3::ONE));
        assert_eq!(smooth(&positions, &indices, |_| Smoothing::Group(7)).source.len(), 8);
        // The first four triangles are sides that do not meet.
        let pair = |face: usize| Smoothing::Group(face as u32 / 4);
        assert_eq!(smooth(&positions, &indices, pair).source.len(), 24);
    }

    #[test]
    fn the_normal_of_a_cubes_corner_does_not_depend_on_diagonals() {
        let (positions, indices) = welded(&crate::primitives::cube(Vec3::ONE));
        let cube = smooth(&positions, &indices, |_| Smoothing::Group(1));
        for (&source, &normal) in cube.source.iter().zip(&cube.normals) {
            let expected = Vec3::from(positions[source as usize]).normalize();
            assert!(expected.abs_diff_eq(normal.into(), 1e-6), "{expected} {normal:?}");
        }
    }

    #[test]
    fn fronts_have_the_normals_that_they_have_alone_and_backs_the_opposite_ones() {
        let (positions, indices) = welded(&crate::primitives::cube(Vec3::ONE));
        let doubled = |face: &[u32]| [face[0], face[1], face[2], face[2], face[1], face[0]];
        let pairs: Vec<u32> = indices.chunks(3).flat_map(doubled).collect();
        for smoothing in [Smoothing::ByAngle, Smoothing::Group(1)] {
            let (alone, both) =
                (smooth(&positions, &indices, |_| smoothing), smooth(&positions, &pairs, |_| smoothing));
            let normal = |of: &SmoothMesh, corner: usize| Vec3::from(of.normals[of.indices[corner] as usize]);
            for corner in 0..indices.len() {
                let (face, place) = (corner / 3, corner % 3);
                let expected = normal(&alone, corner);
                assert!(normal(&both, 6 * face + place).abs_diff_eq(expected, 1e-6), "{smoothing:?} {corner}");
                assert!(normal(&both, 6 * face + 5 - place).abs_diff_eq(-expected, 1e-6), "{smoothing:?} {corner}");
            }
        }
        // A cone over a drop, whose sides meet at 19° at most, but for a fold. There fronts meet backs at 17°.
        let on_arc = |i: u16| {
            let (sin, cos) = (83.0 + 19.4 * f32::from(i)).to_radians().sin_cos();
            [0.25 * cos, 0.25 * sin, 0.0]
        };
        let tips = [[0.0, 0.0, 3.0], [2.0, 0.0, 0.0]];
        let positions: Vec<[f32; 3]> = tips.into_iter().chain((0..11).map(on_arc)).collect();
        let indices: Vec<u32> = (0..12).flat_map(|i| [0, 1 + i, 1 + (i + 1) % 12]).collect();
        let pairs: Vec<u32> = indices.chunks(3).flat_map(doubled).collect();
        let count = |indices: &[u32]| smooth(&positions, indices, |_| Smoothing::ByAngle).source.len();
        assert_eq!(count(&pairs), 2 * count(&indices));
    }

    #[test]
    fn many_faces_at_one_edge_and_faces_without_area_end() {
        let positions: Vec<[f32; 3]> = (0..20_002).map(|i| [i as f32, (i % 7) as f32, 0.5]).collect();
        let book: Vec<u32> = (2..20_002).flat_map(|i| [0, 1, i]).collect();
        assert_eq!(smooth(&positions, &book, |_| Smoothing::ByAngle).indices.len(), book.len());
        let flat = smooth(&positions, &[0, 0, 0, 1, 2, 1], |_| Smoothing::ByAngle);
        assert!(flat.normals.iter().all(|&normal| Vec3::from(normal).is_normalized()));
    }
}
