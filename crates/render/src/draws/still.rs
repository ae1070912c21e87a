//! What is kept of a frame for the next one, which mostly shows the same: items while nothing of the scene has changed,
//! and lists while views see it from the same place.

use super::decals::find_touched;
use super::list::DrawList;
use super::world::{Item, WorldDraws};
use crate::decals::SharedDecals;
use crate::levels::Chooser;
use crate::resources::SceneResources;
use crate::view::ViewUniform;
use glam::{Mat4, Vec2};
use manypass_scene::{NodeId, Scene};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// All that rigid items follow from.
#[derive(Debug, PartialEq)]
pub(super) struct WorldInputs {
    nodes_version: u64,
    roots: Vec<NodeId>,
    variant: Option<usize>,
    flat: Vec<NodeId>,
    resources_version: u64,
}

impl WorldInputs {
    pub fn of(scene: &Scene, resources: &SceneResources) -> Self {
        Self {
            nodes_version: scene.nodes.version(),
            roots: scene.roots.clone(),
            variant: scene.variant,
            flat: flat_nodes(scene).collect(),
            resources_version: resources.version(),
        }
    }

    pub fn are_those_of(&self, scene: &Scene, resources: &SceneResources) -> bool {
        self.nodes_version == scene.nodes.version()
            && self.resources_version == resources.version()
            && self.variant == scene.variant
            && self.flat.iter().copied().eq(flat_nodes(scene))
            && self.roots == scene.roots
    }
}

/// The nodes that are drawn as no item: water and portals.
pub(super) fn flat_nodes(scene: &Scene) -> impl Iterator<Item = NodeId> {
    let of_water = scene.water.iter().map(|water| water.node);
    of_water.chain(scene.portals.iter().flat_map(|portal| portal.nodes))
}

/// A number that no other world of this process has had.
pub(super) fn next_version() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// What a view's list is made for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ListOf<'v> {
    pub view: &'v ViewUniform,
    /// By so many pixels the view may be moved, and the list still holds all that it shows.
    pub room_px: f32,
    /// What is in one of these layers.
    pub layers: u32,
    pub chooser: &'v Chooser,
    /// Whether opaque surfaces are drawn from behind, too.
    pub shows_backs: bool,
}

impl ListOf<'_> {
    /// How far beyond the picture's sides something may lie, in normalised device coordinates.
    pub fn room_ndc(&self) -> Vec2 {
        2.0 * self.room_px * self.view.inverse_size_px
    }
}

/// All that a list follows from beside the world's items.
#[derive(Debug, PartialEq)]
struct ListInputs {
    clip_from_world: Mat4,
    view_from_world: Mat4,
    room_ndc: Vec2,
    layers: u32,
    chooser: Chooser,
    shows_backs: bool,
    decals: SharedDecals,
}

#[derive(Debug)]
struct KnownList {
    of: ListInputs,
    list: Arc<DrawList>,
    /// Whether a view of this frame has it.
    is_used: bool,
}

/// Of so many views the extent is kept.
const EXTENTS_MAX: usize = 16;

/// What the extent of a view follows from beside the world's items.
pub(super) type ExtentInputs = ([Mat4; 2], Vec2);

/// The lists of views of one world.
#[derive(Debug, Default)]
pub(super) struct KnownLists {
    lists: Vec<KnownList>,
    /// How far views see ([`WorldDraws::extent_m`]), the latest last.
    extents_m: RefCell<VecDeque<(ExtentInputs, f32)>>,
    /// How many were made in this frame.
    made: u32,
}

impl KnownLists {
    /// Begins a frame: what the last one had no use for is dropped.
    pub fn begin(&mut self) {
        self.made = 0;
        self.lists.retain_mut(|known| std::mem::take(&mut known.is_used));
    }

    /// Drops all, because the world is another one.
    pub fn clear(&mut self) {
        self.lists.clear();
        self.extents_m.get_mut().clear();
    }

    /// The extent of a view; found if it is not known.
    pub fn extent_m(&self, of: ExtentInputs, find: impl FnOnce() -> f32) -> f32 {
        let known = self.extents_m.borrow().iter().find(|(known, _)| *known == of).map(|(_, extent_m)| *extent_m);
        known.unwrap_or_else(|| {
            let extent_m = find();
            let mut extents_m = self.extents_m.borrow_mut();
            if extents_m.len() == EXTENTS_MAX {
                extents_m.pop_front();
            }
            extents_m.push_back((of, extent_m));
            extent_m
        })
    }
}

impl WorldDraws {
    /// What a view draws: the list of the last frame if that is still right.
    pub fn list(&mut self, of: &ListOf<'_>) -> Arc<DrawList> {
        let inputs = ListInputs {
            clip_from_world: of.view.clip_from_world,
            view_from_world: of.view.view_from_world,
            room_ndc: of.room_ndc(),
            layers: of.layers,
            chooser: of.chooser.clone(),
            shows_backs: of.shows_backs,
            decals: self.decals.clone(),
        };
        if let Some(known) = self.lists.lists.iter_mut().find(|known| known.of == inputs) {
            known.is_used = true;
            return known.list.clone();
        }
        self.lists.made += 1;
        let count = self.instances.len();
        let mut list = DrawList::new(self, of);
        if of.shows_backs {
            list.show_backs();
        }
        if !self.decals.0.boxes.is_empty() {
            find_touched(&mut list, self, &self.decals.0.boxes);
        }
        let list = Arc::new(list);
        // Instances of what fades are the frame's alone.
        if self.instances.len() == count {
            self.lists.lists.push(KnownList { of: inputs, list: list.clone(), is_used: true });
        }
        list
    }

    /// How many items were posed in this frame, because something had changed.
    pub fn items_posed(&self) -> u32 {
        if self.is_posed { self.items.len() as u32 } else { 0 }
    }

    /// How many lists of views were made in this frame, and not kept from the last one.
    pub fn lists_made(&self) -> u32 {
        self.lists.made
    }

    /// Another number whenever an instance may be another; none where views have added some.
    pub fn instances_version(&self) -> Option<u64> {
        (self.instances.len() == self.items.len()).then_some(self.version)
    }
}

impl Item {
    /// Whether no view draws it otherwise than `other`, as far as neither is culled.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let has_levels = self.has_levels() || other.has_levels();
        !has_levels
            && self.group == other.group
            && self.view_layers == other.view_layers
            && self.forms == other.forms
            && self.faces == other.faces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::LodSettings;
    use crate::view::{DepthRange, View};
    use glam::Vec3;
    use manypass_scene::Projection;

    fn view(x_m: f32) -> View {
        let projection = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None };
        View { world_from_view: Mat4::from_translation(Vec3::X * x_m), projection }
    }

    fn uniform(x_m: f32) -> ViewUniform {
        view(x_m).uniform(DepthRange { near_m: 0.1, far_m: 100.0 }, 64, 64, Vec2::ZERO, 1.0, 0)
    }

    #[test]
    fn lists_last_as_long_as_views_ask_for_them() {
        let mut world = WorldDraws::default();
        let chooser = Chooser::new(&view(0.0), (64, 64), &LodSettings::default(), &[]);
        let views = [uniform(0.0), uniform(1.0)];
        let of = |view| ListOf { view, room_px: 0.0, layers: 1, chooser: &chooser, shows_backs: false };
        let first = world.list(&of(&views[0]));
        assert!(Arc::ptr_eq(&first, &world.list(&of(&views[0]))));
        assert_eq!(world.lists_made(), 1);
        world.lists.begin();
        assert!(Arc::ptr_eq(&first, &world.list(&of(&views[0]))));
        assert!(!Arc::ptr_eq(&first, &world.list(&of(&views[1]))));
        assert!(!Arc::ptr_eq(&first, &world.list(&ListOf { layers: 2, ..of(&views[0]) })));
        assert_eq!(world.lists_made(), 2);
        world.lists.begin();
        world.lists.begin();
        assert!(!Arc::ptr_eq(&first, &world.list(&of(&views[0]))));
    }
}
