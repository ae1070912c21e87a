//! Which items have levels of detail, and which a view shows.

use super::ball::Ball;
use super::fading::{Side, faded};
use super::list::Draw;
use super::world::{Item, WorldDraws};
use crate::levels::{Choice, Chooser, Group, SurfaceForm};
use crate::resources::{Geometry, GpuPrimitive, Instance};
use glam::Vec3;
use manypass_scene::{Aabb, LevelOf, Levels, Node, NodeId, Scene, Topology};
use std::collections::HashMap;
use std::ops::Range;

/// What an item is drawn for: a level of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LevelTag {
    /// Index of a group of the world.
    pub group: u32,
    /// 0 is the finest.
    pub level: u32,
}

/// The levels of an item.
#[derive(Clone, Debug, Default)]
pub(crate) struct ItemLevels {
    /// Its coarser forms, in [`MeshLevels`].
    pub of_mesh: Range<u32>,
    /// That of a node which it is drawn for.
    pub of_node: Option<LevelTag>,
    /// That of its material which it is drawn for.
    pub of_material: Option<LevelTag>,
}

/// Coarser forms of all items.
#[derive(Debug, Default)]
pub(crate) struct MeshLevels {
    /// Indices in their page, and that page.
    elements: Vec<(Range<u32>, u32)>,
    /// How far each is from the finest, in metres of the world.
    errors_m: Vec<f32>,
}

impl MeshLevels {
    pub fn clear(&mut self) {
        self.elements.clear();
        self.errors_m.clear();
    }

    /// Adds those of a primitive where a node puts it.
    pub fn append(&mut self, primitive: &GpuPrimitive, node: &Node, is_skinned: bool) -> Range<u32> {
        let first = self.errors_m.len() as u32;
        if primitive.levels.is_empty() {
            return first..first;
        }
        let scale = if is_skinned {
            // Joints scale as they like; the box around all that they do is no smaller than what is drawn.
            let diagonal_m = |bounds: &Aabb| (bounds.max - bounds.min).length();
            diagonal_m(&node.bounds_world) / diagonal_m(&primitive.bounds).max(f32::MIN_POSITIVE)
        } else {
            node.scale_max()
        };
        for level in &primitive.levels {
            self.elements.push((level.indices.units.clone(), level.indices.page as u32));
            self.errors_m.push(level.error_m * scale);
        }
        first..self.errors_m.len() as u32
    }
}

/// The group of something in a ball.
pub(super) fn group_of<T>(ball: &Ball, levels: &Levels<T>) -> Group {
    let ends = (0..levels.count()).map(|level| levels.end_coverage(level)).collect();
    Group { center: ball.center, radius_m: ball.radius_m, ends }
}

/// The ball around an item's box.
fn ball_of(item: &Item) -> (Vec3, f32) {
    let bounds = &item.bounds_world;
    (bounds.center(), bounds.radius_m())
}

/// The groups of nodes with levels, while what lies in them is found.
#[derive(Debug, Default)]
pub(super) struct NodeGroups {
    by_node: HashMap<NodeId, u32>,
    balls: Vec<(LevelTag, Ball)>,
}

impl NodeGroups {
    /// The tag of a node of a level, with what `geometry` knows of its mesh.
    pub fn add(
        &mut self,
        scene: &Scene,
        of: LevelOf,
        (node, geometry): (&Node, &Geometry),
        groups: &mut Vec<Group>,
    ) -> LevelTag {
        let group = *self.by_node.entry(of.node).or_insert_with(|| {
            let group = groups.len() as u32;
            let levels = scene.node(of.node).levels.as_ref();
            groups.extend(levels.map(|levels| group_of(&Ball::around(&Aabb::EMPTY), levels)));
            group
        });
        let tag = LevelTag { group, level: of.level };
        if !node.bounds_world.is_empty() {
            let rigid = node.mesh.and_then(|mesh| geometry.rigid(mesh));
            self.balls.push((tag, Ball::of_node(node, rigid)));
        }
        tag
    }

    /// All that is of any level was added. A group is as large as its finest level: coarser ones stand for that.
    pub fn close(mut self, groups: &mut [Group]) {
        self.balls.sort_by_key(|(tag, _)| (tag.group, tag.level));
        let mut last = None;
        for of_level in self.balls.chunk_by(|(a, _), (b, _)| a == b) {
            let tag = of_level[0].0;
            if last.replace(tag.group) == Some(tag.group) {
                continue;
            }
            let ball = Ball::around_all(of_level.iter().map(|(_, ball)| *ball));
            let group = &mut groups[tag.group as usize];
            (group.center, group.radius_m) = (ball.center, ball.radius_m);
        }
    }
}

/// In which form an item is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Form {
    /// The level of its mesh; 0 is the finest.
    pub level: u32,
    /// What its surface has.
    pub surface: SurfaceForm,
}

/// What a view shows of an item.
#[derive(Debug)]
pub(super) enum ItemForms {
    /// Another level takes its place.
    Nothing,
    /// All of it, at a level of its mesh.
    One(Form),
    /// A part of its pixels in each of these forms; where the other part is another item's, one is missing.
    Two([Option<(Form, Instance)>; 2]),
}

impl Item {
    /// Whether what is drawn of it is the view's choice.
    pub fn has_levels(&self) -> bool {
        let ItemLevels { of_mesh, of_node, of_material } = &self.levels;
        !of_mesh.is_empty() || of_node.is_some() || of_material.is_some()
    }

    /// The level of its node or its material.
    pub fn own_level(&self) -> u32 {
        let ItemLevels { of_node, of_material, .. } = &self.levels;
        of_node.or(*of_material).map_or(0, |tag| tag.level)
    }
}

impl WorldDraws {
    /// The level of detail of a draw: that of its mesh, beyond that of its node or its material.
    pub fn level_of(&self, draw: &Draw) -> u32 {
        self.items.get(draw.item as usize).map_or(0, Item::own_level) + draw.form.level
    }

    /// The indices of an item at a level of its mesh, or its vertices, and the page of indices.
    pub fn elements(&self, item: &Item, level: u32) -> (Range<u32>, Option<u32>) {
        let at = level.checked_sub(1).map(|level| (item.levels.of_mesh.start + level) as usize);
        match at.and_then(|at| self.mesh_levels.elements.get(at)) {
            Some((elements, page)) => (elements.clone(), Some(*page)),
            None => (item.elements.clone(), item.index_page),
        }
    }

    /// Triangles of one instance.
    pub fn triangles(&self, item: &Item, level: u32) -> u64 {
        if item.topology == Topology::Triangles { self.elements(item, level).0.len() as u64 / 3 } else { 0 }
    }

    /// Whether what is drawn of an item is the view's choice.
    pub(super) fn is_chosen(&self, item: &Item, chooser: &Chooser) -> bool {
        item.has_levels() || chooser.reduces_materials() && !item.forms.is_empty()
    }

    fn level_of_mesh(&self, item: &Item, chooser: &Chooser) -> Choice {
        let range = &item.levels.of_mesh;
        if range.is_empty() {
            return Choice::default();
        }
        chooser.of_errors(ball_of(item), &self.mesh_levels.errors_m[range.start as usize..range.end as usize])
    }

    /// What of an item is shown where nothing fades: a level of its mesh, or nothing. Without a chooser the finest is.
    pub fn shown_whole(&self, item: &Item, chooser: Option<&Chooser>) -> Option<u32> {
        let tags = [item.levels.of_node, item.levels.of_material];
        let is_shown = |tag: LevelTag| {
            let nearest = chooser.map_or(0, |chooser| chooser.groups[tag.group as usize].nearest());
            nearest == tag.level
        };
        let of_mesh = || chooser.map_or(0, |chooser| self.level_of_mesh(item, chooser).nearest());
        tags.into_iter().flatten().all(is_shown).then(of_mesh)
    }

    /// What a view shows of an item. Of several levels that change at once, one fades.
    pub(super) fn shown(&self, item: &Item, chooser: &Chooser) -> ItemForms {
        let instance = &self.instances[item.instance as usize];
        let mut fading = None;
        for tag in [item.levels.of_node, item.levels.of_material].into_iter().flatten() {
            let choice = chooser.groups[tag.group as usize];
            let can_fade = fading.is_none() && item.topology != Topology::Points;
            let side = match tag.level.checked_sub(choice.level) {
                Some(0) => Side::Finer,
                Some(1) => Side::Coarser,
                _ => return ItemForms::Nothing,
            };
            match faded(instance, choice.next_share, side).filter(|_| can_fade) {
                Some(instance) => fading = Some(instance),
                None if choice.nearest() != tag.level => return ItemForms::Nothing,
                None => {}
            }
        }
        let of_mesh = self.level_of_mesh(item, chooser);
        let of_surface = chooser.of_surface(ball_of(item), item.forms);
        let whole = Form { level: of_mesh.nearest(), surface: item.forms.at(of_surface.nearest()) };
        if let Some(instance) = fading {
            return ItemForms::Two([Some((whole, instance)), None]);
        }
        let (share, forms) = if of_mesh.next_share > 0.0 {
            let form = |level| Form { level, ..whole };
            (of_mesh.next_share, [form(of_mesh.level), form(of_mesh.level + 1)])
        } else {
            let steps = [of_surface.level, of_surface.level + 1];
            (of_surface.next_share, steps.map(|step| Form { surface: item.forms.at(step), ..whole }))
        };
        let sides = [faded(instance, share, Side::Finer), faded(instance, share, Side::Coarser)];
        match sides {
            [Some(finer), Some(coarser)] if item.topology != Topology::Points => {
                ItemForms::Two([Some((forms[0], finer)), Some((forms[1], coarser))])
            }
            _ => ItemForms::One(whole),
        }
    }
}
