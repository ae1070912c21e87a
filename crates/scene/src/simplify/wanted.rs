//! Which primitives get coarser levels.

use crate::{Primitive, Topology};

/// No level has fewer triangles, and meshes below twice as many have no levels.
pub(super) const TRIANGLES_MIN: usize = 32;

/// Whether a primitive gets levels.
pub(super) fn is_wanted(primitive: &Primitive) -> bool {
    let count = if primitive.indices.is_empty() { primitive.positions.len() } else { primitive.indices.len() };
    primitive.topology == Topology::Triangles
        && primitive.morph_targets.is_empty()
        && primitive.levels.is_empty()
        && count >= 6 * TRIANGLES_MIN
}
