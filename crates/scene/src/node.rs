//! The arena of nodes.

use crate::capture::{LAYERS_DEFAULT, Mirror};
use crate::decal::Decal;
use crate::environment::{BrdfTable, EnvironmentMap};
use crate::node_id::NodeId;
use crate::nodes::Nodes;
use crate::overlay::Overlay;
use crate::particles::Particles;
use crate::portal::Portal;
use crate::probes::ProbeGrid;
use crate::simulation::Simulation;
use crate::skins::PosedSkins;
use crate::surroundings::Surroundings;
use crate::water::Water;
use crate::{Aabb, Animation, Camera, Image, Levels, Light, Material, Mesh, SceneRoots, Skin, Texture};
use glam::{Mat4, Quat, Vec3};
use std::sync::{Arc, Weak};

/// A node: a transform in the scene, with what it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The name in the file; empty if it has none.
    pub name: String,
    /// The parent; none for a root.
    pub parent: Option<NodeId>,
    /// The children.
    pub children: Vec<NodeId>,
    /// Translation from the parent, in metres.
    pub translation: Vec3,
    /// Rotation from the parent.
    pub rotation: Quat,
    /// Scale from the parent.
    pub scale: Vec3,
    /// A matrix that stands in for translation, rotation and scale where a file gives one that does not decompose.
    pub matrix: Option<Mat4>,
    /// Index into [`Scene::meshes`].
    pub mesh: Option<usize>,
    /// Index into [`Scene::skins`].
    pub skin: Option<usize>,
    /// Index into [`Scene::cameras`].
    pub camera: Option<usize>,
    /// Index into [`Scene::lights`].
    pub light: Option<usize>,
    /// The weights of the mesh's morph targets; empty means the mesh's own.
    pub morph_weights: Vec<f32>,
    /// Whether the node, and all below it, is drawn and gives light.
    pub is_visible: bool,
    /// Whether its mesh keeps light from what lies behind it; not inherited.
    pub casts_shadow: bool,
    /// The layers that its mesh is in, a bit each: views show what is in one of theirs. Not inherited; light and shadows
    /// are those of all layers.
    pub layers: u32,
    /// What takes the place of this node, and of all below it, where it is seen small. Those nodes have the same
    /// parent, but are none of its children, so that [`Scene::visible_nodes`] knows the finest alone; those within a
    /// level have none themselves.
    pub levels: Option<Levels<NodeId>>,
    /// `world_from_object`, as of the last [`Scene::update_transforms`].
    pub world_from_object: Mat4,
    /// A box in world space around the node's mesh, posed by skin and morph targets, as of the last
    /// [`Scene::update_transforms`]; it may be too large, never too small.
    pub bounds_world: Aabb,
    /// What the last [`Scene::update_transforms`] has seen.
    pub placed: LastPlace,
}

/// The state of a node at the last [`Scene::update_transforms`], to find out whether it has moved.
#[derive(Clone, Debug, Default)]
pub struct LastPlace(Option<Place>);

impl PartialEq for LastPlace {
    /// Two nodes are the same, whatever has been seen of them.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

#[derive(Clone, Debug)]
struct Place {
    parent: Option<NodeId>,
    local: (Vec3, Quat, Vec3, Option<Mat4>),
    /// A mesh that is changed moves to another place in memory while this holds on to its former one.
    mesh: Option<Weak<Mesh>>,
    skin: Option<usize>,
    morph_weights: Vec<f32>,
}

impl Default for Node {
    fn default() -> Self {
        Self {
            name: String::new(),
            parent: None,
            children: Vec::new(),
            translation: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            scale: Vec3::ONE,
            matrix: None,
            mesh: None,
            skin: None,
            camera: None,
            light: None,
            morph_weights: Vec::new(),
            is_visible: true,
            casts_shadow: true,
            layers: LAYERS_DEFAULT,
            levels: None,
            world_from_object: Mat4::IDENTITY,
            bounds_world: Aabb::EMPTY,
            placed: LastPlace::default(),
        }
    }
}

impl Node {
    /// How much longer, at most, an axis of the node's mesh is in world space.
    pub fn scale_max(&self) -> f32 {
        let matrix = &self.world_from_object;
        [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.length()).into_iter().fold(0.0, f32::max)
    }

    fn place(&self, mesh: Option<&Arc<Mesh>>) -> Place {
        Place {
            parent: self.parent,
            local: (self.translation, self.rotation, self.scale, self.matrix),
            mesh: mesh.map(Arc::downgrade),
            skin: self.skin,
            morph_weights: self.morph_weights.clone(),
        }
    }

    fn stands_still(&self) -> bool {
        self.placed.0.as_ref().is_some_and(|place| {
            place.parent == self.parent && place.local == (self.translation, self.rotation, self.scale, self.matrix)
        })
    }

    fn keeps_its_shape(&self, mesh: Option<&Arc<Mesh>>) -> bool {
        self.placed.0.as_ref().is_some_and(|place| {
            place.mesh.as_ref().map(Weak::as_ptr) == mesh.map(Arc::as_ptr)
                && place.skin == self.skin
                && place.morph_weights == self.morph_weights
        })
    }

    /// `parent_from_object`.
    pub fn local_matrix(&self) -> Mat4 {
        self.matrix
            .unwrap_or_else(|| Mat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation))
    }
}

/// A scene: everything that can be drawn.
///
/// All of it may be changed between two frames. Whoever draws the scene finds out what is new: values are compared,
/// meshes and the texels of images by their place in memory, which [`Arc::make_mut`] changes. Call
/// [`Self::update_transforms`] afterwards.
///
/// ```
/// # use manypass_scene::{Mesh, Node, NodeId, Scene, primitives};
/// # use std::sync::Arc;
/// # let mut scene = Scene::default();
/// # scene.materials.push(Default::default());
/// # scene.meshes.push(Arc::new(Mesh { primitives: vec![primitives::plane(1.0)], ..Default::default() }));
/// # let lamp = scene.add_node(None, Node::default());
/// # let table = scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
/// scene.node_mut(lamp).translation.y += 0.5;
/// scene.materials[0].roughness_factor = 0.3;
/// Arc::make_mut(&mut scene.meshes[0]).primitives[0].material = Some(0);
/// scene.node_mut(table).is_visible = false;
/// scene.remove_node(lamp);
/// scene.update_transforms();
/// assert_eq!(scene.visible_nodes(), []);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// All nodes; only those reachable from `roots` are drawn.
    pub nodes: Nodes,
    /// The nodes without a parent that are drawn.
    pub roots: Vec<NodeId>,
    /// Where world space has its origin in the space of the file: what lies far from the origin is drawn near it
    /// ([`Scene::bring_near`]).
    pub origin_m: Vec3,
    /// The scenes of the file, of which `roots` are one; empty if it has none.
    pub scenes: Vec<SceneRoots>,
    /// Index into `scenes` of the one that is shown; see [`Scene::show_scene`].
    pub shown_scene: Option<usize>,
    /// Geometry. One that is shared with other scenes, or with whoever draws this one, is copied when it is changed
    /// through [`Arc::make_mut`].
    pub meshes: Vec<Arc<Mesh>>,
    /// Surfaces.
    pub materials: Vec<Material>,
    /// The names of the variants that give surfaces other materials.
    pub variants: Vec<String>,
    /// Index into `variants` of the one that is shown; without one every surface has its own material.
    pub variant: Option<usize>,
    /// Images with samplers.
    pub textures: Vec<Texture>,
    /// Images.
    pub images: Vec<Image>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Whether lights are those of a model file, in candela and lux; those of stages and of scenes made by code are set
    /// by eye in the picture.
    pub lights_are_photometric: bool,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// Skins.
    pub skins: Vec<Skin>,
    /// Animations.
    pub animations: Vec<Animation>,
    /// The exposure in stops that the lights are meant for, if the scene states one; 0 shows radiance as it is. Of files
    /// only `asset.extras.exposureStops` does: others are metered where they bring lights.
    pub exposure_stops: Option<f32>,
    /// Whether its light maps hold the light of all that shone when they were baked, in the units of the scene's lights;
    /// not of what was baked in the studio.
    pub holds_baked_light: bool,
    /// Radiance from all directions, if the scene brings a picture of it.
    pub environment: Option<Arc<EnvironmentMap>>,
    /// What surfaces mirror of light from everywhere, by angle and roughness; without one, the renderer's own table.
    pub brdf: Option<Arc<BrdfTable>>,
    /// Flat surfaces that reflect what is before them.
    pub mirrors: Vec<Mirror>,
    /// Flat places that lead into each other.
    pub portals: Vec<Portal>,
    /// What stands for the environment in parts of the scene.
    pub surroundings: Vec<Surroundings>,
    /// Light that arrives at places, for the surfaces between them.
    pub probes: Vec<ProbeGrid>,
    /// Surfaces of water.
    pub water: Vec<Water>,
    /// Pictures that follow from themselves, step by step.
    pub simulations: Vec<Simulation>,
    /// Many small things that simulations move.
    pub particles: Vec<Particles>,
    /// Pictures that boxes throw onto surfaces.
    pub decals: Vec<Decal>,
    /// The time that is shown of what moves without keyframes, such as waves, in seconds. [`Scene::pose`] sets it.
    pub time_secs: f32,
    /// The animation that [`Scene::pose`] last posed, by which simulations know where bodies were; none where whoever moves
    /// nodes does so without.
    pub posed: Option<usize>,
    /// What is drawn over pictures of the scene ([`Overlay`]): what a stage says.
    pub overlay: Arc<Overlay>,
    /// The extensions that the glTF file says it uses, whether or not they are read
    /// ([`crate::gltf_file::SUPPORTED_EXTENSIONS`]); at most 100.
    pub extensions_used: Vec<String>,
}

impl Scene {
    /// The node at `id`.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// The node at `id`, to change.
    pub fn node_mut(&mut self, id: NodeId) -> &mut Node {
        &mut self.nodes[id.0 as usize]
    }

    /// Adds `node` below `parent`, or as a root.
    pub fn add_node(&mut self, parent: Option<NodeId>, mut node: Node) -> NodeId {
        let id = NodeId(self.nodes.len() as u32);
        node.parent = parent;
        self.nodes.push(node);
        match parent {
            Some(parent) => self.node_mut(parent).children.push(id),
            None => self.roots.push(id),
        }
        id
    }

    /// Takes `id`, with all below it, out of its parent's children or the roots. It stays in [`Self::nodes`], so that
    /// the ids of the others do not change, and can be put back.
    pub fn remove_node(&mut self, id: NodeId) {
        let siblings = match self.node_mut(id).parent.take() {
            Some(parent) => &mut self.node_mut(parent).children,
            None => &mut self.roots,
        };
        siblings.retain(|sibling| *sibling != id);
    }

    /// Every node reachable from the roots that is not hidden, nor any above it, parents before children.
    pub fn visible_nodes(&self) -> Vec<NodeId> {
        let is_passed = |id: &&NodeId| self.node(**id).is_visible;
        let mut order: Vec<NodeId> = self.roots.iter().filter(is_passed).copied().collect();
        let mut next = 0;
        while next < order.len() {
            order.extend(self.node(order[next]).children.iter().filter(is_passed));
            next += 1;
        }
        order
    }

    /// Every node reachable from the roots, hidden ones and coarser levels too, parents before children.
    pub(crate) fn reachable_nodes(&self) -> Vec<NodeId> {
        self.reachable_from(self.roots.clone())
    }

    /// The nodes whose transforms count: those that are reachable, and joints of skins that no scene has, with all above
    /// them. Parents come before children.
    fn placed_nodes(&self) -> Vec<NodeId> {
        let order = self.reachable_nodes();
        let mut joints = self.skins.iter().flat_map(|skin| &skin.joints).peekable();
        if joints.peek().is_none() {
            return order;
        }
        let mut is_known = vec![false; self.nodes.len()];
        let mut know =
            |id: NodeId| is_known.get_mut(id.0 as usize).is_none_or(|is_known| std::mem::replace(is_known, true));
        for id in &order {
            know(*id);
        }
        let mut tops = Vec::new();
        for joint in joints {
            let mut id = *joint;
            // What is known has its top already.
            while !know(id) {
                match self.node(id).parent {
                    Some(parent) => id = parent,
                    None => tops.push(id),
                }
            }
        }
        if tops.is_empty() { order } else { self.reachable_from([self.roots.clone(), tops].concat()) }
    }

    fn reachable_from(&self, mut order: Vec<NodeId>) -> Vec<NodeId> {
        let mut next = 0;
        while next < order.len() {
            let node = self.node(order[next]);
            order.extend(&node.children);
            order.extend(node.levels.iter().flat_map(|levels| &levels.coarser));
            next += 1;
        }
        order
    }

    /// Brings `world_from_object` and `bounds_world` of the nodes below the roots up to date, hidden ones too, where
    /// anything has changed since the last time: the node itself, one above it, its mesh, a joint of its skin or a
    /// morph weight; and what portals carry. Gives the number of nodes whose transform was computed anew.
    pub fn update_transforms(&mut self) -> usize {
        let carries = self.portals.iter().any(|portal| !portal.carried.is_empty());
        if !carries && self.is_placed() {
            return 0;
        }
        let mut count = self.update_all();
        // What portals carry follows what it stands for.
        if self.carry_through_portals() {
            count += self.update_all();
        }
        self.keep_placed();
        count
    }

    fn update_all(&mut self) -> usize {
        let order = self.placed_nodes();
        let mut has_moved = vec![false; self.nodes.len()];
        for id in &order {
            let node = self.node(*id);
            let is_carried = node.parent.is_some_and(|parent| has_moved[parent.0 as usize]);
            if node.stands_still() && !is_carried {
                continue;
            }
            let of_parent = |parent: NodeId| self.node(parent).world_from_object;
            let world_from_parent = node.parent.map_or(Mat4::from_translation(Vec3::ZERO - self.origin_m), of_parent);
            let world_from_object = world_from_parent * node.local_matrix();
            self.node_mut(*id).world_from_object = world_from_object;
            has_moved[id.0 as usize] = true;
        }
        let moves = |joint: &NodeId| has_moved.get(joint.0 as usize).copied().unwrap_or(false);
        let bent: Vec<bool> = self.skins.iter().map(|skin| skin.joints.iter().any(moves)).collect();
        let mut skins = PosedSkins::default();
        for id in &order {
            let node = self.node(*id);
            let is_bent = node.skin.and_then(|skin| bent.get(skin)).copied().unwrap_or(false);
            let mesh = node.mesh.and_then(|mesh| self.meshes.get(mesh));
            if has_moved[id.0 as usize] || is_bent || !node.keeps_its_shape(mesh) {
                let (bounds_world, place) = (self.posed_bounds_of(node, &mut skins), node.place(mesh));
                let node = self.node_mut(*id);
                node.bounds_world = bounds_world;
                node.placed = LastPlace(Some(place));
            }
        }
        has_moved.into_iter().filter(|moved| *moved).count()
    }

    /// The box around everything that is drawn, in world space, as of the last [`Scene::update_transforms`].
    pub fn bounds_world(&self) -> Aabb {
        *self.summary().bounds_world.get_or_init(|| self.find_bounds_world())
    }

    fn find_bounds_world(&self) -> Aabb {
        self.visible_nodes().into_iter().fold(Aabb::EMPTY, |bounds, id| {
            let node = self.node(id);
            let Some(mesh) = node.mesh.and_then(|mesh| self.meshes.get(mesh)) else { return bounds };
            mesh.primitives
                .iter()
                .fold(bounds, |bounds, primitive| bounds.union(&primitive.bounds.transformed(&node.world_from_object)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MorphTarget, Primitive};

    fn scene() -> (Scene, [NodeId; 3]) {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        let target = MorphTarget { positions: vec![[4.0, 0.0, 0.0]], ..Default::default() };
        let primitive =
            Primitive { positions: vec![[1.0; 3]], bounds, morph_targets: vec![target], ..Default::default() };
        let mesh = Mesh { primitives: vec![primitive], default_morph_weights: vec![0.0], ..Default::default() };
        let mut scene = Scene { meshes: vec![mesh.into()], ..Default::default() };
        let root = scene.add_node(None, Node::default());
        let child = scene.add_node(Some(root), Node { mesh: Some(0), ..Node::default() });
        let other = scene.add_node(None, Node::default());
        (scene, [root, child, other])
    }

    #[test]
    fn only_what_moved_is_computed_anew() {
        let (mut scene, [root, child, other]) = scene();
        assert_eq!(scene.update_transforms(), 3);
        assert_eq!(scene.update_transforms(), 0);
        scene.node_mut(other).rotation = Quat::from_rotation_x(1.0);
        assert_eq!(scene.update_transforms(), 1);
        scene.node_mut(root).translation = Vec3::X;
        assert_eq!(scene.update_transforms(), 2);
        assert_eq!(scene.node(child).world_from_object.w_axis.truncate(), Vec3::X);
        assert_eq!(scene.posed_bounds_world(), Aabb { min: Vec3::X, max: Vec3::new(2.0, 1.0, 1.0) });
        scene.node_mut(child).parent = Some(other);
        scene.node_mut(root).children.clear();
        scene.node_mut(other).children.push(child);
        assert_eq!(scene.update_transforms(), 1);
    }

    #[test]
    fn what_is_hidden_moves_all_the_same_and_what_is_removed_can_be_put_back() {
        let (mut scene, [root, child, other]) = scene();
        scene.update_transforms();
        scene.node_mut(root).is_visible = false;
        scene.node_mut(root).translation = Vec3::X;
        assert_eq!(scene.update_transforms(), 2);
        assert_eq!(scene.visible_nodes(), [other]);
        scene.node_mut(root).is_visible = true;
        assert_eq!(scene.visible_nodes(), [root, other, child]);
        scene.remove_node(child);
        scene.remove_node(other);
        assert_eq!((scene.visible_nodes(), scene.node(child).parent), (vec![root], None));
        scene.roots.push(child);
        assert_eq!(scene.update_transforms(), 1);
        assert_eq!(scene.node(child).world_from_object, Mat4::IDENTITY);
    }

    #[test]
    fn bounds_follow_morph_weights_and_joints() {
        let (mut scene, [_, child, other]) = scene();
        scene.update_transforms();
        scene.node_mut(child).morph_weights = vec![0.5];
        assert_eq!(scene.update_transforms(), 0);
        assert_eq!(scene.posed_bounds_world().max, Vec3::new(3.0, 1.0, 1.0));
        Arc::make_mut(&mut scene.meshes[0]).primitives[0].joints = vec![[0; 4]];
        scene.skins.push(Skin { joints: vec![other], ..Default::default() });
        scene.node_mut(child).skin = Some(0);
        scene.node_mut(other).translation = Vec3::Y;
        scene.update_transforms();
        assert_eq!(scene.posed_bounds_world().max, Vec3::new(3.0, 2.0, 1.0));
        scene.node_mut(other).translation = 3.0 * Vec3::Y;
        scene.update_transforms();
        assert_eq!(scene.posed_bounds_world().max, Vec3::new(3.0, 4.0, 1.0));
    }
}
