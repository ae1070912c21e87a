//! What one view draws: those of the world's items that it may show.

use super::Faces;
use super::leveled::{Form, ItemForms};
use super::still::ListOf;
use super::world::{BLOCK_ITEMS, Item, WorldDraws};
use crate::levels::LevelCount;
use crate::resources::Instance;
use glam::{Mat4, Vec2, Vec3, Vec4};
use manypass_scene::{Aabb, Topology};
use std::ops::Range;

/// So many vertices that nobody sees are drawn rather than a draw call more: a GPU takes a thousand million vertices a
/// second, and a call about a microsecond in a browser.
const HIDDEN_ELEMENTS_MAX: u64 = 1536;

/// One draw call.
#[derive(Clone, Debug)]
pub(crate) struct Draw {
    /// Index of an item: what is drawn, and with which material.
    pub item: u32,
    /// In which form.
    pub form: Form,
    /// Whether it draws the pixels alone that its instance says, because two levels fade into each other.
    pub fades: bool,
    /// Which sides of its triangles.
    pub faces: Faces,
    /// Whether decals may touch it.
    pub is_decaled: bool,
    /// Which of the world's instances; of points, one for every corner of a disc.
    pub instances: Range<u32>,
}

/// The draws of one view.
#[derive(Debug, Default)]
pub(crate) struct DrawList {
    /// Opaque and masked surfaces, by program, material and mesh.
    pub opaque: Vec<Draw>,
    /// Of the opaque and masked surfaces those that decals may touch.
    pub decaled: Vec<Draw>,
    /// Surfaces that light comes through, farther ones first.
    pub transmissive: Vec<Draw>,
    /// Blended surfaces, farther ones first; of those with two sides the back faces before the front faces.
    pub blended: Vec<Draw>,
    /// Triangles of all draws.
    pub triangles: u64,
    /// What of them is of each level, of all that has levels.
    pub levels: Vec<LevelCount>,
    /// The instances of what fades, which this view alone has: they follow those of the world.
    fading: Vec<Instance>,
}

impl DrawList {
    /// Everything of `world` in one of the layers that a view may show, at the levels that are chosen. What fades has
    /// instances of its own, which are added to the world's.
    pub(super) fn new(world: &mut WorldDraws, of: &ListOf<'_>) -> Self {
        let frustum = Frustum::new(&of.view.clip_from_world, of.room_ndc());
        let mut list = Self::default();
        list.add_opaque(world, &frustum, of);
        list.add_blended(world, &frustum, of);
        world.instances.append(&mut list.fading);
        list
    }

    fn add_opaque(&mut self, world: &WorldDraws, frustum: &Frustum, of: &ListOf<'_>) {
        let (list, ListOf { layers, chooser, .. }) = (self, *of);
        let opaque = &world.items[..world.opaque_count];
        let mut last_group = None;
        let mut fading = FadingDraws::default();
        for (block, (items, bounds)) in opaque.chunks(BLOCK_ITEMS).zip(&world.blocks).enumerate() {
            let sight = bounds.map_or(Sight::Part, |bounds| frustum.sight(&bounds));
            if sight == Sight::None {
                continue;
            }
            if let (Sight::Whole, [first, .., last]) = (sight, items)
                && world.alike.get(block) == Some(&true)
                && first.view_layers & layers != 0
                && !world.is_chosen(first, chooser)
            {
                // As each of them would be.
                if fading.group != first.group {
                    list.append_fading(&mut fading, world);
                    fading.group = first.group;
                }
                let index = ((block * BLOCK_ITEMS) as u32, Form::default());
                list.append_opaque(index, world, last_group == Some(first.group));
                list.append_rest(last, items.len() as u64 - 1, world);
                last_group = Some(first.group);
                continue;
            }
            for (index, item) in items.iter().enumerate() {
                if sight == Sight::Part && frustum.excludes(item) {
                    continue;
                }
                if item.view_layers & layers == 0 {
                    // No draw goes on over what is not to be seen at all.
                    last_group = None;
                    continue;
                }
                let index = (block * BLOCK_ITEMS + index) as u32;
                if fading.group != item.group {
                    list.append_fading(&mut fading, world);
                    fading.group = item.group;
                }
                if !world.is_chosen(item, chooser) {
                    list.append_opaque((index, Form::default()), world, last_group == Some(item.group));
                    last_group = Some(item.group);
                    continue;
                }
                match world.shown(item, chooser) {
                    ItemForms::Nothing => last_group = None,
                    ItemForms::One(form) => {
                        let is_alike = list.opaque.last().is_some_and(|last| last.form == form);
                        list.append_opaque((index, form), world, is_alike && last_group == Some(item.group));
                        last_group = Some(item.group);
                    }
                    ItemForms::Two(parts) => {
                        for (form, instance) in parts.into_iter().flatten() {
                            list.count(item, form.level, world);
                            fading.add(index, form, instance);
                        }
                        last_group = None;
                    }
                }
            }
            // Draws stay with the items that are culled together; what follows goes on with none of them.
            if !fading.by_form.is_empty() {
                list.append_fading(&mut fading, world);
                last_group = None;
            }
        }
    }

    fn add_blended(&mut self, world: &WorldDraws, frustum: &Frustum, of: &ListOf<'_>) {
        let (list, ListOf { view, layers, chooser, .. }) = (self, *of);
        let blended = &world.items[world.opaque_count..];
        let distance_m = |item: &Item| -view.view_from_world.transform_point3(item.center).z;
        let mut visible: Vec<(f32, u32)> = blended
            .iter()
            .enumerate()
            .filter(|(_, item)| item.view_layers & layers != 0 && !frustum.excludes(item))
            .map(|(index, item)| (distance_m(item), (world.opaque_count + index) as u32))
            .collect();
        visible.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, index) in visible {
            let item = &world.items[index as usize];
            match world.shown(item, chooser) {
                ItemForms::Nothing => {}
                ItemForms::One(form) => {
                    list.count(item, form.level, world);
                    let instances = item.instances();
                    list.append_blended(
                        item,
                        Draw { item: index, form, fades: false, is_decaled: false, faces: item.faces, instances },
                    );
                }
                ItemForms::Two(parts) => {
                    for part in parts.into_iter().flatten() {
                        let draw = list.fading_draw(index, world, part);
                        list.append_blended(item, draw);
                    }
                }
            }
        }
    }

    /// Opaque surfaces from now on are drawn from behind, too.
    pub fn show_backs(&mut self) {
        self.opaque.iter_mut().for_each(|draw| draw.faces = Faces::Both);
    }

    /// All that the eye may meet first, as if it were opaque.
    pub fn first_surfaces(&self) -> Self {
        let opaque = [&self.opaque[..], &self.transmissive, &self.blended].concat();
        let others = self.transmissive.iter().chain(&self.blended).filter(|draw| draw.is_decaled);
        let decaled = self.decaled.iter().chain(others).cloned().collect();
        Self { opaque, decaled, triangles: self.triangles, ..Self::default() }
    }

    /// A draw of what fades, with an instance of its own.
    fn fading_draw(&mut self, index: u32, world: &WorldDraws, (form, instance): (Form, Instance)) -> Draw {
        let item = &world.items[index as usize];
        self.count(item, form.level, world);
        let at = (world.instances.len() + self.fading.len()) as u32;
        self.fading.push(instance);
        Draw { item: index, form, fades: true, is_decaled: false, faces: item.faces, instances: at..at + 1 }
    }

    /// Adds the draws of what fades of a group.
    fn append_fading(&mut self, draws: &mut FadingDraws, world: &WorldDraws) {
        for (index, form, instances) in draws.by_form.drain(..) {
            let first = (world.instances.len() + self.fading.len()) as u32;
            let faces = world.items[index as usize].faces;
            let instances_of_view = first..first + instances.len() as u32;
            self.fading.extend(instances);
            self.opaque.push(Draw {
                item: index,
                form,
                fades: true,
                is_decaled: false,
                faces,
                instances: instances_of_view,
            });
        }
    }

    /// Counts what is drawn.
    fn count(&mut self, item: &Item, level: u32, world: &WorldDraws) {
        let triangles = world.triangles(item, level);
        self.triangles += triangles;
        if item.has_levels() {
            let at = (level + item.own_level()) as usize;
            self.levels.resize(self.levels.len().max(at + 1), LevelCount::default());
            self.levels[at].primitives += 1;
            self.levels[at].triangles += triangles;
        }
    }

    fn append_opaque(&mut self, (index, form): (u32, Form), world: &WorldDraws, goes_on: bool) {
        let item = &world.items[index as usize];
        let (instances, level) = (item.instances(), form.level);
        self.count(item, level, world);
        if let Some(last) = self.opaque.last_mut().filter(|_| goes_on) {
            let between = u64::from(instances.start - last.instances.end);
            let elements = world.elements(item, level).0.len() as u64;
            if between * elements <= HIDDEN_ELEMENTS_MAX {
                self.triangles += between * world.triangles(item, level);
                last.instances.end = instances.end;
                return;
            }
        }
        self.opaque.push(Draw { item: index, form, fades: false, is_decaled: false, faces: item.faces, instances });
    }

    /// Goes on with the last draw up to `item`, with so many more that are like it.
    fn append_rest(&mut self, item: &Item, count: u64, world: &WorldDraws) {
        self.triangles += count * world.triangles(item, 0);
        if let Some(last) = self.opaque.last_mut() {
            last.instances.end = item.instances().end;
        }
    }

    fn append_blended(&mut self, item: &Item, draw: Draw) {
        if item.transmissive {
            self.transmissive.push(draw);
            return;
        }
        if item.faces == Faces::Both && item.topology == Topology::Triangles {
            // What a solid's back faces let through lies behind what its front faces let through.
            self.blended.extend([Faces::Back, Faces::Front].map(|faces| Draw { faces, ..draw.clone() }));
        } else {
            self.blended.push(draw);
        }
    }
}

/// What fades of neighbouring items that differ in nothing but their instances: all in one form are one draw.
#[derive(Debug, Default)]
struct FadingDraws {
    group: u32,
    /// The first item of each form, and the instances.
    by_form: Vec<(u32, Form, Vec<Instance>)>,
}

impl FadingDraws {
    fn add(&mut self, item: u32, form: Form, instance: Instance) {
        match self.by_form.iter_mut().find(|(_, known, _)| *known == form) {
            Some((_, _, instances)) => instances.push(instance),
            None => self.by_form.push((item, form, vec![instance])),
        }
    }
}

/// How much of something a view may show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sight {
    None,
    Part,
    Whole,
}

/// Whether a view may show something of an upright box.
pub(crate) fn may_show(clip_from_world: &Mat4, bounds_world: &Aabb) -> bool {
    Frustum::new(clip_from_world, Vec2::ZERO).sight(bounds_world) != Sight::None
}

/// The planes of a view's frustum: a point lies inside where the distance to all is at least 0.
struct Frustum([Vec4; 6]);

impl Frustum {
    /// With so much room beside the picture, in normalised device coordinates.
    fn new(clip_from_world: &Mat4, room_ndc: Vec2) -> Self {
        let [x, y, z, w] = [0, 1, 2, 3].map(|row| clip_from_world.row(row));
        let [beside, above] = (Vec2::ONE + room_ndc).to_array().map(|share| share * w);
        Self([beside + x, beside - x, above + y, above - y, w - z, z])
    }

    /// How much of an upright box lies inside.
    fn sight(&self, bounds: &Aabb) -> Sight {
        let (center, half) = (0.5 * (bounds.min + bounds.max), 0.5 * (bounds.max - bounds.min));
        let mut sight = Sight::Whole;
        for plane in &self.0 {
            let normal = plane.truncate();
            let (distance, reach) = (normal.dot(center) + plane.w, normal.abs().dot(half));
            if distance + reach < 0.0 {
                return Sight::None;
            }
            // Where a distance is no number, items are looked at one by one.
            let is_inside = distance - reach >= 0.0;
            sight = if is_inside { sight } else { Sight::Part };
        }
        sight
    }

    /// Whether nothing of `item` can be seen: the whole of its box lies outside one of the planes, or it has none.
    fn excludes(&self, item: &Item) -> bool {
        let Some(extent) = &item.extent else { return false };
        self.0.iter().any(|plane| {
            let normal = plane.truncate();
            let distance = normal.dot(item.center) + plane.w;
            let reach = || extent.0.iter().map(|axis: &Vec3| normal.dot(*axis).abs()).sum::<f32>();
            // Most middles lie inside.
            distance < 0.0 && distance + reach() < 0.0
        })
    }
}
