//! What a scene of a file draws.

use crate::NodeId;

/// One of the scenes of a file: a choice of its nodes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneRoots {
    /// The name in the file; empty if it has none.
    pub name: String,
    /// The nodes without a parent that it draws.
    pub roots: Vec<NodeId>,
}
