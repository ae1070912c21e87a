//! A scene on the device: geometry, materials, textures, and the tables that animation changes. It follows the scene:
//! what is new is uploaded, what is gone is given back.

mod baked;
mod clouds;
mod decal_atlas;
mod decode;
mod directional_albedo;
pub mod estimate;
pub mod filtering;
mod geometry;
mod heights;
pub(crate) mod layers;
mod materials;
mod means;
mod mips;
mod packing;
mod pages;
mod reduced;
mod settings;
mod textures;
mod vertices;

pub(crate) use clouds::Cloud;
pub(crate) use decal_atlas::{DecalAtlas, ImageUse};
pub(crate) use directional_albedo::directional_albedo_texels;
pub(crate) use geometry::{Geometry, GpuPrimitive};
pub(crate) use layers::FactorsOf;
pub(crate) use materials::{GpuMaterial, Materials};
pub(crate) use packing::monitors_of;
pub(crate) use pages::Place;
pub(crate) use reduced::ReducedMaterials;
pub use settings::TextureSettings;
pub(crate) use textures::{SampledTexture, Textures, monitor_desc, monitor_fits};
use vertices::is_deformed;
pub(crate) use vertices::{ATTRIBUTES, ATTRIBUTES_WITHOUT_SKINS, Instance, STRIDES, copies};

use crate::constants::DATA_WIDTH;
use crate::environment::picture::EnvironmentTiles;
use crate::gpu::data_texture::DataTexture;
use crate::gpu::{Gpu, destroy};
use crate::pose::{Deformation, Pose};
use crate::surroundings::known_surroundings;
use manypass_scene::Cache;
use manypass_scene::turns::Turns;
use manypass_scene::{EnvironmentMap, Material, Mesh, Primitive, Scene, Texture};
use std::sync::Arc;

/// What is written to the device is cut into pieces of so many bytes. The device copies it first, and the memory of
/// small copies is used again and again.
const WRITE_BYTES: usize = 1 << 20;
/// Copies are done with when work is handed over: after so many bytes.
const STAGED_BYTES: usize = 2 << 20;

/// A scene on the device.
#[derive(Debug)]
pub(crate) struct SceneResources {
    /// Vertices and indices.
    pub geometry: Geometry,
    /// The scene's materials, and the default material last.
    pub materials: Materials,
    /// The textures of all materials.
    pub textures: Textures,
    /// The images of decals.
    pub decals: DecalAtlas,
    /// The largest side of an image that somebody wants.
    textures_side_max: u32,
    /// What of materials is drawn where surfaces are seen small.
    pub reduced: ReducedMaterials,
    /// Rows of `world_from_mesh` for every joint of every skin.
    pub joint_matrices: DataTexture,
    /// Weights of morph targets of every node that has some.
    pub morph_weights: DataTexture,
    /// Transforms of all nodes in the previous frame, and where their joints and weights are; see `motion.wgsl`.
    pub previous_nodes: DataTexture,
    /// The maps of environments.
    pub environments: Vec<EnvironmentTiles>,
    /// The surfaces that are there.
    followed: Option<Surfaces>,
    /// Whether joints and weights, and the previous nodes, did not fit their tables in the last frame.
    is_deformation_too_large: bool,
    are_nodes_too_many: bool,
    /// Whether surfaces that are deformed have the layers of their materials.
    pub layers_deform: bool,
    /// Whether any should have some and has none.
    are_layers_left_out: bool,
    /// Whether meshes are others than when the scene was followed last.
    meshes_went_ahead: bool,
    /// Rises whenever something of the scene that items are made from changed.
    version: u64,
    /// Of which two versions of nodes the table of previous ones is, if it holds rigid ones alone.
    previous_of: Option<[u64; 2]>,
}

/// What [`SceneResources::follow`] did.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ResourceChanges {
    /// Bytes that were uploaded.
    pub written_bytes: u64,
    /// Whether a mesh, a material or a texture is another one, though nothing of it had to be uploaded.
    pub has_changed: bool,
    /// Whether buffers or textures were given back, or others took their place.
    pub has_moved: bool,
}

/// What materials on the device are made from.
#[derive(Debug, PartialEq)]
struct Surfaces {
    materials: Vec<Material>,
    textures: Vec<Texture>,
    /// Where the texels of every image lie in memory; [`Textures`] holds on to those in use.
    images: Vec<usize>,
}

impl Surfaces {
    fn of(scene: &Scene) -> Self {
        Self {
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
            images: scene.images.iter().map(textures::address_of).collect(),
        }
    }

    fn are_those_of(&self, scene: &Scene) -> bool {
        self.materials == scene.materials
            && self.textures == scene.textures
            && self.images.iter().copied().eq(scene.images.iter().map(textures::address_of))
    }
}

impl SceneResources {
    /// Nothing yet.
    pub fn new(gpu: &Gpu) -> Self {
        let table = |label, format| DataTexture::new(&gpu.device, label, format, DATA_WIDTH);
        Self {
            geometry: Geometry::new(gpu),
            materials: Materials::new(),
            textures: Textures::new(gpu),
            decals: DecalAtlas::default(),
            textures_side_max: u32::MAX,
            reduced: ReducedMaterials::new(),
            joint_matrices: table("joint_matrices", wgpu::TextureFormat::Rgba32Float),
            morph_weights: table("morph_weights", wgpu::TextureFormat::R32Float),
            previous_nodes: table("previous_nodes", wgpu::TextureFormat::Rgba32Float),
            environments: Vec::new(),
            followed: None,
            is_deformation_too_large: false,
            are_nodes_too_many: false,
            layers_deform: gpu.capabilities.layers_deform,
            are_layers_left_out: false,
            meshes_went_ahead: false,
            version: 0,
            previous_of: None,
        }
    }

    /// From now on textures of models are at most so many texels wide and high; 0 for what the adapter takes. Those that
    /// are there already are made again.
    pub fn limit_textures(&mut self, max_px: u32) {
        self.textures_side_max = if max_px == 0 { u32::MAX } else { max_px };
        if self.textures.limit(max_px) {
            self.followed = None;
        }
    }

    /// Uploads meshes before [`Self::follow`] would upload them all at once, and gives back those that are not among
    /// them. `turns` is asked as in [`Geometry::follow_in_turns`].
    pub async fn follow_meshes(&mut self, gpu: &Gpu, meshes: &[Arc<Mesh>], turns: &mut Turns<'_>) {
        // Who awaits this may give up meanwhile.
        let before = std::mem::replace(&mut self.meshes_went_ahead, true);
        self.meshes_went_ahead = self.geometry.follow_in_turns(gpu, meshes, turns).await.is_some() || before;
    }

    /// Uploads what `scene` has that is not there yet, and maps of the environment that were `computed`, and gives back
    /// what they no longer have. What is made of maps is looked for in `cache`.
    pub fn follow<'m>(
        &mut self,
        gpu: &Gpu,
        scene: &'m Scene,
        computed: impl Iterator<Item = &'m Arc<EnvironmentMap>> + Clone,
        cache: Option<&dyn Cache>,
    ) -> ResourceChanges {
        let geometry_bytes = self.geometry.follow(gpu, &scene.meshes);
        let are_others = std::mem::take(&mut self.meshes_went_ahead) || geometry_bytes.is_some();
        let mut followed = ResourceChanges {
            written_bytes: geometry_bytes.unwrap_or(0),
            has_changed: are_others,
            has_moved: are_others,
        };
        if are_others {
            self.reduced.forget_meshes();
        }
        if !self.followed.as_ref().is_some_and(|followed| followed.are_those_of(scene)) {
            let textures = self.textures.follow(gpu, scene);
            followed.written_bytes += textures.written_bytes + self.materials.follow(gpu, scene, &self.textures);
            followed.has_moved |= textures.has_moved;
            followed.has_changed = true;
            self.reduced.forget_materials();
            self.followed = Some(Surfaces::of(scene));
        }
        if let Some(written_bytes) = self.decals.follow(gpu, scene, self.textures_side_max) {
            followed.written_bytes += written_bytes;
            (followed.has_changed, followed.has_moved) = (true, true);
        }
        if followed.has_changed && !self.layers_deform {
            let primitives = || scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
            let has_layers =
                |part: &Primitive| self.materials.get(self.materials.index(part.material)).layers.is_some();
            self.are_layers_left_out = primitives().filter(|part| is_deformed(part)).any(has_layers);
        }
        let maps = scene.environment.iter().chain(computed);
        let pictures = known_surroundings(scene).filter_map(|of| of.picture.as_ref());
        let count = self.environments.len();
        let all = maps.map(|map| (map, false)).chain(pictures.map(|map| (map, true)));
        let is_gone =
            |tiles: &mut EnvironmentTiles| !all.clone().any(|(map, is_of_place)| tiles.are_of(map, is_of_place));
        self.environments.extract_if(.., is_gone).for_each(|tiles| destroy(&tiles.view));
        followed.has_moved |= self.environments.len() < count;
        for (map, is_of_place) in all {
            if !self.environments.iter().any(|tiles| tiles.are_of(map, is_of_place)) {
                let new = if is_of_place { EnvironmentTiles::of_surroundings } else { EnvironmentTiles::new };
                self.environments.push(new(gpu, map, cache));
                followed.has_moved = true;
            }
        }
        self.version += u64::from(followed.has_moved || followed.has_changed || followed.written_bytes > 0);
        followed
    }

    /// Another number whenever meshes, materials, textures or what is made of them changed.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Gives back at once what the scene takes; nothing of it is drawn any more.
    pub fn destroy(&self) {
        self.textures.views().chain(self.environments.iter().map(|tiles| &tiles.view)).for_each(destroy);
        for pages in [&self.geometry.vertices, &self.geometry.skins, &self.geometry.indices] {
            pages.destroy();
        }
    }

    /// Makes what of materials is drawn where surfaces are seen small, for frames that want it. Says how many bytes
    /// that uploaded.
    pub fn reduce_materials(&mut self, gpu: &Gpu, scene: &Scene) -> u64 {
        self.version += u64::from(!self.reduced.is_current());
        self.reduced.follow(gpu, scene, &self.materials, &self.textures)
    }

    /// What is there of a map of the environment.
    pub fn environment(&self, map: &Arc<EnvironmentMap>) -> Option<&EnvironmentTiles> {
        self.environments.iter().find(|tiles| tiles.are_of(map, false))
    }

    /// What is there of a picture of what is to be seen around a place.
    pub fn picture_of_place(&self, map: &Arc<EnvironmentMap>) -> Option<&EnvironmentTiles> {
        self.environments.iter().find(|tiles| tiles.are_of(map, true))
    }

    /// What was left out, or replaced.
    pub fn warnings(&self) -> Vec<String> {
        let tables = [
            (
                self.is_deformation_too_large,
                "the joints or morph weights do not fit a texture of this adapter; they keep their last pose",
            ),
            (
                self.are_layers_left_out,
                "this adapter has too few textures for materials with layers (KHR_materials_clearcoat, …) on skinned or morphed meshes; \
                 it is drawn without them",
            ),
            (self.are_nodes_too_many, "the nodes do not fit a texture of this adapter; motion is 0"),
        ];
        let of_tables = tables.into_iter().filter(|(is_so, _)| *is_so).map(|(_, warning)| warning.to_owned());
        let of_environments = self.environments.iter().filter_map(EnvironmentTiles::warning);
        let of_surfaces = self
            .textures
            .warnings()
            .chain(self.decals.warnings())
            .chain(self.materials.warnings())
            .chain(self.geometry.warnings());
        let of_scene = of_surfaces.chain(of_environments).cloned();
        // An image that is colour in one place and data in another is decoded twice, and says the same.
        let mut said = std::collections::BTreeSet::new();
        of_scene.chain(of_tables).filter(|warning| said.insert(warning.clone())).collect()
    }

    /// Bytes of meshes and textures.
    pub fn bytes(&self) -> u64 {
        self.geometry.bytes()
            + self.textures.bytes()
            + self.decals.bytes()
            + self.environments.iter().map(EnvironmentTiles::bytes).sum::<u64>()
    }

    /// Uploads the transforms of skins and the weights of morph targets of this frame, where they changed, and says how
    /// many bytes that were.
    pub fn write_deformation(&mut self, gpu: &Gpu, joint_rows: &[[f32; 4]], morph_weights: &[f32]) -> u64 {
        let joints = self.joint_matrices.write(&gpu.device, &gpu.queue, joint_rows);
        let weights = self.morph_weights.write(&gpu.device, &gpu.queue, morph_weights);
        self.is_deformation_too_large = joints.is_none() || weights.is_none();
        joints.unwrap_or(0) + weights.unwrap_or(0)
    }

    /// Uploads where all nodes of `scene` were in the `previous` pose, where that changed, and says how many bytes that
    /// were. Joints and weights of the pose are appended to those of this frame. `None`, with a warning, if they do not
    /// fit a texture.
    pub fn write_previous_nodes(
        &mut self,
        gpu: &Gpu,
        (scene, previous): (&Scene, &Pose),
        deformation: &mut Deformation,
    ) -> Option<u64> {
        let of = [previous.nodes_version(), scene.nodes.version()];
        if self.previous_of == Some(of) && deformation.is_empty() {
            return Some(0);
        }
        let texels = previous.append_to(scene, deformation);
        let written = self.previous_nodes.write(&gpu.device, &gpu.queue, &texels);
        self.are_nodes_too_many = written.is_none();
        self.previous_of = written.filter(|_| deformation.is_empty()).map(|_| of);
        written
    }
}
