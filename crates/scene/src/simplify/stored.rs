//! Coarser levels of a scene's meshes as bytes, for a cache.
//!
//! An entry is a line of text that says what it is, a hash of all that follows it, and of each mesh and primitive the
//! levels. One that is not whole, or is of something else, is none.

use super::wanted::is_wanted;
use crate::{Mesh, Primitive, PrimitiveLevel};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

/// Rises whenever levels of the same mesh become others.
const VERSION: u32 = 1;

const MAGIC: &[u8] = b"manypass levels 1\n";

/// The name of the levels of the meshes at `wanted`: of all that they are made from.
pub(super) fn name_of(meshes: &[Arc<Mesh>], wanted: &[usize]) -> String {
    let mut hasher = DefaultHasher::new();
    (VERSION, wanted.len()).hash(&mut hasher);
    for primitives in wanted.iter().filter_map(|mesh| meshes.get(*mesh)).map(|mesh| &mesh.primitives) {
        primitives.len().hash(&mut hasher);
        for primitive in primitives {
            let Primitive { positions, normals, uv0, uv1, colors, indices, .. } = primitive;
            is_wanted(primitive).hash(&mut hasher);
            let attributes: [&[u8]; 6] = [
                bytemuck::cast_slice(positions),
                bytemuck::cast_slice(normals),
                bytemuck::cast_slice(uv0),
                bytemuck::cast_slice(uv1),
                bytemuck::cast_slice(colors),
                bytemuck::cast_slice(indices),
            ];
            attributes.hash(&mut hasher);
        }
    }
    format!("levels-{:016x}", hasher.finish())
}

fn hash_of(bytes: &[u8]) -> [u8; 8] {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    hasher.finish().to_le_bytes()
}

/// The entry of the levels of the primitives of meshes.
pub(super) fn entry<'l>(meshes: impl Iterator<Item = &'l Vec<Vec<PrimitiveLevel>>>) -> Vec<u8> {
    let mut bytes = Vec::new();
    for levels in meshes.flatten() {
        bytes.extend_from_slice(&(levels.len() as u32).to_le_bytes());
        for PrimitiveLevel { indices, error_m } in levels {
            bytes.extend_from_slice(&error_m.to_le_bytes());
            bytes.extend_from_slice(&(indices.len() as u32).to_le_bytes());
            indices.iter().for_each(|index| bytes.extend_from_slice(&index.to_le_bytes()));
        }
    }
    [MAGIC, &hash_of(&bytes), &bytes].concat()
}

/// The levels of an entry for each primitive of the meshes at `wanted`, if it is one of theirs.
pub(super) fn levels_of(entry: &[u8], meshes: &[Arc<Mesh>], wanted: &[usize]) -> Option<Vec<Vec<Vec<PrimitiveLevel>>>> {
    let (hash, mut rest) = entry.strip_prefix(MAGIC)?.split_at_checked(8)?;
    if hash_of(rest) != *hash {
        return None;
    }
    let mut of_meshes = Vec::with_capacity(wanted.len());
    for mesh in wanted {
        let primitives = meshes.get(*mesh)?.primitives.iter();
        let of_mesh: Option<Vec<_>> = primitives.map(|primitive| levels_of_primitive(&mut rest, primitive)).collect();
        of_meshes.push(of_mesh?);
    }
    rest.is_empty().then_some(of_meshes)
}

fn levels_of_primitive(rest: &mut &[u8], primitive: &Primitive) -> Option<Vec<PrimitiveLevel>> {
    let vertices = primitive.positions.len();
    let count = u32::from_le_bytes(number(rest)?);
    let mut levels = Vec::new();
    for _ in 0..count {
        let error_m = f32::from_le_bytes(number(rest)?);
        let length = u32::from_le_bytes(number(rest)?) as usize;
        let (indices, after) = rest.split_at_checked(length.checked_mul(4)?)?;
        *rest = after;
        let indices: Vec<u32> = bytemuck::pod_collect_to_vec(indices);
        let is_whole = length.is_multiple_of(3) && indices.iter().all(|index| (*index as usize) < vertices);
        levels.push(PrimitiveLevel { indices, error_m: Some(error_m).filter(|error_m| is_whole && *error_m >= 0.0)? });
    }
    Some(levels)
}

fn number(rest: &mut &[u8]) -> Option<[u8; 4]> {
    let (number, after) = rest.split_first_chunk::<4>()?;
    *rest = after;
    Some(*number)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use crate::primitives;

    #[test]
    fn entries_come_back_and_broken_ones_do_not() {
        let ball = primitives::uv_sphere(1.0, 16, 8);
        let meshes = vec![Arc::new(Mesh { primitives: vec![ball.clone(), ball], ..Mesh::default() })];
        let level = |indices: &[u32], error_m| PrimitiveLevel { indices: indices.to_vec(), error_m };
        let levels = vec![vec![vec![level(&[0, 1, 2, 2, 1, 3], 0.1), level(&[0, 1, 2], 0.2)], Vec::new()]];
        let whole = entry(levels.iter());
        assert_eq!(levels_of(&whole, &meshes, &[0]), Some(levels));
        for at in [0, MAGIC.len(), MAGIC.len() + 8, MAGIC.len() + 13, whole.len() - 1] {
            let mut broken = whole.clone();
            broken[at] ^= 1;
            assert_eq!(levels_of(&broken, &meshes, &[0]), None, "byte {at}");
        }
        assert_eq!(levels_of(&whole[..whole.len() - 1], &meshes, &[0]), None);
        assert_eq!(levels_of(&whole, &meshes, &[]), None);
        // Whole, but of a larger mesh.
        assert_eq!(levels_of(&entry([vec![vec![level(&[0, 1, 9999], 0.1)], Vec::new()]].iter()), &meshes, &[0]), None);
    }

    #[test]
    fn names_tell_meshes_apart() {
        let named = |change: fn(&mut Primitive)| {
            let mut ball = primitives::uv_sphere(1.0, 32, 16);
            change(&mut ball);
            name_of(&[Arc::new(Mesh { primitives: vec![ball], ..Mesh::default() })], &[0])
        };
        let same = named(|_| ());
        assert_eq!(named(|_| ()), same);
        for other in [
            named(|ball| ball.positions[5][1] += 1e-6),
            named(|ball| ball.normals[5][1] += 1e-6),
            named(|ball| ball.uv0[5][1] += 1e-6),
            named(|ball| ball.indices.swap(0, 1)),
            named(|ball| ball.morph_targets.push(Default::default())),
        ] {
            assert_ne!(other, same);
        }
    }
}
