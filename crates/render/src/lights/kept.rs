//! What is known of a view's lists after they were made, so that they are made again only when they would be others.

use super::{ClusterLists, ClusterSettings, ClusterUniform, LightCulling, LightTable, ListLimits, Target};
use crate::view::{DepthRange, View};
use std::sync::Arc;

/// What lists are made of beside the lights.
#[derive(Clone, Debug, PartialEq)]
pub struct ListsOf {
    /// The camera.
    pub view: View,
    /// What slices are fitted to.
    pub range: DepthRange,
    /// The picture.
    pub target: Target,
    /// Whether there are lists at all.
    pub culling: LightCulling,
    /// The size of clusters.
    pub settings: ClusterSettings,
    /// The room for them.
    pub limits: ListLimits,
}

/// Lists that were made, without the lists themselves, which lie on the device.
#[derive(Clone, Debug)]
pub struct KeptLists {
    of: ListsOf,
    /// The lights.
    pub table: Arc<LightTable>,
    /// Shape of the grid.
    pub uniform: ClusterUniform,
    /// Entries of all lists.
    pub entries: u64,
}

impl KeptLists {
    /// What is kept of `lists`.
    pub fn new(table: Arc<LightTable>, of: ListsOf, lists: &ClusterLists) -> Self {
        Self { of, table, uniform: lists.uniform, entries: lists.lights.len() as u64 }
    }

    /// The same for `table`, if the lists of its lights are these.
    pub fn with(self, table: &Arc<LightTable>, of: &ListsOf) -> Option<Self> {
        let is_same = self.of == *of && (Arc::ptr_eq(&self.table, table) || self.table.has_lists_of(table));
        is_same.then(|| Self { table: table.clone(), ..self })
    }
}
