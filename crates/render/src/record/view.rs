//! A camera of the frame, ready to be recorded: what it draws, its lists of lights, its uniforms.

use super::bind_groups::{BindGroups, Resource};
use super::tables::FrameTables;
use super::uniforms::UniformArena;
use crate::constants::{DATA_WIDTH, LIGHTS_PER_ROW, LIST_WIDTH, TABLE_WIDTH, TEXELS_PER_LIGHT};
use crate::draws::{DecalDraws, Draw, DrawList, VisibleClouds, WorldDraws, faded_id, object_id};
use crate::environment::EnvironmentUniform;
use crate::gpu::Gpu;
use crate::gpu::data_texture::DataTexture;
use crate::ground::ViewGround;
use crate::lights::{
    ClusterLists, ClusterUniform, DecalLists, LightReaches, ListRecord, Rectangle, VolumeDraw, without_shadows,
};
use crate::outline::Outline;
use crate::resources::filtering::Sampling;
use crate::shader::Shaders;
use crate::shader::compose::has_constant_somewhere;
use crate::shader::frame_group::FRAME_GROUP;
use crate::shader::program::Constant;
use crate::view::ViewUniform;
use manypass_graph::TextureDesc;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// The noise of so many samples averages out by itself, without losing what is fine.
pub const UNFILTERED_SAMPLES: u32 = 8;

/// The axis of programs that add up lights whose shadows there are.
pub(super) const SHADOWED: &str = "shadowed";

/// The constant of programs that add up lights by which they count pairs instead.
pub(crate) const COUNTS_PAIRS: Constant = ("counts_pairs", 1);

/// One camera of a frame, prepared before its passes are recorded.
#[derive(Debug)]
pub struct PreparedView {
    /// Precedes the names of its passes; empty for the only view.
    pub name: Cow<'static, str>,
    /// Width and height at which it is shaded.
    pub size: (u32, u32),
    /// What `view.wgsl` gives shaders.
    pub uniform: ViewUniform,
    /// The number of lights.
    pub light_count: u32,
    /// How many of them are directional or have no range, so that every pixel visits them.
    pub(crate) global_light_count: u32,
    /// The tiles of the lists of lights, across and down, and their side in pixels.
    pub(crate) light_tiles: [u32; 3],
    /// `override` constants of shaders that are the same for all of its passes.
    pub(crate) constants: Vec<Constant>,
    /// The part of the picture that lights in lists may reach.
    pub(crate) lit_rectangles: Arc<[Rectangle]>,
    /// How volumes of lights are drawn.
    pub(crate) volume_draws: Arc<[VolumeDraw]>,
    /// The records of the lists of objects, by object id, where objects have lists.
    pub(crate) object_lights: Arc<[ListRecord]>,
    /// The texture of [`LightReaches`].
    pub(crate) light_reaches: wgpu::TextureView,
    /// Whether the environment lights anything.
    pub is_environment_dark: bool,
    /// How many probes there are.
    pub probe_count: u32,
    /// Whether the frame goes on from the view's last one, so that histories hold what that left.
    pub goes_on: bool,
    /// The same of what effects keep.
    pub effects_go_on: bool,
    /// The same of what is made of a picture that is shown: the last one was, too, and belongs to this one.
    pub display_goes_on: bool,
    /// From pre-exposed radiance to what the tone curve takes.
    pub display_exposure: f32,
    /// Of how many samples the picture is the mean.
    pub sample_count: u32,
    /// How many samples of a pixel surfaces cover that are shaded where they are drawn (`msaa.samples`).
    pub pixel_samples: u32,
    pub(crate) draws: Arc<DrawList>,
    /// What is in the picture of clouds of points.
    pub(crate) clouds: VisibleClouds,
    /// What of that is on tiles that are not settled, if they are known.
    pub(crate) clouds_left: Option<VisibleClouds>,
    /// Whether what is blended, or light comes through, is among its opaque surfaces, for variables.
    pub(crate) shows_first_surface: bool,
    /// How samplers of textures filter.
    pub(crate) sampling: Sampling,
    /// Group 0 of all programs.
    pub(crate) group: wgpu::BindGroup,
    /// The instances of its draws.
    pub(crate) instances: wgpu::Buffer,
    /// Whether lights cast shadows in it.
    pub has_shadows: bool,
    /// The plane under the scene.
    pub(crate) ground: Option<ViewGround>,
    /// Of a still whose later samples leave tiles out, how many samples draw all of them.
    pub whole_samples: Option<u32>,
    /// Whether light finds distances in the depth attachment, because nothing else needs linear depth.
    pub reads_attached_depth: bool,
    /// The texture that says which tiles are settled, if any may be: the frame leaves those out.
    pub(crate) settled: Option<wgpu::TextureView>,
    /// Rectangles around all that is not settled, if they are known; or around the outline.
    pub(crate) unsettled: Option<Arc<[Rectangle]>>,
    /// The outline of a mirror that it is behind: it draws nothing outside.
    pub(crate) outline: Option<Outline>,
    /// The boxes of decals that it sees.
    pub(crate) decal_draws: DecalDraws,
    /// The extent of what it sees, once a pass asks for it.
    pub(crate) extent_m: OnceLock<f32>,
    /// The rectangle around its surfaces, once a pass asks for it.
    surfaces: OnceLock<Option<Rectangle>>,
}

impl PreparedView {
    /// The shape of a texture of the view's size.
    pub fn desc(&self, format: wgpu::TextureFormat) -> TextureDesc {
        TextureDesc::new_2d(self.size.0, self.size.1, format)
    }

    /// The `override` constants of its passes that `program` declares, or one that draws other surfaces in its place.
    pub(super) fn constants_of(&self, program: &str) -> Vec<Constant> {
        self.constants.iter().filter(|(constant, _)| has_constant_somewhere(program, constant)).copied().collect()
    }

    /// How many levels of detail its draws have, from the finest to the coarsest that is shown.
    pub fn level_count(&self) -> u32 {
        (self.draws.levels.len() as u32).max(1)
    }

    /// Whether its passes count pairs of a light and what it may reach, in place of light.
    pub fn counts_pairs(&self) -> bool {
        self.constants.contains(&COUNTS_PAIRS)
    }

    /// Whether noise has to be filtered, because no mean of enough samples takes it out before the picture is shown.
    pub fn shows_few_samples(&self) -> bool {
        // The first frame of a live view is shown before the others are there.
        self.sample_count < UNFILTERED_SAMPLES || self.goes_on && self.uniform.sample_index == 0
    }

    /// The axes of programs that add up lights.
    pub fn light_axes(&self) -> &'static [&'static str] {
        if self.has_shadows && !self.counts_pairs() { &[SHADOWED] } else { &[] }
    }

    /// Whether the camera sees the world mirrored, so that triangles turn around.
    pub fn is_reflected(&self) -> bool {
        self.uniform.world_from_view.determinant() < 0.0
    }

    /// Triangles of all its draws.
    pub fn triangle_count(&self) -> u64 {
        self.draws.triangles
    }

    /// Points of all its draws.
    pub fn point_count(&self) -> u64 {
        self.clouds_left.as_ref().unwrap_or(&self.clouds).points
    }

    /// Whether there are blended surfaces in it.
    pub fn has_blended(&self) -> bool {
        !self.draws.blended.is_empty()
    }

    /// Whether decals may touch opaque surfaces in it.
    pub fn has_decaled(&self) -> bool {
        !self.draws.decaled.is_empty()
    }

    /// Whether there are masked surfaces in it.
    pub(crate) fn has_masked(&self, world: &WorldDraws) -> bool {
        let is_masked = |draw: &Draw| world.items.get(draw.item as usize).is_some_and(|item| item.masked);
        self.draws.opaque.iter().any(is_masked)
    }

    /// Whether there are surfaces in it that light comes through.
    pub fn has_transmissive(&self) -> bool {
        !self.draws.transmissive.is_empty()
    }

    /// The most lights that reach one of the objects that are drawn: those that every pixel visits, and those of its
    /// list.
    pub(crate) fn most_lights(&self, world: &WorldDraws) -> u32 {
        self.draws.opaque.iter().map(|draw| self.most_lights_of(draw, world)).max().unwrap_or(0)
    }

    pub(crate) fn most_lights_of(&self, draw: &Draw, world: &WorldDraws) -> u32 {
        self.global_light_count + self.lists_of(draw, world).map(|list| list.count()).max().unwrap_or(0)
    }

    /// The lists of the objects that are drawn.
    fn lists_of<'w>(&'w self, draw: &Draw, world: &'w WorldDraws) -> impl Iterator<Item = ListRecord> + 'w {
        let Range { start, end } = draw.instances;
        let instances = world.instances.get(start as usize..end as usize).unwrap_or(&[]);
        let fades = draw.fades;
        let list = move |instance| {
            let id = if fades { faded_id(instance) } else { object_id(instance) };
            self.object_lights.get(id as usize).copied().unwrap_or(ListRecord::EMPTY)
        };
        instances.iter().map(list)
    }

    /// The axes of programs that add up those lights alone of each object that have numbers within `batch`.
    pub(crate) fn light_axes_of(&self, batch: &Range<u32>, world: &WorldDraws) -> &'static [&'static str] {
        if self.light_axes().is_empty() {
            return &[];
        }
        let global_count = self.global_light_count;
        let casts = |list: ListRecord| {
            let [first, end] = list.casters().map(|light| global_count + light);
            first.max(batch.start) < end.min(batch.end)
        };
        let mut lists = self.draws.opaque.iter().flat_map(|draw| self.lists_of(draw, world));
        if batch.start < global_count || lists.any(casts) { self.light_axes() } else { &[] }
    }

    /// The rectangle, in pixels, that all lies in of what the G-buffer may hold; none where it may be the whole picture.
    pub(super) fn surfaces(&self, world: &WorldDraws) -> Option<Rectangle> {
        // Where parts of the picture are left out, distances there are not those of surfaces.
        if self.outline.is_some() || self.settled.is_some() {
            return None;
        }
        *self.surfaces.get_or_init(|| world.surfaces_px(&self.uniform, self.shows_first_surface))
    }

    /// Pixels of the view.
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.size.0) * u64::from(self.size.1)
    }
}

/// Textures of a view that each frame fills anew.
#[derive(Debug)]
pub(crate) struct ViewTables {
    /// The records of lists, those of lists of decals, decals, the layers of nodes, each of which end with a row, and then
    /// the lights.
    lights: DataTexture,
    /// Rows before the lights.
    record_rows: u32,
    /// The first rows of what is about decals.
    decal_rows: [u32; 3],
    cluster_lights: DataTexture,
    light_reaches: DataTexture,
}

impl ViewTables {
    pub fn new(gpu: &Gpu) -> Self {
        let table = |label, format, width| DataTexture::new(&gpu.device, label, format, width);
        Self {
            lights: table("lights", wgpu::TextureFormat::Rgba32Float, LIGHTS_PER_ROW * TEXELS_PER_LIGHT),
            record_rows: 0,
            decal_rows: [0; 3],
            cluster_lights: table("cluster_lights", wgpu::TextureFormat::Rg8Unorm, LIST_WIDTH),
            light_reaches: table("light_reaches", wgpu::TextureFormat::Rgba32Float, DATA_WIDTH),
        }
    }

    /// Uploads what changed, and says how many bytes that were. Without `lists` those that are there stay.
    pub fn write(&mut self, gpu: &Gpu, lights: &[[f32; 4]], lists: Option<&(ClusterLists, LightReaches)>) -> u64 {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let mut written = 0;
        let rows = |texels: usize| (texels as u32).div_ceil(TABLE_WIDTH);
        let mut decal_rows = self.decal_rows;
        let (record_rows, kept) = match lists {
            Some((lists, _)) => {
                let ClusterLists { table, decals, .. } = lists;
                let parts = [table.len(), decals.records.len(), decals.table.texels.len()];
                let mut end = 0;
                decal_rows = parts.map(|texels| {
                    end += rows(texels);
                    end
                });
                (end + rows(decals.table.layers.len()), 0)
            }
            None => (self.record_rows, self.record_rows * TABLE_WIDTH),
        };
        let first = record_rows * TABLE_WIDTH;
        // The lists were made to fit.
        let Some(rewritten) = self.lights.fit(device, queue, first + lights.len() as u32, kept) else { return 0 };
        (self.record_rows, self.decal_rows) = (record_rows, decal_rows);
        if let Some((lists, reaches)) = lists {
            let DecalLists { records, table, .. } = &lists.decals;
            let [of_records, of_decals, of_layers] = decal_rows.map(|row| row * TABLE_WIDTH);
            written += self.lights.write_changed(queue, 0, &lists.table);
            written += self.lights.write_changed(queue, of_records, records);
            written += self.lights.write_changed(queue, of_decals, &table.texels);
            written += self.lights.write_changed(queue, of_layers, &table.layers);
            written += self.cluster_lights.write(device, queue, &lists.lights).unwrap_or(0);
            written += self.light_reaches.write(device, queue, &reaches.texels).unwrap_or(0);
        }
        written + rewritten + self.lights.write_changed(queue, first, lights)
    }

    /// Bytes of the tables.
    pub fn bytes(&self) -> u64 {
        self.lights.bytes() + self.cluster_lights.bytes() + self.light_reaches.bytes()
    }

    /// What shaders know of the shape of the textures of lights and lists.
    fn rows(&self) -> [f32; 4] {
        let [light_rows, list_rows] = [&self.lights, &self.cluster_lights].map(|table| table.rows() as f32);
        [light_rows.recip(), (self.record_rows as f32 + 0.5) / light_rows, list_rows.recip(), 0.0]
    }

    /// Where what is about decals begins in the texture of lights.
    fn decal_rows(&self) -> [f32; 4] {
        let [records, decals, layers] = self.decal_rows.map(|row| row as f32);
        [records, decals, layers, 0.0]
    }
}

/// What a view is prepared from, beside its tables.
pub(crate) struct ViewDescription<'a> {
    pub name: Cow<'static, str>,
    pub size: (u32, u32),
    pub goes_on: bool,
    pub effects_go_on: bool,
    pub display_goes_on: bool,
    pub display_exposure: f32,
    pub sample_count: u32,
    pub pixel_samples: u32,
    pub uniform: ViewUniform,
    pub draws: Arc<DrawList>,
    /// What is in the picture of clouds of points.
    pub clouds: VisibleClouds,
    /// What of that is on tiles that are not settled.
    pub clouds_left: Option<VisibleClouds>,
    pub shows_first_surface: bool,
    pub sampling: Sampling,
    pub light_count: u32,
    pub cluster_grid: &'a ClusterUniform,
    pub constants: Vec<Constant>,
    pub lit_rectangles: Arc<[Rectangle]>,
    pub volume_draws: Arc<[VolumeDraw]>,
    pub object_lights: Arc<[ListRecord]>,
    pub environment: &'a EnvironmentUniform,
    pub instances: wgpu::Buffer,
    /// The atlas of shadow maps, if there is one that lights are read from.
    pub shadows: Option<&'a wgpu::TextureView>,
    /// The plane under the scene.
    pub ground: Option<ViewGround>,
    /// Of a still whose later samples leave tiles out, how many samples draw all of them.
    pub whole_samples: Option<u32>,
    /// Whether light finds distances in the depth attachment.
    pub reads_attached_depth: bool,
    /// Which tiles are settled.
    pub settled: Option<wgpu::TextureView>,
    /// Rectangles around all that is not.
    pub unsettled: Option<Arc<[Rectangle]>>,
    /// The outline of a mirror that it is behind.
    pub outline: Option<Outline>,
    /// The tiles of the environment, if that is a picture or the studio.
    pub environment_tiles: Option<&'a wgpu::TextureView>,
    /// The texture of decals, if they have images.
    pub decals: Option<&'a wgpu::TextureView>,
    /// The boxes of decals that it sees.
    pub decal_draws: DecalDraws,
}

impl ViewDescription<'_> {
    /// The view, with its uniforms in `uniforms` and its group 0 among `groups`.
    pub fn prepare(
        self,
        gpu: &Gpu,
        shaders: &Shaders,
        shared: (&FrameTables, &UniformArena, &BindGroups),
        tables: &ViewTables,
    ) -> PreparedView {
        let (frame_tables, uniforms, groups) = shared;
        let texture = |table: &DataTexture| Resource::Texture(table.view().clone());
        let resources = [
            Resource::Uniform(uniforms.push(&self.uniform)),
            Resource::Uniform(uniforms.push(&ClusterUniform {
                table_rows: tables.rows(),
                decal_rows: tables.decal_rows(),
                ..*self.cluster_grid
            })),
            texture(&tables.lights),
            texture(&tables.cluster_lights),
            Resource::Uniform(uniforms.push(self.environment)),
        ];
        let shadows = self.shadows.unwrap_or(&frame_tables.no_shadows);
        let environment_tiles = self.environment_tiles.unwrap_or(&frame_tables.no_environment);
        let resources = frame_tables.frame_group(resources, shadows, environment_tiles, self.decals);
        let bindings: Vec<u32> = (0..FRAME_GROUP.len() as u32).collect();
        let [across, down, _, tile_px] = self.cluster_grid.size;
        PreparedView {
            global_light_count: self.cluster_grid.global_count,
            light_tiles: [across, down, tile_px],
            light_reaches: tables.light_reaches.view().clone(),
            constants: self.constants,
            lit_rectangles: self.lit_rectangles,
            volume_draws: match self.shadows {
                Some(_) => self.volume_draws,
                None => without_shadows(&self.volume_draws).into(),
            },
            object_lights: self.object_lights,
            group: groups.get(&gpu.device, "frame", shaders.frame_layout(), &bindings, resources),
            name: self.name,
            size: self.size,
            uniform: self.uniform,
            light_count: self.light_count,
            is_environment_dark: self.environment.is_dark(),
            probe_count: self.environment.probe_count(),
            goes_on: self.goes_on,
            effects_go_on: self.effects_go_on,
            display_goes_on: self.display_goes_on,
            display_exposure: self.display_exposure,
            sample_count: self.sample_count,
            pixel_samples: self.pixel_samples,
            draws: self.draws,
            clouds: self.clouds,
            clouds_left: self.clouds_left,
            shows_first_surface: self.shows_first_surface,
            sampling: self.sampling,
            instances: self.instances,
            has_shadows: self.shadows.is_some(),
            ground: self.ground,
            whole_samples: self.whole_samples,
            reads_attached_depth: self.reads_attached_depth,
            settled: self.settled,
            unsettled: self.unsettled,
            outline: self.outline,
            decal_draws: self.decal_draws,
            extent_m: OnceLock::new(),
            surfaces: OnceLock::new(),
        }
    }
}
