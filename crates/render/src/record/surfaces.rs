//! Passes that draw the scene's surfaces: the pipelines of their programs, and the loop over a list of draws.

use super::bind_groups::Resource;
use super::uniforms::Uniform;
use super::{Frame, PreparedView};
use crate::draws::{Draw, Faces};
use crate::resources::GpuMaterial;
use crate::resources::geometry::{ATTRIBUTES, STRIDES};
use crate::shader::program::ProgramError;
use crate::shader::{Program, Shaders, compose};
use bytemuck::Pod;
use manypass_graph::{ColorLoad, DepthLoad, Handle, Pass, PassContext};
use manypass_scene::Topology;
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// The axes of programs that draw surfaces. A set of them is a number with their bits.
const AXES: [&str; 5] = ["textured", "occlusion_apart", "normal_map", "masked", "deformed"];

type Axes = u32;

/// Which targets a program draws into, and how.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Targets {
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
    axes: Axes,
    targets: Targets,
    topology: Topology,
    faces: Faces,
    mirrored: bool,
}

/// A pipeline with its program.
#[derive(Debug)]
pub(crate) struct SurfacePipeline {
    program: Arc<Program>,
    pipeline: wgpu::RenderPipeline,
}

/// Every pipeline that draws surfaces made so far.
#[derive(Debug, Default)]
pub(crate) struct SurfacePipelines {
    pipelines: RefCell<HashMap<Key, Arc<SurfacePipeline>>>,
}

impl SurfacePipelines {
    fn get(&self, shaders: &Shaders, device: &wgpu::Device, key: Key) -> Result<Arc<SurfacePipeline>, ProgramError> {
        if let Some(pipeline) = self.pipelines.borrow().get(&key) {
            return Ok(pipeline.clone());
        }
        let on = AXES
            .iter()
            .enumerate()
            .filter(|(bit, axis)| key.axes >> bit & 1 == 1 && compose::has_axis(key.program, axis));
        let axes: Vec<_> = on.map(|(_, axis)| *axis).collect();
        let program = shaders.program(key.program, &axes)?;
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

/// Which of the draws of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// Every one.
    All,
    /// Those whose fragments are never dropped: triangles without a mask.
    Hiding,
}

/// A pass that draws surfaces and is being declared: its targets, and what its shader binds in group 1, by WGSL name.
#[must_use = "nothing is drawn before `draw`"]
pub struct SurfacePass<'r, 'f> {
    pass: Pass<'r, 'f>,
    frame: &'f Frame<'f>,
    view: &'f PreparedView,
    program: &'static str,
    uniforms: Vec<(&'static str, Uniform)>,
    colors: Vec<wgpu::TextureFormat>,
    blend: Option<wgpu::BlendState>,
    depth: Option<(wgpu::TextureFormat, bool)>,
}

impl<'r, 'f> SurfacePass<'r, 'f> {
    pub(super) fn new(pass: Pass<'r, 'f>, frame: &'f Frame<'f>, view: &'f PreparedView, program: &'static str) -> Self {
        Self { pass, frame, view, program, uniforms: Vec::new(), colors: Vec::new(), blend: None, depth: None }
    }

    /// The next colour target. Without one no fragment is shaded. Returns the version that holds the result.
    pub fn color(&mut self, target: Handle, load: ColorLoad) -> Handle {
        self.colors.push(target.desc().format);
        self.pass.color(target, load)
    }

    /// Writes depth and tests against it. Returns the version that holds the result.
    pub fn depth(&mut self, target: Handle, load: DepthLoad) -> Handle {
        self.depth = Some((target.desc().format, true));
        self.pass.depth_stencil(target, load)
    }

    /// Tests against depth; what lies at the same depth passes.
    pub fn depth_read_only(&mut self, depth: &Handle) {
        self.depth = Some((depth.desc().format, false));
        self.pass.depth_stencil_read_only(depth);
    }

    /// The same blend state for all targets, because the floor has one.
    pub fn blend(&mut self, blend: wgpu::BlendState) {
        self.blend = Some(blend);
    }

    /// The shader finds `value` in the uniform `name`.
    pub fn uniform<T: Pod>(&mut self, name: &'static str, value: &T) {
        self.uniforms.push((name, self.frame.uniforms.push(value)));
    }

    /// Declares the pass: it draws the view's opaque and masked surfaces.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds; or no depth was given.
    pub fn draw_opaque(self, which: Which) -> Result<(), ProgramError> {
        let draws = &self.view.draws.opaque;
        self.draw(draws, which)
    }

    /// Declares the pass: it draws the view's blended surfaces, farther ones first.
    ///
    /// # Errors
    /// As [`Self::draw_opaque`].
    pub fn draw_blended(self) -> Result<(), ProgramError> {
        let draws = &self.view.draws.blended;
        self.draw(draws, Which::All)
    }

    fn draw(self, draws: &'f [Draw], which: Which) -> Result<(), ProgramError> {
        let Self { pass, frame, view, program, uniforms, colors, blend, depth } = self;
        let Some((depth, depth_write)) = depth else {
            let message = "it was given no depth".into();
            return Err(ProgramError::Invalid { pass: program.into(), message });
        };
        let targets = Targets { colors, blend, depth, depth_write };
        let list = prepare(frame, view, program, &targets, &uniforms, (draws, which))?;
        pass.draw(move |context| list.draw(context, frame, view, draws));
        Ok(())
    }
}

/// A pipeline with the groups that are the same for all of its draws.
struct Bound {
    pipeline: Arc<SurfacePipeline>,
    pass: Option<wgpu::BindGroup>,
    object: Option<wgpu::BindGroup>,
}

/// A draw of the list, its pipeline and its material.
struct Step {
    draw: u32,
    bound: u32,
    /// None if the program reads nothing of it.
    material: Option<wgpu::BindGroup>,
}

/// Draws with all that they bind.
struct PreparedList {
    bound: Vec<Bound>,
    steps: Vec<Step>,
}

/// What tells the pipelines of one pass apart, as a number below [`Shape::COUNT`].
struct Shape {
    axes: Axes,
    topology: Topology,
    faces: Faces,
    mirrored: bool,
}

impl Shape {
    const COUNT: usize = (1 << AXES.len()) * 3 * 3 * 2;

    fn index(&self) -> usize {
        let topology = match self.topology {
            Topology::Points => 0,
            Topology::Lines => 1,
            Topology::Triangles => 2,
        };
        let faces = match self.faces {
            Faces::Both => 0,
            Faces::Front => 1,
            Faces::Back => 2,
        };
        ((self.axes as usize * 3 + topology) * 3 + faces) * 2 + usize::from(self.mirrored)
    }
}

fn prepare<'f>(
    frame: &'f Frame<'f>,
    view: &'f PreparedView,
    program: &'static str,
    targets: &Targets,
    uniforms: &[(&'static str, Uniform)],
    (draws, which): (&'f [Draw], Which),
) -> Result<PreparedList, ProgramError> {
    let resources = frame.resources;
    let is_reflected = view.is_reflected();
    let mut by_shape = vec![None; Shape::COUNT];
    let mut list = PreparedList { bound: Vec::new(), steps: Vec::with_capacity(draws.len()) };
    let mut last: Option<(u32, usize, Option<wgpu::BindGroup>)> = None;
    for (index, draw) in draws.iter().enumerate() {
        let primitive = &resources.geometry.meshes[draw.mesh][draw.primitive];
        let material = &resources.materials[draw.material];
        let is_points = primitive.topology == Topology::Points;
        if which == Which::Hiding && (material.masked || primitive.topology != Topology::Triangles) {
            continue;
        }
        let axes = [
            material.textured,
            material.occlusion_apart,
            material.normal_map,
            material.masked,
            primitive.skin.is_some(),
        ];
        let shape = Shape {
            axes: axes.iter().enumerate().fold(0, |axes, (bit, on)| axes | Axes::from(*on) << bit),
            topology: primitive.topology,
            faces: draw.faces,
            // Discs face the eye however their object is mirrored.
            mirrored: (draw.mirrored && !is_points) != is_reflected,
        };
        let bound = match by_shape[shape.index()] {
            Some(bound) => bound,
            None => {
                let program = if is_points { of_points(program)? } else { program };
                let bound = list.bound.len() as u32;
                by_shape[shape.index()] = Some(bound);
                let Shape { axes, topology, faces, mirrored } = shape;
                let key = Key { program, axes, targets: targets.clone(), topology, faces, mirrored };
                list.bound.push(bind(frame, key, uniforms)?);
                bound
            }
        };
        let material = match &last {
            Some((of, material, group)) if (*of, *material) == (bound, draw.material) => group.clone(),
            _ => material_bind_group(frame, view, &list.bound[bound as usize].pipeline.program, material)?,
        };
        last = Some((bound, draw.material, material.clone()));
        list.steps.push(Step { draw: index as u32, bound, material });
    }
    Ok(list)
}

fn bind(frame: &Frame<'_>, key: Key, uniforms: &[(&'static str, Uniform)]) -> Result<Bound, ProgramError> {
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
    let of_pass: Vec<_> = uniforms.iter().map(|(name, uniform)| (*name, Resource::Uniform(uniform.clone()))).collect();
    let pass = named(1, &of_pass)?;
    let resources = frame.resources;
    let texture = |table: &crate::gpu::data_texture::DataTexture| Resource::Texture(table.view().clone());
    let object = named(
        3,
        &[
            ("joint_matrices", texture(&resources.joint_matrices)),
            ("morph_displacements", texture(&resources.morph_displacements)),
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
    material: &GpuMaterial,
) -> Result<Option<wgpu::BindGroup>, ProgramError> {
    if !program.uses_group(2) {
        return Ok(None);
    }
    let sampling = view.sampling;
    let known = material.bind_groups.borrow();
    if let Some((_, _, group)) = known.iter().find(|(id, with, _)| (*id, *with) == (program.id, sampling)) {
        return Ok(Some(group.clone()));
    }
    drop(known);
    let textures = &frame.resources.textures;
    let view = |slot: usize| wgpu::BindingResource::TextureView(textures.view(material.textures[slot]));
    let samplers = material.textures.map(|texture| textures.sampler(texture, sampling));
    let sampler = |slot: usize| wgpu::BindingResource::Sampler(&samplers[slot]);
    let group = program.bind(
        &frame.gpu.device,
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
    material.bind_groups.borrow_mut().push((program.id, sampling, group.clone()));
    Ok(Some(group))
}

impl PreparedList {
    fn draw(self, context: &mut PassContext<'_, '_>, frame: &Frame<'_>, view: &PreparedView, draws: &[Draw]) {
        let pass = &mut *context.render_pass;
        let geometry = &frame.resources.geometry;
        pass.set_bind_group(0, &view.group, &[]);
        let mut last: Option<&Step> = None;
        for step in &self.steps {
            let (draw, bound) = (&draws[step.draw as usize], &self.bound[step.bound as usize]);
            let primitive = &geometry.meshes[draw.mesh][draw.primitive];
            if last.is_none_or(|last| last.bound != step.bound) {
                pass.set_pipeline(&bound.pipeline.pipeline);
                if let Some(group) = &bound.pass {
                    pass.set_bind_group(1, group, &[]);
                }
                if let Some(object) = &bound.object {
                    pass.set_bind_group(3, object, &[]);
                }
                last = None;
            }
            let is_new = last.is_none_or(|last| draws[last.draw as usize].material != draw.material);
            if let (true, Some(material)) = (is_new, &step.material) {
                pass.set_bind_group(2, material, &[]);
            }
            pass.set_vertex_buffer(0, geometry.vertices.slice(primitive.vertices.clone()));
            let mut slot = 1;
            if let Some(skin) = &primitive.skin {
                pass.set_vertex_buffer(slot, geometry.skins.slice(skin.clone()));
                slot += 1;
            }
            pass.set_vertex_buffer(slot, view.instances.slice(..));
            match &primitive.indices {
                _ if primitive.topology == Topology::Points => pass.draw(draw.instances.clone(), 0..primitive.count),
                Some(indices) => {
                    pass.set_index_buffer(geometry.indices.slice(indices.clone()), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..primitive.count, 0, draw.instances.clone());
                }
                None => pass.draw(0..primitive.count, draw.instances.clone()),
            }
            last = Some(step);
        }
    }
}
