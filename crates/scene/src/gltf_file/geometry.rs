//! What a file may leave out: lists from strips, fans and loops, flat normals and MikkTSpace tangents.

use crate::turns::{Turns, at_once, give_turn, in_slices};
use crate::{Aabb, MorphTarget, Primitive, Topology};
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::Vec3;
use std::collections::HashMap;
use std::ops::Range;

/// The topology of a glTF mode.
pub(super) fn topology(mode: usize) -> Option<Topology> {
    match mode {
        0 => Some(Topology::Points),
        1..=3 => Some(Topology::Lines),
        4..=6 => Some(Topology::Triangles),
        _ => None,
    }
}

/// The indices of a list that draws what `indices` draw in a glTF mode (specification, section 3.7.2.1).
pub(super) fn to_list(mode: usize, indices: Vec<u32>) -> Vec<u32> {
    match mode {
        2 => {
            let closing = if indices.len() > 1 { indices.last().copied().zip(indices.first().copied()) } else { None };
            let mut list: Vec<u32> = indices.windows(2).flatten().copied().collect();
            list.extend(closing.into_iter().flat_map(|(last, first)| [last, first]));
            list
        }
        3 => indices.windows(2).flatten().copied().collect(),
        5 => {
            let triangles = indices.windows(3).enumerate();
            triangles
                .flat_map(|(i, v)| match *v {
                    [a, b, c] if i % 2 == 0 => [a, b, c],
                    [a, b, c] => [a, c, b],
                    _ => [0; 3],
                })
                .collect()
        }
        6 => match indices.split_first() {
            Some((&hub, rim)) => rim
                .windows(2)
                .flat_map(|edge| match edge {
                    &[b, c] => [b, c, hub],
                    _ => [hub; 3],
                })
                .collect(),
            None => Vec::new(),
        },
        _ => {
            let mut list = indices;
            let size = match topology(mode) {
                Some(Topology::Triangles) => 3,
                Some(Topology::Lines) => 2,
                _ => 1,
            };
            list.truncate(list.len() / size * size);
            list
        }
    }
}

async fn gather<T: Copy>(values: &mut Vec<T>, source: &[u32], turns: &mut Turns<'_>) {
    if values.is_empty() {
        return;
    }
    let mut gathered = Vec::with_capacity(source.len());
    let add = |range: Range<usize>| {
        let source = source.get(range).unwrap_or_default();
        gathered.extend(source.iter().filter_map(|&i| values.get(i as usize).copied()));
    };
    in_slices(source.len(), turns, add).await;
    *values = gathered;
}

/// Makes vertex `i` a copy of the old vertex `source[i]`. Indices are left as they are.
async fn remap_vertices(primitive: &mut Primitive, source: &[u32], turns: &mut Turns<'_>) {
    gather(&mut primitive.positions, source, turns).await;
    gather(&mut primitive.normals, source, turns).await;
    gather(&mut primitive.tangents, source, turns).await;
    gather(&mut primitive.uv0, source, turns).await;
    gather(&mut primitive.uv1, source, turns).await;
    gather(&mut primitive.colors, source, turns).await;
    gather(&mut primitive.joints, source, turns).await;
    gather(&mut primitive.weights, source, turns).await;
    for MorphTarget { positions, normals, tangents } in &mut primitive.morph_targets {
        gather(positions, source, turns).await;
        gather(normals, source, turns).await;
        gather(tangents, source, turns).await;
    }
}

/// Gives every triangle its own vertices and the normal of its plane.
pub(super) async fn add_flat_normals(primitive: &mut Primitive, turns: &mut Turns<'_>) {
    let source = std::mem::take(&mut primitive.indices);
    primitive.tangents.clear();
    remap_vertices(primitive, &source, turns).await;
    primitive.indices = (0..primitive.positions.len() as u32).collect();
    let normal = |corners: &[[f32; 3]]| {
        let normal = match corners {
            &[a, b, c] => {
                let (a, b, c) = (Vec3::from(a).as_dvec3(), Vec3::from(b).as_dvec3(), Vec3::from(c).as_dvec3());
                (b - a).cross(c - a).normalize_or(glam::DVec3::Z).as_vec3()
            }
            _ => Vec3::Z,
        };
        [normal.to_array(); 3]
    };
    let triangles = primitive.positions.len() / 3;
    let mut normals = Vec::with_capacity(3 * triangles);
    let add = |range: Range<usize>| {
        let corners = primitive.positions.get(3 * range.start..3 * range.end).unwrap_or_default();
        normals.extend(corners.chunks_exact(3).flat_map(normal));
    };
    in_slices(triangles, turns, add).await;
    primitive.normals = normals;
}

struct Corners<'a> {
    primitive: &'a Primitive,
    uv: &'a [[f32; 2]],
    /// One tangent a corner.
    tangents: Vec<[f32; 4]>,
}

impl Corners<'_> {
    fn get<const N: usize>(&self, values: &[[f32; N]], face: usize, corner: usize) -> [f32; N] {
        let vertex = self.primitive.indices.get(face * 3 + corner);
        vertex.and_then(|&vertex| values.get(vertex as usize)).copied().unwrap_or([0.0; N])
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.indices.len() / 3
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.get(&self.primitive.positions, face, vert)
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.get(&self.primitive.normals, face, vert)
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.get(self.uv, face, vert)
    }

    fn set_tangent(&mut self, tangent_space: Option<TangentSpace>, face: usize, vert: usize) {
        let [x, y, z, sign] = tangent_space.unwrap_or_default().tangent_encoded();
        let tangent = Vec3::new(x, y, z);
        let normal = Vec3::from(self.normal(face, vert));
        let tangent = tangent.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        if let Some(slot) = self.tangents.get_mut(face * 3 + vert) {
            // The algorithm takes v to point up, glTF down; so the bitangent turns.
            *slot = tangent.extend(-sign).to_array();
        }
    }
}

/// Adds MikkTSpace tangents for a UV set. A vertex whose corners disagree is split.
pub(crate) fn add_tangents(primitive: &mut Primitive, uv_set: u32) {
    at_once(add_tangents_in_turns(primitive, uv_set, &mut || None));
}

/// As [`add_tangents`]; `turns` is asked between slices of what follows the generator, which gives all at once.
pub(super) async fn add_tangents_in_turns(primitive: &mut Primitive, uv_set: u32, turns: &mut Turns<'_>) {
    let uv = if uv_set == 1 { &primitive.uv1 } else { &primitive.uv0 };
    if uv.is_empty() || primitive.normals.is_empty() || primitive.indices.is_empty() {
        return;
    }
    let tangents = vec![[1.0, 0.0, 0.0, 1.0]; primitive.indices.len()];
    let mut corners = Corners { primitive, uv, tangents };
    if generate_tangents(&mut corners).is_err() {
        return;
    }
    let tangents = corners.tangents;
    give_turn(turns).await;

    let mut vertex_of: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let (mut source, mut vertex_tangents, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    let mut corners = primitive.indices.iter().zip(tangents);
    let add = |range: Range<usize>| {
        for (&old, tangent) in corners.by_ref().take(range.len()) {
            let new = *vertex_of.entry((old, tangent.map(f32::to_bits))).or_insert_with(|| {
                source.push(old);
                vertex_tangents.push(tangent);
                (source.len() - 1) as u32
            });
            indices.push(new);
        }
    };
    in_slices(primitive.indices.len(), turns, add).await;
    remap_vertices(primitive, &source, turns).await;
    primitive.indices = indices;
    primitive.tangents = vertex_tangents;
}

/// The box around the positions.
pub(crate) fn bounds(primitive: &Primitive) -> Aabb {
    Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_becomes_a_list() {
        let five = || vec![0, 1, 2, 3, 4];
        assert_eq!(to_list(0, five()), five());
        assert_eq!(to_list(1, five()), [0, 1, 2, 3]);
        assert_eq!(to_list(2, vec![0, 1, 2]), [0, 1, 1, 2, 2, 0]);
        assert_eq!(to_list(3, vec![0, 1, 2]), [0, 1, 1, 2]);
        assert_eq!(to_list(4, five()), [0, 1, 2]);
        assert_eq!(to_list(5, vec![0, 1, 2, 3]), [0, 1, 2, 1, 3, 2]);
        assert_eq!(to_list(6, vec![0, 1, 2, 3]), [1, 2, 0, 2, 3, 0]);
        assert!((0..7).all(|mode| to_list(mode, Vec::new()).is_empty()));
    }

    #[test]
    fn tangents_agree_with_the_procedural_ones() {
        for mut primitive in [crate::primitives::plane(2.0), crate::primitives::cube(Vec3::ONE)] {
            let of_corners = |p: &Primitive| -> Vec<_> { p.indices.iter().map(|&i| p.tangents[i as usize]).collect() };
            let expected = of_corners(&primitive);
            primitive.tangents.clear();
            add_tangents(&mut primitive, 0);
            for (tangent, expected) in of_corners(&primitive).into_iter().zip(expected) {
                assert!(glam::Vec4::from(tangent).abs_diff_eq(expected.into(), 1e-5), "{tangent:?} {expected:?}");
            }
            assert_eq!(primitive.tangents.len(), primitive.uv0.len());
        }
    }

    #[test]
    fn flat_normals_unweld() {
        let mut primitive = crate::primitives::cube(Vec3::ONE);
        let expected: Vec<_> = primitive.indices.iter().map(|&i| primitive.normals[i as usize]).collect();
        primitive.normals.clear();
        at_once(add_flat_normals(&mut primitive, &mut || None));
        assert_eq!(primitive.normals, expected);
        assert_eq!(primitive.uv0.len(), 36);
    }
}
