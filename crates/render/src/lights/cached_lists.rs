//! What is known of a view's lists after they were made, so that they are made again only when they would be others.

use super::{
    ClusterLists, ClusterSettings, ClusterUniform, LightCulling, LightReaches, LightTable, ListLimits, ListRecord,
    ObjectBounds, Target, VolumeDraw, lit,
};
use crate::decals::{DecalTable, SharedDecals};
use crate::view::{DepthRange, View};
use glam::Vec4;
use std::sync::Arc;

/// What lists are made of beside the lights.
#[derive(Clone, Debug, PartialEq)]
pub struct LightListInputs {
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
    /// Whether anybody reads the lists of clusters or tiles. Where opaque surfaces are lit in another way, blended ones
    /// may.
    pub wants_lists: bool,
    /// Where objects lie, if objects have lists of their own.
    pub objects: Option<ObjectBounds>,
    /// The decals, which have lists beside those of lights.
    pub decals: SharedDecals,
    /// The row of the projection that gives depth before the division, by which volumes are found that are cut open;
    /// zero where there are none.
    pub depth_row: Vec4,
}

/// Lists that were made, without the lists themselves, which lie on the device.
#[derive(Clone, Debug)]
pub struct CachedLists {
    of: LightListInputs,
    /// The lights.
    pub table: Arc<LightTable>,
    /// Shape of the grid.
    pub uniform: ClusterUniform,
    /// Entries of all lists.
    pub entries: u64,
    /// The part of the picture that they may reach.
    pub lit_rectangles: Arc<[lit::Rectangle]>,
    /// How volumes are drawn.
    pub volume_draws: Arc<[VolumeDraw]>,
    /// The records of the lists of objects, by object id.
    pub object_lights: Arc<[ListRecord]>,
    /// The decals that have lists.
    pub decals: Arc<DecalTable>,
}

impl CachedLists {
    /// What is kept of `lists`.
    pub fn new(table: Arc<LightTable>, of: LightListInputs, lists: &ClusterLists, reaches: &LightReaches) -> Self {
        let volume_draws = reaches.draws.clone();
        // The lists of objects lie behind those of clusters.
        let clusters = lists.uniform.size[..3].iter().product::<u32>() as usize;
        let object_lights = lists.table.iter().skip(clusters).copied().collect();
        let lit_rectangles = lit::lit_rectangles(lists, of.target.size).into();
        Self {
            of,
            table,
            uniform: lists.uniform,
            entries: lists.lights.len() as u64 - lists.decals.entry_count,
            decals: lists.decals.table.clone(),
            lit_rectangles,
            volume_draws,
            object_lights,
        }
    }

    /// The same for `table`, if the lists of its lights are these.
    pub fn with(self, table: &Arc<LightTable>, of: &LightListInputs) -> Option<Self> {
        let is_same = self.of == *of && (Arc::ptr_eq(&self.table, table) || self.table.has_lists_of(table));
        is_same.then(|| Self { table: table.clone(), ..self })
    }
}
