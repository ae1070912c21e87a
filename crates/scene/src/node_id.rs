//! How nodes are named.

/// The index of a node in [`Scene::nodes`](crate::Scene::nodes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);
