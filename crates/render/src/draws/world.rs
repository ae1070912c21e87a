//! The instances of a frame: every primitive of every visible node, posed once, in the order in which they are drawn.

use super::ball::Ball;
use super::leveled::{ItemLevels, LevelTag, MeshLevels, NodeGroups, group_of};
use super::posed_primitive::{NodeDeformation, PosedPrimitive, program_key};
use super::still::{KnownLists, WorldInputs, flat_nodes, next_version};
use super::{Axes, Faces, NORMAL_MAP, OCCLUSION_APART, PLACES_UVS, TEXTURED};
use crate::constants::{LAYER_LIGHT_MAP, WITHOUT_NORMALS};
use crate::decals::SharedDecals;
use crate::levels::{Group, SurfaceForm, SurfaceForms};
use crate::lights::ObjectBounds;
use crate::pose::Deformation;
use crate::resources::layers::{SEEN_LARGE, SHADED_WHERE_DRAWN};
use crate::resources::{Cloud, FactorsOf, Instance, SceneResources};
use glam::{Mat4, Vec3, Vec4};
use manypass_scene::{Aabb, NodeId, Scene, Topology};
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// A primitive of a node.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    /// Index of the mesh.
    pub mesh: u32,
    /// Index of the primitive in the mesh.
    pub primitive: u32,
    /// Index of the material.
    pub material: u32,
    /// Items of one group follow each other, and differ in nothing but their instances.
    pub group: u32,
    /// Its first instance; points have four, the others one.
    pub instance: u32,
    /// Its indices in their page, or where it has none its vertices in what is bound.
    pub elements: Range<u32>,
    /// The page of its indices, if it is indexed.
    pub index_page: Option<u32>,
    /// The page of its vertices; none if they are bound for themselves.
    pub vertex_page: Option<u32>,
    /// What the elements form.
    pub topology: Topology,
    /// What its program has to do.
    pub axes: Axes,
    /// Whether its fragments may be dropped.
    pub masked: bool,
    /// Whether the transform turns the triangles around.
    pub mirrored: bool,
    /// Which sides of its triangles.
    pub faces: Faces,
    /// None if it is deformed, so that only an upright box is known.
    pub extent: Option<Extent>,
    /// An upright box around it; it may be too large.
    pub bounds_world: Aabb,
    /// How far its relief reaches from its triangles, in metres.
    pub relief_m: f32,
    /// The boxes around its parts in object space, if they are known.
    pub parts: Option<Arc<[Aabb]>>,
    /// The boxes around its points, where it has many.
    pub cloud: Option<Arc<Cloud>>,
    /// Whether it keeps light from what lies behind it.
    pub casts_shadow: bool,
    /// The layers of its node, a bit each.
    pub view_layers: u32,
    /// The bits of its material's layers and detail; 0 if it has neither.
    pub layers: u32,
    /// Whether its baked light has directions.
    pub has_light_directions: bool,
    /// Whether what lies behind is seen through it.
    pub transmissive: bool,
    /// Whether it is the surface of a body that light goes through, which bends it twice.
    pub bends_twice: bool,
    /// Whether its material emits light.
    pub emits: bool,
    /// Whether it has radiance before any light reaches it: what emits, what is unlit, and what has no normals.
    pub glows: bool,
    /// Whether it may reflect as sharply as reflections of the picture are found for each pixel.
    pub may_be_smooth: bool,
    /// What tells its distance, in world space.
    pub center: Vec3,
    /// Its levels of detail, and those that it is one of.
    pub levels: ItemLevels,
    /// What its surface may be drawn as where it is seen small.
    pub forms: SurfaceForms,
}

impl Item {
    /// Its instance.
    pub fn instances(&self) -> Range<u32> {
        self.instance..self.instance + 1
    }

    /// The box around it with its relief, which lies below its triangles.
    pub fn reached_world(&self) -> Aabb {
        let bounds = &self.bounds_world;
        if bounds.is_empty() {
            *bounds
        } else {
            Aabb { min: bounds.min - self.relief_m, max: bounds.max + self.relief_m }
        }
    }

    /// The bits of its layers and detail where its surface has a form.
    pub fn layers_in(&self, form: SurfaceForm) -> u32 {
        match form {
            SurfaceForm::Whole => self.layers,
            SurfaceForm::Plain | SurfaceForm::Untextured if self.forms.has(SurfaceForm::Plain) => {
                self.layers & LAYER_LIGHT_MAP
            }
            _ => self.layers & !SEEN_LARGE,
        }
    }

    /// What its program has to do where its surface has a form.
    pub fn axes_in(&self, form: SurfaceForm) -> Axes {
        self.axes
            & !match form {
                SurfaceForm::Whole => 0,
                SurfaceForm::Smooth | SurfaceForm::Plain => NORMAL_MAP,
                SurfaceForm::Untextured => NORMAL_MAP | TEXTURED | OCCLUSION_APART | PLACES_UVS,
            }
    }

    /// The factors of its material where its surface has a form.
    pub fn factors_in(&self, form: SurfaceForm) -> FactorsOf {
        // Whether what the G-buffer holds is all that it has in this form, but not in the whole.
        let is_reduced = self.layers & SHADED_WHERE_DRAWN != 0 && self.layers_in(form) & SHADED_WHERE_DRAWN == 0;
        match form {
            SurfaceForm::Untextured => FactorsOf::Untextured,
            _ if is_reduced => FactorsOf::Plain,
            _ => FactorsOf::Whole,
        }
    }
}

/// So many items are tested together before each is for itself.
pub(crate) const BLOCK_ITEMS: usize = 128;

/// Half the edges of a box in world space, which need not be upright.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent(pub [Vec3; 3]);

impl Extent {
    /// The upright box around the box around `center`.
    pub(super) fn around(&self, center: Vec3) -> Aabb {
        let half: Vec3 = self.0.iter().map(|axis| axis.abs()).sum();
        Aabb { min: center - half, max: center + half }
    }
}

/// Everything that may be drawn in a frame. It lasts from frame to frame, as mostly the next one is like the last.
#[derive(Debug, Default)]
pub(crate) struct WorldDraws {
    /// Opaque and masked ones first, by program, material and mesh.
    pub items: Vec<Item>,
    /// How many of them neither blend nor let light through.
    pub opaque_count: usize,
    /// Whether any has layers or detail, in view or not, so that a camera that moves changes no pass.
    pub has_layers: bool,
    /// Whether any is shaded where it is drawn, though it neither blends nor lets light through.
    pub is_shaded_where_drawn: bool,
    /// Whether light comes through any, in view or not.
    pub has_transmissive: bool,
    /// The box around every [`BLOCK_ITEMS`] of them, in world space; none where one is deformed.
    pub blocks: Vec<Option<Aabb>>,
    /// Of the same blocks, whether no view draws one item of them otherwise than another.
    pub(super) alike: Vec<bool>,
    /// Another number whenever an item or an instance may be another; a view's instances are none of them.
    pub version: u64,
    /// What the items refer to.
    pub instances: Vec<Instance>,
    /// Joints and weights that the instances refer to.
    pub deformation: Deformation,
    /// The nodes that give light.
    pub lit: Vec<NodeId>,
    /// The decals that are shown.
    pub decals: SharedDecals,
    /// The box around everything, in world space.
    pub bounds_world: Aabb,
    /// The box around what is drawn as no item, water and portals.
    pub flat_bounds_world: Aabb,
    /// Whether any of those that do not blend glows, in view or not, so that a camera that moves changes no pass.
    pub glows: bool,
    /// Whether any of those that do not blend may be smooth, in view or not.
    pub may_be_smooth: bool,
    /// The same two without what decals add.
    items_glow: bool,
    items_may_be_smooth: bool,
    /// Coarser forms of items.
    pub mesh_levels: MeshLevels,
    /// What has levels of a file.
    pub groups: Vec<Group>,
    /// The lists of views of this frame, and those of the last one that no view of this one has asked for yet.
    pub(super) lists: KnownLists,
    /// Whether this frame made the items, and did not keep those of the last one.
    pub(super) is_posed: bool,
    /// What the items were made from; none if that has to be done in each frame.
    made_from: Option<WorldInputs>,
    posed: Vec<PosedItem>,
    /// Of all that is posed, for this frame and for the one that `order` is of.
    keys: [Vec<Key>; 2],
    /// Places in `posed` in the order of their keys; of equal keys the first comes first.
    order: Vec<u32>,
}

/// A primitive of a node in the order of the nodes, before its place is known.
#[derive(Debug)]
struct PosedItem {
    item: Item,
    instance: Instance,
}

/// What the items are sorted by: items with an equal key can be one draw.
type Key = (u64, u64);

/// The bit of a key's first number that is set if the surface blends.
const BLENDED: u64 = 1 << 63;

impl WorldDraws {
    /// Poses everything visible of `scene`, unless that is as it was.
    pub fn update(&mut self, scene: &Scene, resources: &SceneResources) {
        self.lists.begin();
        if self.made_from.as_ref().is_some_and(|inputs| inputs.are_those_of(scene, resources)) {
            // Views and decals have added to these.
            self.instances.truncate(self.items.len());
            self.deformation.clear();
            (self.glows, self.may_be_smooth) = (self.items_glow, self.items_may_be_smooth);
            self.is_posed = false;
            return;
        }
        self.pose(scene, resources);
        self.is_posed = true;
        self.lists.clear();
        self.version = next_version();
        (self.items_glow, self.items_may_be_smooth) = (self.glows, self.may_be_smooth);
        self.made_from = self.deformation.is_empty().then(|| WorldInputs::of(scene, resources));
    }

    fn pose(&mut self, scene: &Scene, resources: &SceneResources) {
        self.items.clear();
        self.blocks.clear();
        self.alike.clear();
        self.instances.clear();
        self.lit.clear();
        self.posed.clear();
        self.deformation.clear();
        self.keys[0].clear();
        self.mesh_levels.clear();
        self.groups.clear();
        self.bounds_world = Aabb::EMPTY;
        self.flat_bounds_world = Aabb::EMPTY;
        let flat: BTreeSet<NodeId> = flat_nodes(scene).collect();
        let mut groups = NodeGroups::default();
        for (id, of) in scene.visible_levels() {
            let node = scene.node(id);
            self.bounds_world = self.bounds_world.union(&node.bounds_world);
            // Light is that of the finest level, whichever is seen.
            if node.light.is_some() && of.is_none_or(|of| of.level == 0) {
                self.lit.push(id);
            }
            let level = of.map(|of| groups.add(scene, of, (node, &resources.geometry), &mut self.groups));
            if flat.contains(&id) {
                self.flat_bounds_world = self.flat_bounds_world.union(&node.bounds_world);
            }
            // Water and portals are drawn as such, and cast no shadow.
            if let Some(mesh) = node.mesh.filter(|_| !flat.contains(&id)) {
                self.collect(scene, resources, (id, level), mesh);
            }
        }
        groups.close(&mut self.groups);
        let [keys, sorted_keys] = &mut self.keys;
        if keys != sorted_keys {
            self.order = (0..keys.len() as u32).collect();
            self.order.sort_by_key(|at| keys[*at as usize]);
            sorted_keys.clone_from(keys);
        }
        self.place();
    }

    /// Where objects lie, by object id. One whose box is not known lies everywhere.
    pub fn object_bounds(&self) -> ObjectBounds {
        let mut bounds = ObjectBounds::default();
        for item in &self.items {
            let id = self.instances.get(item.instance as usize).map_or(0, object_id);
            bounds.add(id, item.extent.as_ref().map(|_| item.bounds_world));
        }
        bounds
    }

    /// No surface before `eye`, in the direction `forward`, is nearer than this, in metres, by the boxes around parts of
    /// it; infinite if there is none.
    pub fn nearest_m(&self, eye: Vec3, forward: Vec3) -> f32 {
        let distance_m = |bounds: &Aabb| {
            let (center, half) = (0.5 * (bounds.min + bounds.max), 0.5 * (bounds.max - bounds.min));
            let is_behind = forward.dot(center - eye) + forward.abs().dot(half) < 0.0;
            if is_behind { f32::INFINITY } else { eye.clamp(bounds.min, bounds.max).distance(eye) }
        };
        let flat = Some(&self.flat_bounds_world).filter(|bounds| !bounds.is_empty());
        let mut nearest_m = flat.map_or(f32::INFINITY, distance_m);
        for item in &self.items {
            let of_item = distance_m(&item.bounds_world);
            // Where a distance is no number, nothing is known.
            if of_item >= nearest_m || item.bounds_world.is_empty() {
                continue;
            }
            let Some(parts) = &item.parts else {
                nearest_m = of_item;
                continue;
            };
            let [x, y, z] = self.instances[item.instance as usize].world_from_object.map(Vec4::from_array);
            let world_from_object = Mat4::from_cols(x, y, z, Vec4::W).transpose();
            let of_parts = parts.iter().filter(|part| !part.is_empty());
            let of_parts = of_parts.map(|part| distance_m(&part.transformed(&world_from_object)));
            nearest_m = of_parts.fold(nearest_m, f32::min);
        }
        nearest_m
    }

    /// Puts what is posed into its order, and gives it its instances.
    fn place(&mut self) {
        self.opaque_count = 0;
        self.glows = false;
        self.may_be_smooth = false;
        self.has_layers = false;
        self.has_transmissive = false;
        self.is_shaded_where_drawn = false;
        let mut last = None;
        let mut group = 0;
        for at in &self.order {
            let (posed, key) = (&self.posed[*at as usize], self.keys[0][*at as usize]);
            group += u32::from(last.is_some_and(|last| last != key));
            last = Some(key);
            let is_opaque = key.0 & BLENDED == 0;
            self.opaque_count += usize::from(is_opaque);
            self.glows |= is_opaque && posed.item.glows;
            self.may_be_smooth |= is_opaque && posed.item.may_be_smooth;
            self.has_layers |= posed.item.layers != 0;
            self.has_transmissive |= posed.item.transmissive;
            self.is_shaded_where_drawn |= posed.item.layers & SHADED_WHERE_DRAWN != 0;
            let instance = self.instances.len() as u32;
            self.instances.push(posed.instance);
            if self.items.len().is_multiple_of(BLOCK_ITEMS) {
                self.blocks.push(Some(Aabb::EMPTY));
            }
            if let Some(block) = self.blocks.last_mut() {
                let bounds = posed.item.extent.as_ref().map(|_| posed.item.bounds_world);
                *block = block.zip(bounds).map(|(block, bounds)| block.union(&bounds));
            }
            let item = Item { group, instance, ..posed.item.clone() };
            if self.items.len().is_multiple_of(BLOCK_ITEMS) {
                self.alike.push(!item.has_levels());
            } else if let (Some(alike), Some(before)) = (self.alike.last_mut(), self.items.last()) {
                *alike &= item.is_like(before);
            }
            self.items.push(item);
        }
    }

    fn collect(
        &mut self,
        scene: &Scene,
        resources: &SceneResources,
        (id, node_level): (NodeId, Option<LevelTag>),
        mesh: usize,
    ) {
        let node = scene.node(id);
        let reduced = &resources.reduced;
        let primitives = resources.geometry.primitives(mesh);
        let mut of_node = NodeDeformation::default();
        for (index, primitive) in primitives.iter().enumerate() {
            if let (Some(skin), true, None) = (node.skin, primitive.skin.is_some(), of_node.joints) {
                of_node.joints = Some(self.deformation.joints_of(scene, skin));
            }
            if primitive.morph_count > 0 && of_node.first_weight.is_none() {
                let default_weights = scene.meshes.get(mesh).map_or(&[][..], |mesh| &mesh.default_morph_weights);
                let weights = if node.morph_weights.is_empty() { default_weights } else { &node.morph_weights };
                of_node.first_weight = Some(self.deformation.append_weights(weights, primitive.morph_count));
            }
            let deformed = NodeDeformation {
                joints: of_node.joints.filter(|_| primitive.skin.is_some()),
                first_weight: of_node.first_weight.filter(|_| primitive.morph_count > 0),
            };
            if deformed.joints.is_none() && deformed.first_weight.is_none() && primitive.bounds.is_empty() {
                continue;
            }
            let drawn = |material: usize| {
                let (properties, layers_deform) = (resources.materials.get(material), resources.layers_deform);
                PosedPrimitive { node, primitive, properties, deformed, reduced, layers_deform }
            };
            let own = primitive.material_in(scene.variant);
            let mesh_levels = self.mesh_levels.append(primitive, node, deformed.joints.is_some());
            let levels = ItemLevels { of_mesh: mesh_levels, of_node: node_level, of_material: None };
            let place = (mesh, index);
            let coarser = own.and_then(|own| scene.materials.get(own)).and_then(|material| material.levels.as_ref());
            let Some(coarser) = coarser else {
                let material = resources.materials.index(own);
                self.push(drawn(material), (id, place, material), levels);
                continue;
            };
            // The same surface once for each of its materials, of which views show one.
            let group = self.groups.len() as u32;
            let all = std::iter::once(own).chain(coarser.coarser.iter().copied().map(Some)).enumerate();
            for (level, material) in all {
                let material = resources.materials.index(material);
                let of_material = Some(LevelTag { group, level: level as u32 });
                self.push(drawn(material), (id, place, material), ItemLevels { of_material, ..levels.clone() });
            }
            let is_deformed = deformed.joints.is_some() || deformed.first_weight.is_some();
            let rigid = (!is_deformed).then_some((&primitive.bounds, primitive.radius_m));
            self.groups.push(group_of(&Ball::of_node(node, rigid), coarser));
        }
    }

    /// Adds an item.
    fn push(
        &mut self,
        drawn: PosedPrimitive<'_>,
        (id, (mesh, index), material): (NodeId, (usize, usize), usize),
        levels: ItemLevels,
    ) {
        let mut item =
            Item { mesh: mesh as u32, primitive: index as u32, material: material as u32, levels, ..drawn.item() };
        item.forms = drawn.forms(&item);
        item.relief_m = drawn.relief_m(&item);
        self.bounds_world = self.bounds_world.union(&item.reached_world());
        self.keys[0].push(if drawn.properties.blended || item.transmissive {
            (BLENDED, self.posed.len() as u64)
        } else {
            let program = u64::from(program_key(drawn.properties, drawn.is_deformed()));
            let mesh = (mesh as u64) << 32 | (index as u64) << 1 | u64::from(item.mirrored);
            (program << 32 | material as u64, mesh)
        });
        self.posed.push(PosedItem { item, instance: drawn.instance(id) });
    }
}

/// The object id of an instance: the index of its node, plus 1.
pub(crate) fn object_id(instance: &Instance) -> u32 {
    instance.ids[0] & !WITHOUT_NORMALS
}
