//! The nodes of a scene, with a number that tells whether any may have changed, and what is found out of all of them.

use crate::{Aabb, Mesh, Node, NodeId, Scene, Skin};
use glam::Vec3;
use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

/// The version that the next nodes get which have changed. 0 is none.
static NEXT_VERSION: AtomicU64 = AtomicU64::new(1);

/// The nodes of a [`Scene`]: a vector with a version. Whoever borrows the vector to change it makes the version another
/// one, so that a scene of a million nodes that stand still is not compared node by node.
#[derive(Debug, Default)]
pub struct Nodes {
    all: Vec<Node>,
    /// 0 since the last borrow to change them, until somebody asks.
    version: AtomicU64,
    /// What transforms are up to date with.
    placed: Option<PlacedInputs>,
    summary: Mutex<Option<Arc<NodeSummary>>>,
}

/// All that transforms and bounds of nodes follow from.
#[derive(Clone, Debug)]
struct PlacedInputs {
    version: u64,
    roots: Vec<NodeId>,
    origin_m: Vec3,
    meshes: Vec<Weak<Mesh>>,
    skins: Vec<Skin>,
}

/// What is found out of all nodes once while none changes.
#[derive(Debug)]
pub(crate) struct NodeSummary {
    version: u64,
    roots: Vec<NodeId>,
    meshes: Vec<Weak<Mesh>>,
    lights: Arc<[usize]>,
    visible: OnceLock<VisibleNodes>,
    pub bounds_world: OnceLock<Aabb>,
}

/// What [`Scene::visible_levels`] has.
#[derive(Debug)]
struct VisibleNodes {
    /// For every node, whether it is there.
    shown: Vec<bool>,
    lit: Arc<[NodeId]>,
    is_lit: bool,
}

impl Nodes {
    /// Another number whenever a node may have changed. Clones have the same until one of them changes; no others do.
    pub fn version(&self) -> u64 {
        let known = self.version.load(Ordering::Relaxed);
        if known != 0 {
            return known;
        }
        let new = NEXT_VERSION.fetch_add(1, Ordering::Relaxed);
        // Another thread may have asked meanwhile.
        self.version.compare_exchange(0, new, Ordering::Relaxed, Ordering::Relaxed).map_or_else(|known| known, |_| new)
    }
}

impl Deref for Nodes {
    type Target = Vec<Node>;

    fn deref(&self) -> &Vec<Node> {
        &self.all
    }
}

impl DerefMut for Nodes {
    fn deref_mut(&mut self) -> &mut Vec<Node> {
        *self.version.get_mut() = 0;
        &mut self.all
    }
}

impl Clone for Nodes {
    fn clone(&self) -> Self {
        Self {
            all: self.all.clone(),
            version: AtomicU64::new(self.version()),
            placed: self.placed.clone(),
            summary: Mutex::new(self.summary.lock().unwrap_or_else(PoisonError::into_inner).clone()),
        }
    }
}

impl PartialEq for Nodes {
    /// By the nodes alone.
    fn eq(&self, other: &Self) -> bool {
        self.all == other.all
    }
}

impl From<Vec<Node>> for Nodes {
    fn from(all: Vec<Node>) -> Self {
        Self { all, ..Self::default() }
    }
}

impl<'n> IntoIterator for &'n Nodes {
    type Item = &'n Node;
    type IntoIter = std::slice::Iter<'n, Node>;

    fn into_iter(self) -> Self::IntoIter {
        self.all.iter()
    }
}

impl<'n> IntoIterator for &'n mut Nodes {
    type Item = &'n mut Node;
    type IntoIter = std::slice::IterMut<'n, Node>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl Scene {
    /// Whether nothing has changed that transforms follow from since [`Self::keep_placed`].
    pub(crate) fn is_placed(&self) -> bool {
        self.nodes.placed.as_ref().is_some_and(|placed| {
            placed.version == self.nodes.version()
                && placed.origin_m == self.origin_m
                && placed.roots == self.roots
                && are_same(&placed.meshes, &self.meshes)
                && placed.skins == self.skins
        })
    }

    /// Says that transforms and bounds are up to date.
    pub(crate) fn keep_placed(&mut self) {
        let version = self.nodes.version();
        if let Some(placed) = &mut self.nodes.placed
            && placed.roots == self.roots
            && are_same(&placed.meshes, &self.meshes)
            && placed.skins == self.skins
        {
            (placed.version, placed.origin_m) = (version, self.origin_m);
            return;
        }
        self.nodes.placed = Some(PlacedInputs {
            version,
            roots: self.roots.clone(),
            origin_m: self.origin_m,
            meshes: self.meshes.iter().map(Arc::downgrade).collect(),
            skins: self.skins.clone(),
        });
    }

    /// For every node with a light, hidden ones too: its index into [`Scene::lights`].
    pub fn light_indices(&self) -> Arc<[usize]> {
        self.summary().lights.clone()
    }

    /// The nodes with a light among [`Scene::visible_levels`], in their order.
    pub fn lit_nodes(&self) -> Arc<[NodeId]> {
        self.summary().visible(self).lit.clone()
    }

    /// Whether one of [`Scene::visible_nodes`] has a light.
    pub fn is_lit(&self) -> bool {
        self.summary().visible(self).is_lit
    }

    /// Whether a node is among [`Scene::visible_levels`].
    pub fn shows(&self, id: NodeId) -> bool {
        self.summary().visible(self).shown.get(id.0 as usize).copied().unwrap_or(false)
    }

    /// What was found out of the nodes as they are.
    pub(crate) fn summary(&self) -> Arc<NodeSummary> {
        let mut kept = self.nodes.summary.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(summary) = kept.as_ref().filter(|summary| summary.is_of(self)) {
            return summary.clone();
        }
        let summary = NodeSummary {
            version: self.nodes.version(),
            roots: self.roots.clone(),
            meshes: self.meshes.iter().map(Arc::downgrade).collect(),
            lights: self.nodes.iter().filter_map(|node| node.light).collect(),
            visible: OnceLock::new(),
            bounds_world: OnceLock::new(),
        };
        kept.insert(Arc::new(summary)).clone()
    }
}

impl NodeSummary {
    fn is_of(&self, scene: &Scene) -> bool {
        self.version == scene.nodes.version() && self.roots == scene.roots && are_same(&self.meshes, &scene.meshes)
    }

    /// Of the scene whose summary it is.
    fn visible(&self, scene: &Scene) -> &VisibleNodes {
        self.visible.get_or_init(|| {
            let visible = scene.visible_levels();
            let mut shown = vec![false; scene.nodes.len()];
            for (id, _) in &visible {
                shown[id.0 as usize] = true;
            }
            let lit = || visible.iter().filter(|(id, _)| scene.node(*id).light.is_some());
            VisibleNodes {
                shown,
                lit: lit().map(|(id, _)| *id).collect(),
                is_lit: lit().any(|(_, of)| of.is_none_or(|of| of.level == 0)),
            }
        })
    }
}

/// Whether meshes are those at the same places in memory, which nobody else takes while they are known.
fn are_same(known: &[Weak<Mesh>], meshes: &[Arc<Mesh>]) -> bool {
    known.iter().map(Weak::as_ptr).eq(meshes.iter().map(Arc::as_ptr))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Light;

    #[test]
    fn only_a_borrow_to_change_nodes_changes_their_version() {
        let mut scene = Scene::default();
        let id = scene.add_node(None, Node::default());
        scene.update_transforms();
        let version = scene.nodes.version();
        assert_eq!((scene.node(id).children.len(), scene.nodes.iter().count(), scene.nodes.len()), (0, 1, 1));
        assert_eq!((scene.update_transforms(), scene.nodes.version()), (0, version));
        let mut other = scene.clone();
        assert_eq!(other.nodes.version(), version);
        other.node_mut(id).translation = Vec3::X;
        assert_ne!(other.nodes.version(), version);
        assert_eq!(scene.nodes.version(), version);
        assert_eq!((scene.update_transforms(), other.update_transforms()), (0, 1));
        for node in &mut scene.nodes {
            node.translation = Vec3::Y;
        }
        assert_ne!(scene.nodes.version(), version);
        assert_eq!(scene.update_transforms(), 1);
    }

    #[test]
    fn what_is_beside_nodes_is_seen_too() {
        let mut scene = Scene::default();
        let id = scene.add_node(None, Node { light: Some(0), ..Node::default() });
        scene.lights.push(Light::default());
        scene.update_transforms();
        assert_eq!((&scene.light_indices()[..], &scene.lit_nodes()[..], scene.is_lit()), (&[0][..], &[id][..], true));
        assert!(scene.shows(id) && !scene.shows(NodeId(1)));
        assert!(Arc::ptr_eq(&scene.lit_nodes(), &scene.lit_nodes()));
        scene.origin_m = Vec3::X;
        assert_eq!(scene.update_transforms(), 0);
        scene.node_mut(id).translation = Vec3::Y;
        assert_eq!(scene.update_transforms(), 1);
        assert_eq!(scene.node(id).world_from_object.w_axis.truncate(), Vec3::Y - Vec3::X);
        scene.roots.clear();
        assert_eq!((scene.light_indices().len(), scene.lit_nodes().len(), scene.is_lit()), (1, 0, false));
    }
}
