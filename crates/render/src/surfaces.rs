//! Drawing surfaces: the pipelines of a program that draws the scene's geometry, and the loop that draws a list.

use crate::draws::{Draw, Faces};
use crate::frame::Shared;
use crate::resources::SceneResources;
use crate::resources::geometry::{ATTRIBUTES, STRIDES};
use crate::shader::program::ProgramError;
use crate::shader::{Program, Shaders, compose};
use manypass_graph::PassContext;
use manypass_scene::Topology;
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// Which targets a program draws into, and how.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Targets {
    /// The colour targets; without one no fragment is shaded.
    pub colors: Vec<wgpu::TextureFormat>,
    /// The same blend state for all, because the floor has one.
    pub blend: Option<wgpu::BlendState>,
    /// The format of depth.
    pub depth: wgpu::TextureFormat,
    /// Whether depth is written.
    pub depth_write: bool,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    program: &'static str,
    axes: Vec<&'static str>,
    targets: Targets,
    topology: Topology,
    faces: Faces,
    mirrored: bool,
}

/// A pipeline with its program.
#[derive(Debug)]
pub struct SurfacePipeline {
    program: Arc<Program>,
    pipeline: wgpu::RenderPipeline,
}

/// Every pipeline that draws surfaces made so far.
#[derive(Debug, Default)]
pub struct SurfacePipelines {
    pipelines: RefCell<HashMap<Key, Arc<SurfacePipeline>>>,
}

/// A draw with its pipeline and bind groups.
#[derive(Debug)]
pub struct PreparedDraw {
    pipeline: Arc<SurfacePipeline>,
    draw: Draw,
    frame: wgpu::BindGroup,
    material: wgpu::BindGroup,
    object: Option<wgpu::BindGroup>,
}

impl SurfacePipelines {
    fn get(&self, shaders: &Shaders, device: &wgpu::Device, key: Key) -> Result<Arc<SurfacePipeline>, ProgramError> {
        if let Some(pipeline) = self.pipelines.borrow().get(&key) {
            return Ok(pipeline.clone());
        }
        let program = shaders.program(key.program, &key.axes)?;
        let pipeline = shaders.compiling(|| create(device, &program, &key))?;
        let pipeline = Arc::new(SurfacePipeline { pipeline, program });
        self.pipelines.borrow_mut().insert(key, pipeline.clone());
        Ok(pipeline)
    }
}

fn create(device: &wgpu::Device, program: &Program, key: &Key) -> Result<wgpu::RenderPipeline, ProgramError> {
    let attributes = program.attributes(&ATTRIBUTES, STRIDES.len())?;
    let buffers: Vec<_> = attributes
        .iter()
        .zip(STRIDES)
        .enumerate()
        .filter(|(_, (attributes, _))| !attributes.is_empty())
        .map(|(index, (attributes, array_stride))| {
            Some(wgpu::VertexBufferLayout {
                array_stride,
                // Points are the instances of one disc, so that the object is what stays the same for its corners.
                step_mode: if (index == 2) == (key.topology != Topology::Points) {
                    wgpu::VertexStepMode::Instance
                } else {
                    wgpu::VertexStepMode::Vertex
                },
                attributes,
            })
        })
        .collect();
    let targets: Vec<_> = key
        .targets
        .colors
        .iter()
        .map(|format| {
            Some(wgpu::ColorTargetState {
                format: *format,
                blend: key.targets.blend,
                write_mask: wgpu::ColorWrites::ALL,
            })
        })
        .collect();
    Ok(device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(key.program),
        layout: Some(&program.layout),
        vertex: wgpu::VertexState {
            module: &program.module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: match key.topology {
                Topology::Points => wgpu::PrimitiveTopology::TriangleStrip,
                Topology::Lines => wgpu::PrimitiveTopology::LineList,
                Topology::Triangles => wgpu::PrimitiveTopology::TriangleList,
            },
            front_face: if key.mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
            cull_mode: match key.faces {
                Faces::Both => None,
                Faces::Front => Some(wgpu::Face::Back),
                Faces::Back => Some(wgpu::Face::Front),
            },
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: key.targets.depth,
            depth_write_enabled: Some(key.targets.depth_write),
            // Depth is reversed: nearer is greater.
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: (!targets.is_empty()).then(|| wgpu::FragmentState {
            module: &program.module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    }))
}

/// As [`prepare`], without draws whose fragments may be dropped.
///
/// # Errors
/// As [`prepare`].
pub fn prepare_hiding(
    shared: &Shared<'_>,
    program: &'static str,
    targets: &Targets,
    draws: &[Draw],
) -> Result<Vec<PreparedDraw>, ProgramError> {
    let resources = shared.resources;
    let hides = |draw: &&Draw| {
        let topology = resources.geometry.meshes[draw.mesh][draw.primitive].topology;
        !resources.materials[draw.material].masked && topology == Topology::Triangles
    };
    let hiding: Vec<Draw> = draws.iter().filter(hides).cloned().collect();
    prepare(shared, program, targets, &hiding)
}

/// Finds the pipeline and the bind groups of every draw of a list.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn prepare(
    shared: &Shared<'_>,
    program: &'static str,
    targets: &Targets,
    draws: &[Draw],
) -> Result<Vec<PreparedDraw>, ProgramError> {
    let mut frames: HashMap<usize, wgpu::BindGroup> = HashMap::new();
    let mut objects: HashMap<usize, wgpu::BindGroup> = HashMap::new();
    let resources = shared.resources;
    let mut prepared = Vec::with_capacity(draws.len());
    for draw in draws {
        let primitive = &resources.geometry.meshes[draw.mesh][draw.primitive];
        let material = &resources.materials[draw.material];
        let is_deformed = primitive.skin.is_some();
        let axes = [
            ("textured", material.textured),
            ("occlusion_apart", material.occlusion_apart),
            ("normal_map", material.normal_map),
            ("masked", material.masked),
            ("deformed", is_deformed),
        ];
        let program = if primitive.topology == Topology::Points { of_points(program)? } else { program };
        let key = Key {
            program,
            axes: axes
                .iter()
                .filter(|(axis, on)| *on && compose::has_axis(program, axis))
                .map(|(axis, _)| *axis)
                .collect(),
            targets: targets.clone(),
            topology: primitive.topology,
            faces: draw.faces,
            // Discs face the eye however their object is mirrored.
            mirrored: draw.mirrored && primitive.topology != Topology::Points,
        };
        let pipeline = shared.surface_pipelines.get(shared.shaders, shared.device, key)?;
        let address = Arc::as_ptr(&pipeline.program) as usize;
        let frame = match frames.get(&address) {
            Some(group) => group.clone(),
            None => frames.entry(address).or_insert(shared.frame_bind_group(&pipeline.program)?).clone(),
        };
        let object = if pipeline.program.uses_group(3) {
            Some(match objects.get(&address) {
                Some(group) => group.clone(),
                None => objects.entry(address).or_insert(object_bind_group(shared, &pipeline.program)?).clone(),
            })
        } else {
            None
        };
        let material = material_bind_group(shared, &pipeline.program, draw.material, address)?;
        prepared.push(PreparedDraw { pipeline, draw: draw.clone(), frame, material, object });
    }
    Ok(prepared)
}

/// The program that draws points where `program` draws triangles.
fn of_points(program: &'static str) -> Result<&'static str, ProgramError> {
    Ok(match program {
        "geometry" => "geometry_points",
        "ids" => "ids_points",
        "motion" => "motion_points",
        "forward" => "forward_points",
        _ => {
            let message = "it has no variant that draws points".into();
            return Err(ProgramError::Invalid { pass: program.into(), message });
        }
    })
}

fn object_bind_group(shared: &Shared<'_>, program: &Program) -> Result<wgpu::BindGroup, ProgramError> {
    let resources = shared.resources;
    program.bind(
        shared.device,
        3,
        &[
            ("joint_matrices", wgpu::BindingResource::TextureView(resources.joint_matrices.view())),
            ("morph_displacements", wgpu::BindingResource::TextureView(resources.morph_displacements.view())),
            ("morph_weights", wgpu::BindingResource::TextureView(resources.morph_weights.view())),
            ("previous_nodes", wgpu::BindingResource::TextureView(resources.previous_nodes.view())),
        ],
    )
}

fn material_bind_group(
    shared: &Shared<'_>,
    program: &Program,
    index: usize,
    address: usize,
) -> Result<wgpu::BindGroup, ProgramError> {
    let material = &shared.resources.materials[index];
    let sampling = shared.sampling;
    if let Some(group) = material.bind_groups.borrow().get(&(address, sampling)) {
        return Ok(group.clone());
    }
    let textures = &shared.resources.textures;
    let view = |slot: usize| wgpu::BindingResource::TextureView(textures.view(material.textures[slot]));
    let samplers = material.textures.map(|texture| textures.sampler(texture, sampling));
    let sampler = |slot: usize| wgpu::BindingResource::Sampler(&samplers[slot]);
    let group = program.bind(
        shared.device,
        2,
        &[
            ("material_factors", material.uniform.as_entire_binding()),
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
        ],
    )?;
    material.bind_groups.borrow_mut().insert((address, sampling), group.clone());
    Ok(group)
}

/// Records a prepared list.
pub fn draw(
    context: &mut PassContext<'_, '_>,
    resources: &SceneResources,
    instances: &wgpu::Buffer,
    list: &[PreparedDraw],
) {
    let pass = &mut *context.render_pass;
    let geometry = &resources.geometry;
    let mut last: Option<&PreparedDraw> = None;
    for prepared in list {
        let primitive = &geometry.meshes[prepared.draw.mesh][prepared.draw.primitive];
        if last.is_none_or(|last| !Arc::ptr_eq(&last.pipeline, &prepared.pipeline)) {
            pass.set_pipeline(&prepared.pipeline.pipeline);
            pass.set_bind_group(0, &prepared.frame, &[]);
            if let Some(object) = &prepared.object {
                pass.set_bind_group(3, object, &[]);
            }
            last = None;
        }
        if last.is_none_or(|last| last.draw.material != prepared.draw.material) {
            pass.set_bind_group(2, &prepared.material, &[]);
        }
        pass.set_vertex_buffer(0, geometry.vertices.slice(primitive.vertices.clone()));
        let mut slot = 1;
        if let Some(skin) = &primitive.skin {
            pass.set_vertex_buffer(slot, geometry.skins.slice(skin.clone()));
            slot += 1;
        }
        pass.set_vertex_buffer(slot, instances.slice(..));
        match &primitive.indices {
            _ if primitive.topology == Topology::Points => {
                pass.draw(prepared.draw.instances.clone(), 0..primitive.count)
            }
            Some(indices) => {
                pass.set_index_buffer(geometry.indices.slice(indices.clone()), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..primitive.count, 0, prepared.draw.instances.clone());
            }
            None => pass.draw(0..primitive.count, prepared.draw.instances.clone()),
        }
        last = Some(prepared);
    }
}
