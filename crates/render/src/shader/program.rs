//! Programs: a WGSL module with its layouts found by reflection. Uniforms, textures, samplers and vertex inputs are
//! bound by their WGSL names; the names are looked up when a pipeline or a bind group is made, never per draw.

use crate::record::{FRAME_GROUP, FrameSlot};
use naga::front::wgsl;
use naga::valid::{Capabilities, GlobalUse, ValidationFlags, Validator};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// A shader cannot be used as it is.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ProgramError {
    /// The shader does not compile.
    #[error("the shader of pass `{pass}` does not compile:\n{message}")]
    Invalid {
        /// The pass.
        pass: String,
        /// The compiler's message with line and column.
        message: String,
    },
    /// A shader of the user's is wrong.
    #[error(transparent)]
    Text(#[from] Box<crate::diagnostic::Diagnostic>),
    /// The shader declares something that nobody binds.
    #[error(
        "pass `{pass}`: the shader declares `{binding}` (line {line}) in group {group}, which is not among: {known}"
    )]
    Unbound {
        /// The pass.
        pass: String,
        /// The WGSL name.
        binding: String,
        /// The line of its declaration, from 1; of the composed module if the shader is built in.
        line: u32,
        /// Its bind group.
        group: u32,
        /// The names that were offered.
        known: String,
    },
    /// An effect does not fit the frame that it is asked for.
    #[error("the effect `{pass}` cannot be used here: {message}")]
    Misplaced {
        /// The effect.
        pass: String,
        /// Why not.
        message: String,
    },
    /// A uniform of an effect cannot be set.
    #[error("pass `{pass}`: the uniform `{uniform}` cannot be set: {message}")]
    Uniform {
        /// The pass.
        pass: String,
        /// The WGSL name.
        uniform: String,
        /// Why not.
        message: String,
    },
    /// The shader has a vertex input that no attribute is called.
    #[error("pass `{pass}`: the vertex shader has an input `{input}`, which is not among: {known}")]
    UnknownInput {
        /// The pass.
        pass: String,
        /// The WGSL name.
        input: String,
        /// The attributes there are.
        known: String,
    },
}

/// One name of a bind group.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    /// The WGSL name.
    pub name: String,
    /// Where and how it is bound.
    pub entry: wgpu::BindGroupLayoutEntry,
    /// The line of its declaration, from 1.
    pub line: u32,
}

impl Slot {
    /// The error of a shader that declares this slot where nobody binds its name; `known` are those that somebody does.
    pub fn unbound(&self, program: &Program, group: u32, known: String) -> ProgramError {
        let (pass, binding, line) = (program.name.clone(), self.name.clone(), self.line);
        ProgramError::Unbound { pass, binding, line, group, known }
    }
}

/// A compiled module and what it binds.
#[derive(Debug)]
pub struct Program {
    /// The pass it belongs to.
    pub name: String,
    /// No other program has it.
    pub(crate) id: u32,
    /// The module.
    pub module: wgpu::ShaderModule,
    /// The layout of its pipelines.
    pub layout: wgpu::PipelineLayout,
    groups: Vec<(wgpu::BindGroupLayout, Vec<Slot>)>,
    vertex_inputs: Vec<(String, u32)>,
    overrides: Vec<String>,
}

/// An `override` constant with its value.
pub(crate) type Constant = (&'static str, u32);

/// An attribute that a vertex shader may read by its name.
#[derive(Clone, Copy, Debug)]
pub struct Attribute {
    /// The WGSL name.
    pub name: &'static str,
    /// Its format in the buffer.
    pub format: wgpu::VertexFormat,
    /// Its offset in the buffer's stride.
    pub offset: u64,
    /// Which of the buffers.
    pub buffer: usize,
}

impl Program {
    /// Compiles a module and finds what it binds.
    ///
    /// # Errors
    /// The module is not valid WGSL, or declares in group 0 what is not there.
    pub fn new(frame: &FrameLayout, name: &str, source: &str) -> Result<Self, ProgramError> {
        let (module, info) = parse(name, source)?;
        let slots = reflect_bindings(&module, &info, source);
        Self::from_parsed(frame, name, source, &module, slots)
    }

    /// As [`Self::new`], of one of our own modules, whose loops are known to end: they are spared the counter that stops
    /// others, a tenth of what a light costs on a software adapter.
    fn built_in(frame: &FrameLayout, name: &str, source: &'static str) -> Result<Self, ProgramError> {
        let (module, info) = parse(name, source)?;
        let slots = reflect_bindings(&module, &info, source);
        #[allow(unsafe_code, reason = "modules whose loops are not bounded are made by an unsafe call")]
        Self::compiled(frame, name, &module, slots, |device| {
            let descriptor =
                wgpu::ShaderModuleDescriptor { label: Some(name), source: wgpu::ShaderSource::Wgsl(source.into()) };
            let checks =
                wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..wgpu::ShaderRuntimeChecks::checked() };
            // SAFETY: what is asked of the caller is that no loop is infinite. Every loop of a built-in module is a `for` whose
            // integer counter rises by 1 in each round, is changed nowhere else, and ends where it is no longer less than a
            // bound that does not change, so that there are less than 2³² rounds: `tests/shaders.rs` looks at each of them.
            // All other checks stay.
            unsafe { device.create_shader_module_trusted(descriptor, checks) }
        })
    }

    /// The program of a module that has been parsed and validated, with its `slots`.
    pub(crate) fn from_parsed(
        frame: &FrameLayout,
        name: &str,
        source: &str,
        module: &naga::Module,
        slots: Vec<Vec<Slot>>,
    ) -> Result<Self, ProgramError> {
        Self::compiled(frame, name, module, slots, |device| {
            let source = wgpu::ShaderSource::Wgsl(source.into());
            device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source })
        })
    }

    fn compiled(
        frame: &FrameLayout,
        name: &str,
        module: &naga::Module,
        slots: Vec<Vec<Slot>>,
        compile: impl FnOnce(&wgpu::Device) -> wgpu::ShaderModule,
    ) -> Result<Self, ProgramError> {
        let device = &frame.device;
        frame.check(name, slots.first().map_or(&[], Vec::as_slice))?;
        let groups = slots
            .into_iter()
            .map(|slots| {
                let entries: Vec<_> = slots.iter().map(|slot| slot.entry).collect();
                let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some(name),
                    entries: &entries,
                });
                (layout, slots)
            })
            .collect::<Vec<_>>();
        let mut layouts: Vec<_> = groups.iter().map(|(layout, slots)| (!slots.is_empty()).then_some(layout)).collect();
        layouts.resize(layouts.len().max(1), None);
        layouts[0] = Some(&frame.layout);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &layouts,
            ..Default::default()
        });
        let shader = compile(device);
        static NEXT_ID: AtomicU32 = AtomicU32::new(0);
        let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
        let overrides = module.overrides.iter().filter_map(|(_, constant)| constant.name.clone()).collect();
        let vertex_inputs = reflect_inputs(module);
        Ok(Self { name: name.into(), id, module: shader, layout, vertex_inputs, overrides, groups })
    }

    /// Those of `constants` that the module declares, as a pipeline takes them: others are errors in browsers.
    pub(crate) fn constants(&self, constants: &[Constant]) -> Vec<(&'static str, f64)> {
        let declared = constants.iter().filter(|(name, _)| self.overrides.iter().any(|known| known == name));
        declared.map(|(name, value)| (*name, f64::from(*value))).collect()
    }

    /// What the module binds in `group`.
    pub(crate) fn slots(&self, group: u32) -> &[Slot] {
        self.groups.get(group as usize).map_or(&[], |(_, slots)| slots)
    }

    /// The layout of `group`, if the module binds anything in it. Group 0 has that of all programs.
    pub(crate) fn group_layout(&self, group: u32) -> Option<&wgpu::BindGroupLayout> {
        self.groups.get(group as usize).filter(|(_, slots)| !slots.is_empty()).map(|(layout, _)| layout)
    }

    /// Whether the module binds anything in `group`.
    pub fn uses_group(&self, group: u32) -> bool {
        self.groups.get(group as usize).is_some_and(|(_, slots)| !slots.is_empty())
    }

    /// Makes the bind group `group` from `resources`, each found by its WGSL name; resources that the module does not
    /// use are passed over.
    ///
    /// # Errors
    /// The module declares a name that is not among the resources.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        group: u32,
        resources: &[(&str, wgpu::BindingResource<'_>)],
    ) -> Result<wgpu::BindGroup, ProgramError> {
        let Some((layout, slots)) = self.groups.get(group as usize) else {
            return Err(ProgramError::Unbound {
                pass: self.name.clone(),
                binding: "nothing".into(),
                line: 1,
                group,
                known: String::new(),
            });
        };
        let mut entries = Vec::with_capacity(slots.len());
        for slot in slots {
            let (_, resource) = resources.iter().find(|(name, _)| *name == slot.name).ok_or_else(|| {
                slot.unbound(self, group, resources.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "))
            })?;
            entries.push(wgpu::BindGroupEntry { binding: slot.entry.binding, resource: resource.clone() });
        }
        Ok(device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(&self.name), layout, entries: &entries }))
    }

    /// The attributes that the vertex shader reads, by buffer.
    ///
    /// # Errors
    /// The vertex shader has an input that no attribute is called.
    pub fn attributes(
        &self,
        known: &[Attribute],
        buffers: usize,
    ) -> Result<Vec<Vec<wgpu::VertexAttribute>>, ProgramError> {
        let mut layouts = vec![Vec::new(); buffers];
        for (input, location) in &self.vertex_inputs {
            let attribute =
                known.iter().find(|attribute| attribute.name == input).ok_or_else(|| ProgramError::UnknownInput {
                    pass: self.name.clone(),
                    input: input.clone(),
                    known: known.iter().map(|attribute| attribute.name).collect::<Vec<_>>().join(", "),
                })?;
            layouts[attribute.buffer].push(wgpu::VertexAttribute {
                format: attribute.format,
                offset: attribute.offset,
                shader_location: *location,
            });
        }
        Ok(layouts)
    }
}

/// Parses and validates a built-in module.
fn parse(pass: &str, source: &str) -> Result<(naga::Module, naga::valid::ModuleInfo), ProgramError> {
    let invalid = |message: String| ProgramError::Invalid { pass: pass.into(), message };
    let module = wgsl::parse_str(source).map_err(|error| invalid(error.emit_to_string(source)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::default())
        .validate(&module)
        .map_err(|error| invalid(error.emit_to_string(source)))?;
    Ok((module, info))
}

fn stages_of(
    info: &naga::valid::ModuleInfo,
    module: &naga::Module,
    global: naga::Handle<naga::GlobalVariable>,
) -> wgpu::ShaderStages {
    let mut stages = wgpu::ShaderStages::empty();
    for (index, entry) in module.entry_points.iter().enumerate() {
        if info.get_entry_point(index)[global] != GlobalUse::empty() {
            stages |= match entry.stage {
                naga::ShaderStage::Vertex => wgpu::ShaderStages::VERTEX,
                naga::ShaderStage::Fragment => wgpu::ShaderStages::FRAGMENT,
                _ => wgpu::ShaderStages::COMPUTE,
            };
        }
    }
    stages
}

/// The textures that are used with a filtering sampler. A sampler whose name begins with `nearest` does not filter.
fn filtered_textures(module: &naga::Module, info: &naga::valid::ModuleInfo) -> Vec<naga::Handle<naga::GlobalVariable>> {
    let mut filtered = Vec::new();
    for index in 0..module.entry_points.len() {
        for key in &info.get_entry_point(index).sampling_set {
            if !samples_nearest(module, key.sampler) {
                filtered.push(key.image);
            }
        }
    }
    filtered
}

fn samples_nearest(module: &naga::Module, sampler: naga::Handle<naga::GlobalVariable>) -> bool {
    module.global_variables[sampler].name.as_deref().is_some_and(|name| name.starts_with("nearest"))
}

/// What the module's entry points bind, by group.
pub(crate) fn reflect_bindings(module: &naga::Module, info: &naga::valid::ModuleInfo, source: &str) -> Vec<Vec<Slot>> {
    let filtered = filtered_textures(module, info);
    let mut groups: Vec<Vec<Slot>> = Vec::new();
    for (handle, global) in module.global_variables.iter() {
        let Some(binding) = global.binding else { continue };
        let visibility = stages_of(info, module, handle);
        if visibility.is_empty() {
            continue;
        }
        let ty = match &module.types[global.ty].inner {
            naga::TypeInner::Image { dim, arrayed, class } => {
                texture_type(*dim, *arrayed, *class, filtered.contains(&handle))
            }
            naga::TypeInner::Sampler { comparison } => wgpu::BindingType::Sampler(if *comparison {
                wgpu::SamplerBindingType::Comparison
            } else if samples_nearest(module, handle) {
                wgpu::SamplerBindingType::NonFiltering
            } else {
                wgpu::SamplerBindingType::Filtering
            }),
            _ => wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
        };
        let group = binding.group as usize;
        if groups.len() <= group {
            groups.resize_with(group + 1, Vec::new);
        }
        groups[group].push(Slot {
            name: global.name.clone().unwrap_or_default(),
            entry: wgpu::BindGroupLayoutEntry { binding: binding.binding, visibility, ty, count: None },
            line: module.global_variables.get_span(handle).location(source).line_number,
        });
    }
    groups
}

fn texture_type(
    dim: naga::ImageDimension,
    arrayed: bool,
    class: naga::ImageClass,
    filterable: bool,
) -> wgpu::BindingType {
    let (sample_type, multisampled) = match class {
        naga::ImageClass::Sampled { kind, multi } => (
            match kind {
                naga::ScalarKind::Uint => wgpu::TextureSampleType::Uint,
                naga::ScalarKind::Sint => wgpu::TextureSampleType::Sint,
                _ => wgpu::TextureSampleType::Float { filterable },
            },
            multi,
        ),
        naga::ImageClass::Depth { multi } => (wgpu::TextureSampleType::Depth, multi),
        _ => (wgpu::TextureSampleType::Float { filterable: false }, false),
    };
    let view_dimension = match (dim, arrayed) {
        (naga::ImageDimension::D1, _) => wgpu::TextureViewDimension::D1,
        (naga::ImageDimension::D2, false) => wgpu::TextureViewDimension::D2,
        (naga::ImageDimension::D2, true) => wgpu::TextureViewDimension::D2Array,
        (naga::ImageDimension::D3, _) => wgpu::TextureViewDimension::D3,
        (naga::ImageDimension::Cube, _) => wgpu::TextureViewDimension::Cube,
    };
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled }
}

fn reflect_inputs(module: &naga::Module) -> Vec<(String, u32)> {
    let mut inputs = Vec::new();
    for entry in module.entry_points.iter().filter(|entry| entry.stage == naga::ShaderStage::Vertex) {
        for argument in &entry.function.arguments {
            if let (Some(naga::Binding::Location { location, .. }), Some(name)) = (&argument.binding, &argument.name) {
                inputs.push((name.clone(), *location));
            }
            if let naga::TypeInner::Struct { members, .. } = &module.types[argument.ty].inner {
                for member in members {
                    if let (Some(naga::Binding::Location { location, .. }), Some(name)) =
                        (&member.binding, &member.name)
                    {
                        inputs.push((name.clone(), *location));
                    }
                }
            }
        }
    }
    inputs
}

/// A pipeline that draws one triangle over the whole target.
#[derive(Debug)]
pub struct FullscreenPipeline {
    /// Its program.
    pub program: Arc<Program>,
    /// The pipeline.
    pub pipeline: wgpu::RenderPipeline,
}

impl FullscreenPipeline {
    /// A pipeline of the vertex stage of `triangle` and the fragment stage of `program`.
    pub fn new(
        device: &wgpu::Device,
        program: Arc<Program>,
        triangle: &Program,
        format: wgpu::TextureFormat,
        blend: Option<wgpu::BlendState>,
        depth: Option<DepthTest>,
        constants: &[Constant],
    ) -> Self {
        let constants = program.constants(constants);
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(&program.name),
            layout: Some(&program.layout),
            vertex: wgpu::VertexState {
                module: &triangle.module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: depth.map(|(format, compare)| wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(false),
                depth_compare: Some(compare),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &program.module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                targets: &[Some(wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL })],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { program, pipeline }
    }
}

type ProgramKey = (&'static str, Vec<&'static str>);
type FullscreenKey = (ProgramKey, wgpu::TextureFormat, Option<wgpu::BlendState>, Option<DepthTest>, Vec<Constant>);

/// The format of the depth buffer, and how depth 0, where the triangle lies, compares with what is there.
pub type DepthTest = (wgpu::TextureFormat, wgpu::CompareFunction);

/// The layout of group 0, which all programs have in common.
#[derive(Clone, Debug)]
pub struct FrameLayout {
    device: wgpu::Device,
    layout: wgpu::BindGroupLayout,
}

impl FrameLayout {
    /// The layout on a device.
    pub fn new(device: &wgpu::Device) -> Self {
        let entry = |(binding, slot): (u32, &FrameSlot)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: slot.ty,
            count: None,
        };
        let entries: Vec<_> = (0..).zip(&FRAME_GROUP).map(entry).collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some("frame"), entries: &entries };
        Self { device: device.clone(), layout: device.create_bind_group_layout(&descriptor) }
    }

    /// Whether what a module declares in group 0 is there.
    fn check(&self, pass: &str, slots: &[Slot]) -> Result<(), ProgramError> {
        for slot in slots {
            let there = FRAME_GROUP.get(slot.entry.binding as usize);
            if there.is_none_or(|there| there.name != slot.name) {
                return Err(ProgramError::Unbound {
                    pass: pass.into(),
                    binding: slot.name.clone(),
                    line: slot.line,
                    group: 0,
                    known: FRAME_GROUP.iter().map(|slot| slot.name).collect::<Vec<_>>().join(", "),
                });
            }
        }
        Ok(())
    }
}

/// Every program and full-screen pipeline made so far.
#[derive(Debug)]
pub struct Shaders {
    frame: FrameLayout,
    made: Cell<u64>,
    programs: RefCell<HashMap<ProgramKey, Arc<Program>>>,
    fullscreen: RefCell<HashMap<FullscreenKey, Arc<FullscreenPipeline>>>,
    depth_clears: RefCell<HashMap<wgpu::TextureFormat, wgpu::RenderPipeline>>,
    compile_ms: Cell<f64>,
}

impl Shaders {
    /// No program yet.
    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            frame: FrameLayout::new(device),
            made: Cell::default(),
            programs: RefCell::default(),
            fullscreen: RefCell::default(),
            depth_clears: RefCell::default(),
            compile_ms: Cell::default(),
        }
    }

    /// The layout of group 0 of all programs.
    pub(crate) fn frame_layout(&self) -> &wgpu::BindGroupLayout {
        &self.frame.layout
    }

    /// How many programs and pipelines were made so far.
    pub(crate) fn made(&self) -> u64 {
        self.made.get()
    }

    /// Runs `compile` and counts it and its time.
    pub(crate) fn compiling<T>(&self, compile: impl FnOnce() -> T) -> T {
        self.made.set(self.made.get() + 1);
        let started = web_time::Instant::now();
        let result = compile();
        self.compile_ms.set(self.compile_ms.get() + started.elapsed().as_secs_f64() * 1e3);
        result
    }

    /// Milliseconds spent on programs and pipelines so far. A driver may do more of it when it first draws.
    pub fn compile_ms(&self) -> f64 {
        self.compile_ms.get()
    }

    /// The program `name` with the given axes on.
    ///
    /// # Errors
    /// The program does not compile or does not exist.
    pub fn program(&self, name: &'static str, axes_on: &[&'static str]) -> Result<Arc<Program>, ProgramError> {
        let key = (name, axes_on.to_vec());
        if let Some(program) = self.programs.borrow().get(&key) {
            return Ok(program.clone());
        }
        let source = super::compose::source(name, axes_on)
            .map_err(|message| ProgramError::Invalid { pass: name.into(), message })?;
        let program = Arc::new(self.compiling(|| Program::built_in(&self.frame, name, source))?);
        self.programs.borrow_mut().insert(key, program.clone());
        Ok(program)
    }

    /// The pipeline that sets depth to 0 where it draws, because no part of a texture can be cleared for itself.
    ///
    /// # Errors
    /// The program does not compile.
    pub fn depth_clear(&self, format: wgpu::TextureFormat) -> Result<wgpu::RenderPipeline, ProgramError> {
        if let Some(pipeline) = self.depth_clears.borrow().get(&format) {
            return Ok(pipeline.clone());
        }
        let triangle = self.program("fullscreen", &[])?;
        let depth_stencil = wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        };
        let descriptor = wgpu::RenderPipelineDescriptor {
            label: Some("depth_clear"),
            layout: Some(&triangle.layout),
            vertex: wgpu::VertexState {
                module: &triangle.module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(depth_stencil),
            multisample: Default::default(),
            fragment: None,
            multiview_mask: None,
            cache: None,
        };
        let pipeline = self.compiling(|| self.frame.device.create_render_pipeline(&descriptor));
        self.depth_clears.borrow_mut().insert(format, pipeline.clone());
        Ok(pipeline)
    }

    /// The pipeline that draws the program `name` over a whole target of `format`, where depth passes the test.
    ///
    /// # Errors
    /// The program does not compile or does not exist.
    pub fn fullscreen(
        &self,
        name: &'static str,
        axes_on: &[&'static str],
        format: wgpu::TextureFormat,
        blend: Option<wgpu::BlendState>,
        depth: Option<DepthTest>,
        constants: &[Constant],
    ) -> Result<Arc<FullscreenPipeline>, ProgramError> {
        let declared = constants.iter().filter(|(constant, _)| super::compose::has_constant(name, constant));
        let key = ((name, axes_on.to_vec()), format, blend, depth, declared.copied().collect());
        if let Some(pipeline) = self.fullscreen.borrow().get(&key) {
            return Ok(pipeline.clone());
        }
        let program = self.program(name, axes_on)?;
        let triangle = self.program("fullscreen", &[])?;
        let create =
            || FullscreenPipeline::new(&self.frame.device, program, &triangle, format, blend, depth, constants);
        let pipeline = Arc::new(self.compiling(create));
        self.fullscreen.borrow_mut().insert(key, pipeline.clone());
        Ok(pipeline)
    }
}
