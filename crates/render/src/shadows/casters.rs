//! What casts a shadow into a tile.

use super::column::column_range;
use super::projection::TileProjection;
use crate::constants::WITHOUT_NORMALS;
use crate::draws::{BLOCK_ITEMS, Draw, Faces, Form, Item, WorldDraws};
use crate::levels::Chooser;
use crate::pose::Deformation;
use crate::resources::Instance;
use glam::{Mat3, Quat, Vec2, Vec3, Vec4};
use manypass_scene::{Aabb, Topology};
use std::cell::OnceCell;
use std::hash::{DefaultHasher, Hash, Hasher};

/// What the frame offers to cast shadows.
pub(super) struct Casters<'w> {
    world: &'w WorldDraws,
    /// Chooses levels; without it the finest are taken.
    chooser: Option<&'w Chooser>,
    /// Rises whenever a mesh or a material of the scene changes.
    version: u64,
    sample_index: u32,
    deformation: OnceCell<u64>,
}

/// An item that may cast a shadow of one light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Caster {
    item: u32,
    /// The level of its mesh.
    level: u32,
    /// Whether the light lies within its bounds. Of others a side that the eye would not see casts no shadow either;
    /// but what encloses a light keeps it in, whichever side is within.
    encloses: bool,
}

/// The items that may cast a shadow of one light.
#[derive(Debug, Default)]
pub(super) struct OfLight {
    pub items: Vec<Caster>,
    /// Whether an item was left out because it glows around the light.
    pub is_in_emitter: bool,
}

impl<'w> Casters<'w> {
    pub fn new(world: &'w WorldDraws, chooser: Option<&'w Chooser>, version: u64, sample_index: u32) -> Self {
        Self { world, chooser, version, sample_index, deformation: OnceCell::new() }
    }

    /// Those around a light that reaches `range_m` from one of its points. What emits light and has the light's middle
    /// within its bounds is none: it is the bulb that the light stands for.
    pub fn around(&self, position: Vec3, middle: Vec3, range_m: f32) -> OfLight {
        let is_near = |bounds: &Aabb| {
            let nearest = position.clamp(bounds.min, bounds.max);
            nearest.distance_squared(position) <= range_m * range_m
        };
        let mut of_light = OfLight::default();
        self.each(is_near, |index, level, item| {
            let bounds = &item.bounds_world;
            let holds = |place: Vec3| place.cmpge(bounds.min).all() && place.cmple(bounds.max).all();
            let encloses = holds(position);
            if item.emits && holds(middle) {
                of_light.is_in_emitter = true;
            } else {
                of_light.items.push(Caster { item: index, level, encloses });
            }
        });
        of_light
    }

    /// All of them.
    pub fn everywhere(&self) -> OfLight {
        let mut of_light = OfLight::default();
        self.each(|_| true, |index, level, _| of_light.items.push(Caster { item: index, level, encloses: false }));
        of_light
    }

    fn each(&self, is_near: impl Fn(&Aabb) -> bool, mut give: impl FnMut(u32, u32, &Item)) {
        let mut give = |index: usize, item: &Item| {
            let level = if item.has_levels() { self.world.shown_whole(item, self.chooser) } else { Some(0) };
            level.into_iter().for_each(|level| give(index as u32, level, item));
        };
        let (opaque, _) = self.world.items.split_at(self.world.opaque_count);
        let casts = |item: &Item| item.casts_shadow && item.topology != Topology::Points && is_near(&item.bounds_world);
        for (block, (items, bounds)) in opaque.chunks(BLOCK_ITEMS).zip(&self.world.blocks).enumerate() {
            if bounds.as_ref().is_some_and(|bounds| !is_near(bounds)) {
                continue;
            }
            let first = block * BLOCK_ITEMS;
            let near = items.iter().enumerate().filter(|(_, item)| casts(item));
            near.for_each(|(index, item)| give(first + index, item));
        }
        let blended = self.world.items.iter().enumerate().skip(self.world.opaque_count);
        blended.filter(|(_, item)| casts(item)).for_each(|(index, item)| give(index, item));
    }

    /// Those of `items` that the tile may show.
    pub fn in_tile<'i>(
        &'i self,
        items: &'i [Caster],
        projection: &TileProjection,
    ) -> impl Iterator<Item = Caster> + 'i {
        let planes = projection.planes();
        items.iter().copied().filter(move |caster| !is_outside(&planes, &self.item(caster).bounds_world))
    }

    /// The light-space depth of those of `items` that lie within `half_m` of `center`, a point of the space of
    /// `world_from_light`, in x and y: the nearest to the light and the farthest. None if nothing does.
    pub fn depth_range(
        &self,
        items: &[Caster],
        world_from_light: Quat,
        center: Vec2,
        half_m: f32,
    ) -> Option<(f32, f32)> {
        let light_from_world = Mat3::from_quat(world_from_light.inverse());
        let ranges = items
            .iter()
            .filter_map(|caster| column_range(&self.item(caster).reached_world(), &light_from_world, center, half_m));
        ranges.reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))
    }

    /// What the picture of a tile depends on: two tiles with the same number are alike.
    pub fn signature(&self, items: &[Caster], projection: &TileProjection) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.version.hash(&mut hasher);
        (projection.is_perspective, projection.is_of_ground).hash(&mut hasher);
        for row in projection.rows {
            hasher.write(bytemuck::bytes_of(&row));
        }
        for caster in items {
            let item = self.item(caster);
            let (elements, index_page) = self.world.elements(item, caster.level);
            let (page, mesh) = ((index_page, item.vertex_page), (item.mesh, item.primitive, item.material));
            (mesh, page, elements, item.masked, item.layers, caster.encloses).hash(&mut hasher);
            hasher.write(bytemuck::bytes_of(&self.world.instances[item.instance as usize].world_from_object));
            if item.extent.is_none() {
                self.deformation().hash(&mut hasher);
            }
            if self.is_blended(caster) {
                // Which of its texels let light through is another choice in every sample.
                self.sample_index.hash(&mut hasher);
            }
        }
        hasher.finish()
    }

    fn item(&self, caster: &Caster) -> &Item {
        &self.world.items[caster.item as usize]
    }

    fn is_blended(&self, caster: &Caster) -> bool {
        caster.item as usize >= self.world.opaque_count
    }

    fn deformation(&self) -> u64 {
        *self.deformation.get_or_init(|| {
            let Deformation { joint_rows, morph_weights, .. } = &self.world.deformation;
            let mut hasher = DefaultHasher::new();
            hasher.write(bytemuck::cast_slice(joint_rows));
            hasher.write(bytemuck::cast_slice(morph_weights));
            hasher.finish()
        })
    }

    /// The draws of a tile, whose instances are appended to `instances`.
    pub fn draws(&self, items: &[Caster], projection: &TileProjection, instances: &mut Vec<Instance>) -> Vec<Draw> {
        let mut draws: Vec<Draw> = Vec::new();
        let mut last_group = None;
        for caster in items {
            let item = self.item(caster);
            let faces = if caster.encloses && !self.is_blended(caster) { Faces::Both } else { item.faces };
            let instance = &self.world.instances[item.instance as usize];
            let at = instances.len() as u32;
            let is_skinned = instance.ids[1] != u32::MAX;
            let rows = if is_skinned {
                // Joints take the mesh into the world.
                projection.rows.map(|row| row.to_array())
            } else {
                projection.of_object(&instance.world_from_object)
            };
            let [object, joint, weight, targets] = instance.ids;
            // The object has a part in which rays its alpha stops.
            let of_tile = u32::from(projection.is_of_ground) << 1 | u32::from(projection.is_perspective);
            let ids = [(object & !WITHOUT_NORMALS) << 2 | of_tile, joint, weight, targets];
            instances.push(Instance { world_from_object: rows, ids, ..*instance });
            let group = (item.group, faces, caster.level);
            match draws.last_mut().filter(|_| last_group == Some(group)) {
                Some(last) => last.instances.end = at + 1,
                None => draws.push(Draw {
                    item: caster.item,
                    form: Form { level: caster.level, ..Form::default() },
                    fades: false,
                    is_decaled: false,
                    faces,
                    instances: at..at + 1,
                }),
            }
            last_group = Some(group);
        }
        draws
    }
}

fn is_outside(planes: &[Vec4; 5], bounds: &Aabb) -> bool {
    let (center, half) = (0.5 * (bounds.min + bounds.max), 0.5 * (bounds.max - bounds.min));
    planes.iter().any(|plane| {
        let normal = plane.truncate();
        normal.dot(center) + plane.w + normal.abs().dot(half) < 0.0
    })
}
