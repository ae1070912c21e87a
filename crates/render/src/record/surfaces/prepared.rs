//! A list of draws as commands, with the pipelines and groups that they bind.

use super::pipelines::{ALPHA_TO_COVERAGE, Key, SurfacePipeline, Targets};
use super::shape::{Shape, SpecialPrograms};
use super::{DecalUse, DrawSelection};
use crate::decals::DECALS;
use crate::draws::{BLOCK_ITEMS, Draw, FADES, Item, MASKED, VisibleClouds, WorldDraws};
use crate::record::bind_groups::Resource;
use crate::record::{Frame, PreparedView};
use crate::resources::layers::{RELIEF, SHADED_WHERE_DRAWN};
use crate::resources::{FactorsOf, Geometry, Place, SampledTexture};
use crate::shader::program::ProgramError;
use crate::shader::{Program, compose};
use manypass_scene::Topology;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// The constant of `layer_maps.wgsl` that says which layers and details a material has.
const MATERIAL_LAYERS: &str = "material_layers";

/// The constant of `layer_maps.wgsl` that says how light that was baked is read.
const DIRECTED_LIGHT: &str = "directed_light";

/// So many of the world's items make a chunk: those that are culled together.
const CHUNK_ITEMS: u32 = BLOCK_ITEMS as u32;

/// A pipeline with the groups that are the same for all of its draws.
#[derive(Debug, PartialEq)]
pub(super) struct Bound {
    pub pipeline: Arc<SurfacePipeline>,
    pub pass: Option<wgpu::BindGroup>,
    pub object: Option<wgpu::BindGroup>,
}

/// Which vertices are bound: those of a whole page, or those of one primitive with its skin.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Vertices {
    Page(u32),
    Apart(Arc<(Place, Option<Place>)>),
}

/// What is to be done, in order. What stays as it is from one draw to the next is not done again.
#[derive(Debug, PartialEq)]
pub(super) enum Command {
    Bound(Arc<Bound>),
    Material(wgpu::BindGroup),
    Vertices(Vertices),
    IndexPage(u32),
    Draw { elements: Range<u32>, instances: Range<u32>, is_indexed: bool },
}

/// Draws of neighbouring items, with all that they bind.
#[derive(Debug, PartialEq)]
pub(super) struct Chunk {
    /// Which part of the list it is.
    pub index: u32,
    pub commands: Vec<Command>,
}

impl Chunk {
    /// Its draw calls.
    pub fn draws(&self) -> usize {
        self.commands.iter().filter(|command| matches!(command, Command::Draw { .. })).count()
    }
}

/// What is bound after the commands so far.
#[derive(Default)]
struct State {
    bound: Option<u32>,
    material: Option<(u32, FactorsOf)>,
    vertices: Option<Vertices>,
    index_page: Option<u32>,
}

/// What gives the next chunk its index: it begins with a draw of another stretch of items.
fn chunk_of(draw: &Draw) -> u32 {
    draw.item / CHUNK_ITEMS
}

/// The draws of a view that a pass draws, with the pass's program, targets and uniforms.
pub(super) struct PassDraws<'p, 'f> {
    pub frame: &'f Frame<'f>,
    pub view: &'f PreparedView,
    pub program: &'static str,
    pub targets: &'p Targets,
    /// What its shader finds in group 1, by WGSL name.
    pub of_pass: &'p [(&'static str, Resource)],
    /// Axes that are on for all of the pass.
    pub pass_axes: &'p [&'static str],
    /// Whether what is drawn casts shadows.
    pub casts: bool,
    /// What is done about decals.
    pub decals: DecalUse,
    /// What is drawn of clouds of points; all of them without it.
    pub clouds: Option<&'p VisibleClouds>,
}

/// What draws of a pass bind, each once.
pub(super) struct BoundShapes {
    by_shape: Vec<Option<u32>>,
    /// Of what has layers, by their bits and by how baked light is read, too.
    by_layers: HashMap<(usize, u32, u32), u32>,
    all: Vec<Arc<Bound>>,
}

impl Default for BoundShapes {
    fn default() -> Self {
        Self { by_shape: vec![None; Shape::COUNT], by_layers: HashMap::new(), all: Vec::new() }
    }
}

impl PassDraws<'_, '_> {
    pub fn prepare(
        &self,
        draws: &[Draw],
        which: DrawSelection,
        shapes: &mut BoundShapes,
    ) -> Result<Vec<Chunk>, ProgramError> {
        let Frame { resources, world, .. } = *self.frame;
        let is_reflected = self.view.is_reflected();
        let special = SpecialPrograms::of(self.program);
        let BoundShapes { by_shape, by_layers, all: all_bound } = shapes;
        let mut chunks: Vec<Chunk> = Vec::new();
        let mut state = State::default();
        for draw in draws {
            let item = &world.items[draw.item as usize];
            let is_blended = draw.item as usize >= world.opaque_count && !item.transmissive;
            let layers = item.layers_in(draw.form.surface);
            let is_wanted = match which {
                DrawSelection::All => true,
                DrawSelection::Hiding => {
                    let is_whole = !item.masked && !is_blended && !draw.fades && layers & RELIEF == 0;
                    is_whole && item.topology == Topology::Triangles
                }
                DrawSelection::ShadedWhereDrawn => layers & SHADED_WHERE_DRAWN != 0,
                DrawSelection::Layered => layers != 0,
                DrawSelection::Plain => layers == 0,
            };
            if !is_wanted {
                continue;
            }
            let layers = special.bits(layers, self.casts);
            let shape = if self.casts {
                Shape::of_caster(item, draw.faces, draw.item as usize >= world.opaque_count, layers)
            } else {
                let tests_alpha = is_blended && self.view.shows_first_surface;
                let is_decaled = draw.is_decaled && self.decals != DecalUse::LeftOut;
                Shape::of(item, &Draw { is_decaled, ..draw.clone() }, is_reflected, layers, tests_alpha)
            };
            let (place, layers) = (shape.index(), shape.layers);
            let of_layers = (place, layers, shape.directed_light);
            let known = if layers == 0 { by_shape[place] } else { by_layers.get(&of_layers).copied() };
            let bound = match known {
                Some(bound) => bound,
                None => {
                    let bound = all_bound.len() as u32;
                    if layers == 0 {
                        by_shape[place] = Some(bound);
                    } else {
                        by_layers.insert(of_layers, bound);
                    }
                    all_bound.push(self.bind(shape, special)?.into());
                    bound
                }
            };
            let index = chunk_of(draw);
            if chunks.last().is_none_or(|last| last.index != index) {
                chunks.push(Chunk { index, commands: Vec::with_capacity(CHUNK_ITEMS as usize + 8) });
                state = State::default();
            }
            let Some(Chunk { commands, .. }) = chunks.last_mut() else { continue };
            if state.bound != Some(bound) {
                commands.push(Command::Bound(all_bound[bound as usize].clone()));
                (state.bound, state.material) = (Some(bound), None);
            }
            let material = (item.material, item.factors_in(draw.form.surface));
            if state.material != Some(material) {
                let program = &all_bound[bound as usize].pipeline.program;
                let group = material_bind_group(self.frame, self.view, program, material)?;
                commands.extend(group.map(Command::Material));
                state.material = Some(material);
            }
            push_draw(commands, &mut state, draw, (world, &resources.geometry), self.clouds);
            if self.targets.vertices_alone {
                draw_vertices(commands.last_mut(), item, &resources.geometry);
            }
        }
        Ok(chunks)
    }

    fn bind(&self, shape: Shape, special: SpecialPrograms) -> Result<Bound, ProgramError> {
        let Shape { axes, topology, faces, mirrored, layers, directed_light, fades, is_decaled } = shape;
        let mut targets = self.targets.clone();
        if !is_decaled {
            targets.constants.retain(|(name, _)| *name != DECALS);
        }
        if fades {
            targets.constants.push((FADES, 1));
        }
        // What is blended has another use for alpha.
        if axes & MASKED != 0 && targets.samples > 1 && targets.blend.is_none() {
            targets.constants.push(ALPHA_TO_COVERAGE);
        }
        let program = match special.program(layers) {
            _ if topology == Topology::Points => of_points(self.program)?,
            Some(special) => {
                targets.constants.push((MATERIAL_LAYERS, layers));
                if directed_light > 0 {
                    targets.constants.push((DIRECTED_LIGHT, directed_light));
                }
                special
            }
            None => self.program,
        };
        let pass_axes = self.pass_axes.to_vec();
        let key = Key { program, axes, pass_axes, targets, topology, faces, mirrored };
        bind(self.frame, key, self.of_pass)
    }
}

fn push_draw(
    commands: &mut Vec<Command>,
    state: &mut State,
    draw: &Draw,
    (world, geometry): (&WorldDraws, &Geometry),
    clouds: Option<&VisibleClouds>,
) {
    let item = &world.items[draw.item as usize];
    let is_bound = matches!(state.vertices, Some(Vertices::Page(page)) if item.vertex_page == Some(page));
    if !is_bound {
        let vertices = item.vertex_page.map_or_else(
            || {
                let primitive = &geometry.primitives(item.mesh as usize)[item.primitive as usize];
                Vertices::Apart(Arc::new((primitive.vertices.clone(), primitive.skin.clone())))
            },
            Vertices::Page,
        );
        if state.vertices.as_ref() != Some(&vertices) {
            commands.push(Command::Vertices(vertices.clone()));
            state.vertices = Some(vertices);
        }
    }
    let (elements, index_page) = world.elements(item, draw.form.level);
    if index_page.is_some() && state.index_page != index_page {
        commands.extend(index_page.map(Command::IndexPage));
        state.index_page = index_page;
    }
    let is_indexed = index_page.is_some();
    let instances = draw.instances.clone();
    let Some(clouds) = clouds.filter(|clouds| clouds.of(instances.start).is_some()) else {
        commands.push(Command::Draw { elements, instances, is_indexed });
        return;
    };
    // All instances of a draw have the same vertices.
    for instance in instances {
        let runs = clouds.of(instance).unwrap_or_default().iter().cloned();
        commands.extend(runs.map(|elements| Command::Draw { elements, instances: instance..instance + 1, is_indexed }));
    }
}

/// Makes a draw of `item` one of its vertices.
fn draw_vertices(draw: Option<&mut Command>, item: &Item, geometry: &Geometry) {
    if let Some(Command::Draw { elements, is_indexed, .. }) = draw {
        let primitive = &geometry.primitives(item.mesh as usize)[item.primitive as usize];
        let of_page = || primitive.vertices.units.clone();
        *elements = if item.vertex_page.is_some() { of_page() } else { 0..primitive.vertex_count };
        *is_indexed = false;
    }
}

fn bind(frame: &Frame<'_>, key: Key, of_pass: &[(&'static str, Resource)]) -> Result<Bound, ProgramError> {
    let device = &frame.gpu.device;
    let pipeline = frame.surface_pipelines.get(frame.shaders, device, key)?;
    let program = &pipeline.program;
    let named = |group: u32, known: &[(&'static str, Resource)]| {
        let slots = program.slots(group).iter().map(|slot| {
            let found = known.iter().find(|(name, _)| *name == slot.name).map(|(_, resource)| resource.clone());
            found.ok_or_else(|| {
                let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
                slot.unbound(program, group, names.join(", "))
            })
        });
        let resources: Vec<_> = slots.collect::<Result<_, _>>()?;
        Ok::<_, ProgramError>(frame.bind_groups.of_program(device, program, group, resources))
    };
    let pass = named(1, of_pass)?;
    let resources = frame.resources;
    let texture = |table: &crate::gpu::data_texture::DataTexture| Resource::Texture(table.view().clone());
    let object = named(
        3,
        &[
            ("joint_matrices", texture(&resources.joint_matrices)),
            ("morph_displacements", texture(resources.geometry.morph_displacements())),
            ("morph_weights", texture(&resources.morph_weights)),
            ("previous_nodes", texture(&resources.previous_nodes)),
        ],
    )?;
    Ok(Bound { pipeline, pass, object })
}

/// The program that draws points where `program` draws triangles.
fn of_points(program: &'static str) -> Result<&'static str, ProgramError> {
    compose::points_of(program).ok_or_else(|| {
        let message = "it has no variant that draws points".into();
        ProgramError::Invalid { pass: program.into(), message }
    })
}

fn material_bind_group(
    frame: &Frame<'_>,
    view: &PreparedView,
    program: &Program,
    (material, of): (u32, FactorsOf),
) -> Result<Option<wgpu::BindGroup>, ProgramError> {
    if !program.uses_group(2) {
        return Ok(None);
    }
    let resources = frame.resources;
    let (index, material) = (material, resources.materials.get(material as usize));
    let key = (program.id, view.sampling, of);
    if let Some(group) = material.bind_group(key) {
        return Ok(Some(group));
    }
    let sampling = view.sampling;
    let factors = match of {
        FactorsOf::Whole => resources.materials.factors(material),
        FactorsOf::Plain | FactorsOf::Untextured => resources.reduced.factors(index, of),
    };
    let Some(factors) = factors else { return Ok(None) };
    let view = |slot: usize| wgpu::BindingResource::TextureView(&material.textures[slot].0);
    let of_scene = |(_, sampler): &SampledTexture| resources.textures.sampler(*sampler, sampling);
    let samplers = material.textures.each_ref().map(of_scene);
    let sampler = |slot: usize| wgpu::BindingResource::Sampler(&samplers[slot]);
    let mut known = Vec::from([
        ("material_factors", factors),
        ("base_color_texture", view(0)),
        ("base_color_sampler", sampler(0)),
        ("metallic_roughness_texture", view(1)),
        ("metallic_roughness_sampler", sampler(1)),
        ("normal_texture", view(2)),
        ("normal_sampler", sampler(2)),
        ("occlusion_texture", view(3)),
        ("occlusion_sampler", sampler(3)),
        ("emissive_texture", view(4)),
        ("emissive_sampler", sampler(4)),
    ]);
    let layers = material.layers.as_ref().zip(resources.materials.layer_factors(material));
    let layer_samplers = layers.as_ref().map(|(layers, _)| layers.textures.each_ref().map(of_scene));
    let light_map_sampler = layers.as_ref().map(|(layers, _)| of_scene(&layers.light_map));
    if let (Some((layers, factors)), Some([of_data, of_colors]), Some(of_light_map)) =
        (layers, &layer_samplers, &light_map_sampler)
    {
        known.extend([
            ("layer_factors", factors),
            ("layer_data", wgpu::BindingResource::TextureView(&layers.textures[0].0)),
            ("layer_data_sampler", wgpu::BindingResource::Sampler(of_data)),
            ("layer_colors", wgpu::BindingResource::TextureView(&layers.textures[1].0)),
            ("layer_colors_sampler", wgpu::BindingResource::Sampler(of_colors)),
            ("light_map_texture", wgpu::BindingResource::TextureView(&layers.light_map.0)),
            ("light_map_sampler", wgpu::BindingResource::Sampler(of_light_map)),
        ]);
    }
    let group = program.bind(&frame.gpu.device, 2, &known)?;
    material.keep_bind_group(key, group.clone());
    Ok(Some(group))
}
