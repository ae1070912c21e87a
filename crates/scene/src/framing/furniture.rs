//! What stands in a room: pieces that are seen from its middle, do not touch its outside and are small beside it.
//!
//! A piece is what is connected: triangles of one node that have corners at the same places, as those of a chair. A
//! vase is one piece. Sponza has 106 small ones that are seen from its middle: its columns, arches and curtains.

use super::panorama::{Ray, solids, triangles};
use crate::{Aabb, NodeId, Scene};
use std::collections::{HashMap, HashSet};

/// So many pieces furnish a room: four chairs and a table. Sponza has 106, a mug with its spoon one.
const LEAST_PIECES: usize = 5;

/// Furniture is smaller than this share of the scene in at least two of three directions; the lining of a chest is not.
const LARGEST_SHARE: f32 = 0.5;

/// Whether rays from the middle of a scene, whose box is `bounds`, meet furniture before they meet walls.
pub(super) fn is_furnished(scene: &Scene, bounds: &Aabb, rays: &[Ray]) -> bool {
    let mut pieces = Pieces::of_scene(scene);
    let mut of =
        |vertices: Vec<usize>| -> HashSet<u32> { vertices.into_iter().map(|it| pieces.of_vertex(it)).collect() };
    let mut seen = of(rays.iter().filter_map(|ray| ray.first_vertex).collect());
    let outermost = of(rays.iter().filter_map(|ray| ray.last_vertex).collect());
    seen.retain(|piece| !outermost.contains(piece));
    if seen.len() < LEAST_PIECES {
        return false;
    }
    let least = LARGEST_SHARE * (bounds.max - bounds.min);
    let is_small = |piece: &Aabb| (piece.max - piece.min).cmplt(least).bitmask().count_ones() >= 2;
    pieces.bounds(scene, &seen).values().filter(|piece| is_small(piece)).count() >= LEAST_PIECES
}

/// The connected pieces of a scene. Vertices are counted over all of [`solids`].
struct Pieces {
    /// Of each vertex, one of its piece that does not come after it; the first one of a piece has itself.
    parents: Vec<u32>,
}

impl Pieces {
    fn of_scene(scene: &Scene) -> Self {
        let count = solids(scene).map(|(_, primitive)| primitive.positions.len()).sum::<usize>();
        let mut pieces = Self { parents: (0..count as u32).collect() };
        let mut places: Vec<([u32; 3], usize)> = Vec::new();
        let mut last_node: Option<NodeId> = None;
        let mut before = 0;
        for (id, primitive) in solids(scene) {
            if last_node.replace(id) != Some(id) {
                pieces.join_equal(&mut places);
            }
            // Both zeros are one place.
            let bits = |position: &[f32; 3]| position.map(|value| (value + 0.0).to_bits());
            places.extend(primitive.positions.iter().map(bits).zip(before..));
            let end = before + primitive.positions.len();
            for [a, b, c] in triangles(primitive).map(|corners| corners.map(|corner| before + corner)) {
                if a.max(b).max(c) < end {
                    pieces.join(a, b);
                    pieces.join(a, c);
                }
            }
            before = end;
        }
        pieces.join_equal(&mut places);
        pieces
    }

    /// Joins the vertices that lie at one place, and forgets them.
    fn join_equal(&mut self, places: &mut Vec<([u32; 3], usize)>) {
        places.sort_unstable();
        for pair in places.windows(2) {
            if pair[0].0 == pair[1].0 {
                self.join(pair[0].1, pair[1].1);
            }
        }
        places.clear();
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of_vertex(a), self.of_vertex(b));
        if let Some(parent) = self.parents.get_mut(a.max(b) as usize) {
            *parent = a.min(b);
        }
    }

    /// The first vertex of the piece of a vertex. Halves the way there.
    fn of_vertex(&mut self, vertex: usize) -> u32 {
        let mut at = vertex as u32;
        loop {
            let parent = self.parents.get(at as usize).copied().unwrap_or(at);
            if parent == at {
                return at;
            }
            let next = self.parents.get(parent as usize).copied().unwrap_or(parent);
            if let Some(parent) = self.parents.get_mut(at as usize) {
                *parent = next;
            }
            at = next;
        }
    }

    /// The boxes in world space around some of the pieces.
    fn bounds(&mut self, scene: &Scene, wanted: &HashSet<u32>) -> HashMap<u32, Aabb> {
        let mut bounds = HashMap::new();
        let mut vertex = 0;
        for (id, primitive) in solids(scene) {
            let world_from_object = scene.node(id).world_from_object;
            for position in &primitive.positions {
                let piece = self.of_vertex(vertex);
                vertex += 1;
                if wanted.contains(&piece) {
                    let place = world_from_object.transform_point3((*position).into());
                    let of_piece = bounds.entry(piece).or_insert(Aabb::EMPTY);
                    *of_piece = of_piece.union(&Aabb { min: place, max: place });
                }
            }
        }
        bounds
    }
}
