//! Programs: a WGSL module with its layouts found by reflection. Uniforms, textures, samplers and vertex inputs are
//! bound by their WGSL names; the names are looked up when a pipeline or a bind group is made, never per draw.

use super::frame_group::{FRAME_GROUP, FrameSlot};
use super::reflection::{parse, reflect_bindings, reflect_inputs};
use std::sync::atomic::{AtomicU32, Ordering};
#[cfg(not(target_arch = "wasm32"))]
use {
    super::specialise,
    std::borrow::Cow,
    std::collections::HashMap,
    std::sync::{Mutex, PoisonError},
};

/// A shader cannot be used as it is.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
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
    /// A simulation cannot be run, or goes no further.
    #[error("the simulation `{simulation}` cannot be shown: {message}")]
    Simulation {
        /// The simulation.
        simulation: String,
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
    /// The text of a shader cannot be written where the variable `MANYPASS_SHADER_DUMP` says.
    #[error("the shader of pass `{pass}` cannot be written to {folder}, the folder of {variable}: {message}")]
    Dump {
        /// The pass.
        pass: String,
        /// The folder.
        folder: String,
        /// The variable.
        variable: &'static str,
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
    modules: Modules,
    /// The layout of its pipelines.
    pub layout: wgpu::PipelineLayout,
    groups: Vec<(wgpu::BindGroupLayout, Vec<Slot>)>,
    vertex_inputs: Vec<(String, u32)>,
    overrides: Vec<String>,
    /// Whether it has a vertex stage of its own.
    pub(super) has_vertices: bool,
    /// Which of the module's entry points it is; none where there is one of each stage.
    pub(super) entry_point: Option<String>,
}

/// What pipelines are made of.
#[derive(Debug)]
enum Modules {
    /// One module for all, which is given constants.
    Whole(wgpu::ShaderModule),
    /// A module for each set of constants, without what these switch off.
    #[cfg(not(target_arch = "wasm32"))]
    Specialised {
        device: wgpu::Device,
        parsed: Box<(naga::Module, naga::valid::ModuleInfo)>,
        made: Mutex<HashMap<Vec<Constant>, wgpu::ShaderModule>>,
    },
}

/// A module, and the values of those of its constants that are not as they are declared.
#[derive(Debug)]
pub(crate) struct SpecialisedModule {
    pub module: wgpu::ShaderModule,
    pub constants: Vec<(&'static str, f64)>,
}

impl SpecialisedModule {
    /// How a stage is compiled.
    pub fn options(&self) -> wgpu::PipelineCompilationOptions<'_> {
        wgpu::PipelineCompilationOptions { constants: &self.constants, ..Default::default() }
    }
}

/// What pipelines are told of a module.
struct ModuleInterface {
    vertex_inputs: Vec<(String, u32)>,
    overrides: Vec<String>,
    has_vertices: bool,
}

impl ModuleInterface {
    fn of(module: &naga::Module) -> Self {
        let overrides = module.overrides.iter().filter_map(|(_, constant)| constant.name.clone()).collect();
        let has_vertices = module.entry_points.iter().any(|entry| entry.stage == naga::ShaderStage::Vertex);
        Self { vertex_inputs: reflect_inputs(module), overrides, has_vertices }
    }
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
        Self::compiled(frame, name, ModuleInterface::of(&module), slots, |device| {
            let source = wgpu::ShaderSource::Wgsl(source.into());
            Modules::Whole(device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source }))
        })
    }

    /// As [`Self::new`], of one of our own modules, whose loops are known to end: they are spared the counter that
    /// stops others, a tenth of what a light costs on a software adapter.
    pub(super) fn built_in(frame: &FrameLayout, name: &str, source: &str) -> Result<Self, ProgramError> {
        let (module, info) = parse(name, source)?;
        let slots = reflect_bindings(&module, &info, source);
        // What has been parsed need not be parsed again; browsers have a parser of their own.
        #[cfg(not(target_arch = "wasm32"))]
        return Self::compiled(frame, name, ModuleInterface::of(&module), slots, |device| {
            if module.overrides.is_empty() {
                return Modules::Whole(trusted(device, name, wgpu::ShaderSource::Naga(Cow::Owned(module))));
            }
            Modules::Specialised { device: device.clone(), parsed: Box::new((module, info)), made: Mutex::default() }
        });
        #[cfg(target_arch = "wasm32")]
        Self::compiled(frame, name, ModuleInterface::of(&module), slots, |device| {
            Modules::Whole(trusted(device, name, wgpu::ShaderSource::Wgsl(source.into())))
        })
    }

    /// The program of one entry point of a module that has been parsed and validated, with its `slots`.
    pub(crate) fn of_entry_point(
        frame: &FrameLayout,
        name: &str,
        compiled: &wgpu::ShaderModule,
        (module, entry_point): (&naga::Module, &str),
        slots: Vec<Vec<Slot>>,
    ) -> Result<Self, ProgramError> {
        let program =
            Self::compiled(frame, name, ModuleInterface::of(module), slots, |_| Modules::Whole(compiled.clone()))?;
        Ok(Self { entry_point: Some(entry_point.into()), has_vertices: false, ..program })
    }

    fn compiled(
        frame: &FrameLayout,
        name: &str,
        ModuleInterface { vertex_inputs, overrides, has_vertices }: ModuleInterface,
        slots: Vec<Vec<Slot>>,
        compile: impl FnOnce(&wgpu::Device) -> Modules,
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
        let modules = compile(device);
        static NEXT_ID: AtomicU32 = AtomicU32::new(0);
        let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
        Ok(Self {
            name: name.into(),
            id,
            modules,
            layout,
            vertex_inputs,
            overrides,
            has_vertices,
            entry_point: None,
            groups,
        })
    }

    /// What a pipeline with `constants` is made of. Those that the module does not declare, which are errors in
    /// browsers, are passed over; of those of one name the last counts.
    pub(crate) fn specialised(&self, constants: &[Constant]) -> SpecialisedModule {
        let mut declared: Vec<Constant> = Vec::new();
        for constant in constants.iter().filter(|(name, _)| self.overrides.iter().any(|known| known == name)) {
            declared.retain(|(name, _)| *name != constant.0);
            declared.push(*constant);
        }
        match &self.modules {
            Modules::Whole(module) => {
                let constants = declared.iter().map(|(name, value)| (*name, f64::from(*value))).collect();
                SpecialisedModule { module: module.clone(), constants }
            }
            #[cfg(not(target_arch = "wasm32"))]
            Modules::Specialised { device, parsed, made } => {
                declared.sort_unstable();
                let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
                let module = made.entry(declared).or_insert_with_key(|declared| {
                    let (module, info) = &**parsed;
                    // Our own values are of the constants' types.
                    let module = specialise::specialised(module, info, declared).unwrap_or_else(|| module.clone());
                    trusted(device, &self.name, wgpu::ShaderSource::Naga(Cow::Owned(module)))
                });
                SpecialisedModule { module: module.clone(), constants: Vec::new() }
            }
        }
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

/// One of our own modules, without the counters that end endless loops.
#[allow(unsafe_code, reason = "modules whose loops are not bounded are made by an unsafe call")]
fn trusted(device: &wgpu::Device, name: &str, source: wgpu::ShaderSource<'_>) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(name), source };
    let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..wgpu::ShaderRuntimeChecks::checked() };
    // SAFETY: what is asked of the caller is that no loop is infinite. Every loop of a built-in module is a `for` whose
    // integer counter rises by 1 in each round, is changed nowhere else, and ends where it is no longer less than a
    // bound that does not change, so that there are less than 2³² rounds: `tests/shaders.rs` looks at each of them.
    // All other checks stay.
    unsafe { device.create_shader_module_trusted(descriptor, checks) }
}

/// The layout of group 0, which all programs have in common.
#[derive(Clone, Debug)]
pub struct FrameLayout {
    pub(super) device: wgpu::Device,
    pub(super) layout: wgpu::BindGroupLayout,
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
