//! Clouds: primitives of many points, in an order in which neighbours follow each other, so that views can leave out
//! the parts that they do not show.

use super::vertices::is_deformed;
use glam::Vec3;
use manypass_scene::{Aabb, Primitive, Topology};
use std::ops::Range;

/// Points of a block, the fewest that a view leaves out. A draw call costs llvmpipe as much as about 20 points.
const BLOCK_POINTS: usize = 32;
/// Blocks of a chunk: they are looked at one by one where a view may leave out some of them.
const CHUNK_BLOCKS: usize = 32;
/// Fewer points are drawn as they are.
const POINTS_MIN: usize = 4096;

/// Cells along each side of the box around a cloud: 21 bits for each side fit a number of 64.
const CELLS: u32 = 1 << 21;

/// The boxes around successive points of a primitive, in object space; empty around those that are not finite.
#[derive(Debug)]
pub(crate) struct Cloud {
    point_count: usize,
    blocks: Vec<Aabb>,
    chunks: Vec<Aabb>,
}

impl Cloud {
    /// That of a primitive in its drawing order; none of what is deformed or has few points.
    pub fn of(primitive: &Primitive) -> Option<Self> {
        if !is_cloud(primitive) {
            return None;
        }
        let around = |points: &[[f32; 3]]| Aabb::from_points(points.iter().copied().map(Vec3::from_array));
        let blocks: Vec<Aabb> = primitive.positions.chunks(BLOCK_POINTS).map(around).collect();
        let union = |blocks: &[Aabb]| blocks.iter().fold(Aabb::EMPTY, |all, block| all.union(block));
        let chunks = blocks.chunks(CHUNK_BLOCKS).map(union).collect();
        Some(Self { point_count: primitive.positions.len(), blocks, chunks })
    }

    /// The boxes around chunks, in their order.
    pub fn chunks(&self) -> &[Aabb] {
        &self.chunks
    }

    /// The boxes around the blocks of a chunk, and the index of each.
    pub fn blocks_of(&self, chunk: usize) -> impl Iterator<Item = (usize, &Aabb)> {
        let first = chunk * CHUNK_BLOCKS;
        self.blocks.iter().enumerate().skip(first).take(CHUNK_BLOCKS)
    }

    /// The points of a chunk.
    pub fn points_of_chunk(&self, chunk: usize) -> Range<usize> {
        self.points(chunk, BLOCK_POINTS * CHUNK_BLOCKS)
    }

    /// The points of a block.
    pub fn points_of_block(&self, block: usize) -> Range<usize> {
        self.points(block, BLOCK_POINTS)
    }

    fn points(&self, at: usize, count: usize) -> Range<usize> {
        at * count..((at + 1) * count).min(self.point_count)
    }
}

fn is_cloud(primitive: &Primitive) -> bool {
    primitive.topology == Topology::Points
        && primitive.indices.is_empty()
        && primitive.positions.len() >= POINTS_MIN
        && !is_deformed(primitive)
}

/// The order in which the points of a cloud are drawn, if not in their own: those of neighbouring cells follow each
/// other, along the curve of Morton 1966, "A Computer Oriented Geodetic Data Base". Points of one cell keep their order,
/// and so do clouds whose vertices blend, in which the order shows everywhere.
pub(super) fn neighbours_first(primitive: &Primitive) -> Option<Vec<u32>> {
    if !is_cloud(primitive) {
        return None;
    }
    let Primitive { positions, normals, tangents, uv0, uv1, colors, .. } = primitive;
    let lengths = [normals.len(), tangents.len(), uv0.len(), uv1.len(), colors.len()];
    let are_whole = lengths.iter().all(|length| *length == 0 || *length == positions.len());
    let blends = colors.iter().any(|color| color[3] < 1.0);
    if !are_whole || blends || u32::try_from(positions.len()).is_err() {
        return None;
    }
    let bounds = Aabb::from_points(positions.iter().copied().map(Vec3::from_array));
    let extent_m = (bounds.max - bounds.min).max_element();
    if extent_m.is_nan() || extent_m <= 0.0 {
        return None;
    }
    let cells_per_m = CELLS as f32 / extent_m;
    let key = |(index, position): (usize, &[f32; 3])| {
        // What is no number lies in the first cell.
        let cell = ((Vec3::from_array(*position) - bounds.min) * cells_per_m).as_uvec3();
        let [x, y, z] = cell.to_array().map(|side| spread(side.min(CELLS - 1)));
        (x | y << 1 | z << 2, index as u32)
    };
    let mut keys: Vec<(u64, u32)> = positions.iter().enumerate().map(key).collect();
    keys.sort_unstable();
    Some(keys.into_iter().map(|(_, index)| index).collect())
}

/// A number of 21 bits with two zeros before each.
fn spread(number: u32) -> u64 {
    let mut bits = u64::from(number);
    bits = (bits | bits << 32) & 0x001f_0000_0000_ffff;
    bits = (bits | bits << 16) & 0x001f_0000_ff00_00ff;
    bits = (bits | bits << 8) & 0x100f_00f0_0f00_f00f;
    bits = (bits | bits << 4) & 0x10c3_0c30_c30c_30c3;
    (bits | bits << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::super::vertices::in_drawing_order;
    use super::*;

    /// Points of a sphere one after the other around it, so that those that follow each other lie far apart.
    fn sphere(count: usize) -> Primitive {
        let point = |i: usize| {
            let (y, turn) = (1.0 - 2.0 * (i as f32 + 0.5) / count as f32, i as f32 * 2.399_963);
            let radius = (1.0 - y * y).sqrt();
            [radius * turn.cos(), y, radius * turn.sin()]
        };
        Primitive {
            topology: Topology::Points,
            positions: (0..count).map(point).collect(),
            colors: (0..count).map(|i| [i as f32, 0.0, 0.0, 1.0]).collect(),
            ..Primitive::default()
        }
    }

    #[test]
    fn bits_are_spread() {
        for number in [0, 1, 2, 0x15_5555, CELLS - 1] {
            let spread = spread(number);
            let is_right = |bit: u32| spread >> (3 * bit) & 7 == u64::from(number >> bit & 1);
            assert!((0..21).all(is_right), "{number}: {spread:x}");
        }
    }

    #[test]
    fn neighbours_follow_each_other_with_what_is_theirs() {
        let mut given = sphere(10_000);
        // Two at one place, and one that is nowhere.
        given.positions[7000] = given.positions[12];
        given.positions[5] = [f32::NAN, 0.0, 0.0];
        let drawn = in_drawing_order(&given);
        assert_eq!((drawn.positions.len(), drawn.colors.len()), (10_000, 10_000));
        let indices: Vec<usize> = drawn.colors.iter().map(|color| color[0] as usize).collect();
        for (at, index) in indices.iter().enumerate() {
            let pair = [drawn.positions[at], given.positions[*index]];
            assert!(pair[0].map(f32::to_bits) == pair[1].map(f32::to_bits), "{index}");
        }
        let mut sorted = indices.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..10_000));
        let place = |wanted: usize| indices.iter().position(|index| *index == wanted);
        assert!(place(12) < place(7000));
        let size_m = |cloud: &Cloud| {
            let sizes = cloud.blocks.iter().map(|block| (block.max - block.min).length());
            sizes.sum::<f32>() / cloud.blocks.len() as f32
        };
        let (cloud, unsorted) = (Cloud::of(&drawn).expect("a cloud"), Cloud::of(&given).expect("a cloud"));
        // 32 of 10,000 points take a square with sides of 0.2 of the sphere.
        assert!(size_m(&cloud) < 0.6 && size_m(&unsorted) > 1.5, "{}, {}", size_m(&cloud), size_m(&unsorted));
        let mut next = 0;
        for chunk in 0..cloud.chunks().len() {
            assert_eq!(cloud.points_of_chunk(chunk).start, next);
            for (block, bounds) in cloud.blocks_of(chunk) {
                let points = cloud.points_of_block(block);
                assert_eq!(points.start, next);
                next = points.end;
                let finite = drawn.positions[points].iter().copied().map(Vec3::from_array).filter(|p| p.is_finite());
                for point in finite {
                    assert!(point.clamp(bounds.min, bounds.max) == point);
                    let bounds = &cloud.chunks()[chunk];
                    assert!(point.clamp(bounds.min, bounds.max) == point);
                }
            }
            assert_eq!(cloud.points_of_chunk(chunk).end, next);
        }
        assert_eq!(next, 10_000);
    }

    #[test]
    fn few_points_and_those_that_blend_keep_their_order() {
        assert!(neighbours_first(&sphere(100)).is_none() && Cloud::of(&sphere(100)).is_none());
        let mut blended = sphere(10_000);
        blended.colors[3][3] = 0.5;
        assert!(neighbours_first(&blended).is_none() && Cloud::of(&blended).is_some());
        let same = Primitive { positions: vec![[1.0; 3]; 10_000], colors: Vec::new(), ..sphere(0) };
        assert!(neighbours_first(&same).is_none());
    }
}
