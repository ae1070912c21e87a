//! Every program and full-screen pipeline is made once.

use super::pipeline::{Make, Makers, Pipeline};
use super::program::{Constant, FrameLayout, Program, ProgramError};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::sync::Arc;

/// A pipeline that draws one triangle over the whole target.
#[derive(Debug)]
pub struct FullscreenPipeline {
    /// Its program.
    pub program: Arc<Program>,
    /// The pipeline.
    pub pipeline: Pipeline,
}

impl FullscreenPipeline {
    /// A pipeline of the fragment stage of `program`, and of its vertex stage, or that of `triangle` if it has none.
    pub fn new(
        device: &wgpu::Device,
        program: Arc<Program>,
        triangle: &Program,
        target: FullscreenTarget,
        constants: &[Constant],
    ) -> Self {
        let pipeline = Pipeline::made(Self::make(device, &program, triangle, target, constants));
        Self { program, pipeline }
    }

    fn make(
        device: &wgpu::Device,
        program: &Program,
        triangle: &Program,
        target: FullscreenTarget,
        constants: &[Constant],
    ) -> wgpu::RenderPipeline {
        let FullscreenTarget { format, samples, blend, depth } = target;
        let (triangle, specialised) = (triangle.specialised(&[]), program.specialised(constants));
        let vertices = if program.has_vertices { &specialised } else { &triangle };
        let color = |format| Some(wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL });
        let targets = format.map(color);
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(&program.name),
            layout: Some(&program.layout),
            vertex: wgpu::VertexState {
                module: &vertices.module,
                entry_point: None,
                compilation_options: vertices.options(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: depth.map(|DepthTest { format, compare, writes, stencil }| wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(writes),
                depth_compare: Some(compare),
                stencil: stencil.state(),
                bias: Default::default(),
            }),
            multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &specialised.module,
                entry_point: program.entry_point.as_deref(),
                compilation_options: specialised.options(),
                targets: targets.as_slice(),
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

type ProgramKey = (&'static str, Vec<&'static str>);
type FullscreenKey = (ProgramKey, FullscreenTarget, Vec<Constant>);

/// What a pipeline draws into, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FullscreenTarget {
    /// The format of the colour target, if there is one.
    pub format: Option<wgpu::TextureFormat>,
    /// Its samples a texel, and those of the depth buffer.
    pub samples: u32,
    /// How what is drawn and what is there become one; without it what is drawn replaces it.
    pub blend: Option<wgpu::BlendState>,
    /// Where is drawn, and whether depth is; without it everywhere, and there is none.
    pub depth: Option<DepthTest>,
}

impl FullscreenTarget {
    /// All of a target of one sample a texel, whose contents are replaced.
    pub const fn of(format: wgpu::TextureFormat) -> Self {
        Self { format: Some(format), samples: 1, blend: None, depth: None }
    }
}

/// What a pipeline does with the depth buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DepthTest {
    /// Its format.
    pub format: wgpu::TextureFormat,
    /// How the triangle's depth compares with what is there.
    pub compare: wgpu::CompareFunction,
    /// Whether the triangle's depth replaces it.
    pub writes: bool,
    /// What is done with the stencil.
    pub stencil: StencilUse,
}

/// The bit of the stencil that is set where tiles of a still are settled. Light volumes have another.
pub const SETTLED_BIT: u32 = 2;

/// What a pipeline does with the bit of settled tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StencilUse {
    /// Nothing.
    Ignored,
    /// Draws where it is 0.
    Unsettled,
    /// Makes it 0 where it draws, whatever it is.
    Unsettles,
}

impl StencilUse {
    fn state(self) -> wgpu::StencilState {
        let (compare, pass_op, mask) = match self {
            Self::Ignored => return wgpu::StencilState::default(),
            Self::Unsettled => (wgpu::CompareFunction::Equal, wgpu::StencilOperation::Keep, 0),
            Self::Unsettles => (wgpu::CompareFunction::Always, wgpu::StencilOperation::Zero, SETTLED_BIT),
        };
        let face = wgpu::StencilFaceState { compare, pass_op, ..wgpu::StencilFaceState::IGNORE };
        wgpu::StencilState { front: face, back: face, read_mask: SETTLED_BIT, write_mask: mask }
    }
}

/// Every program and full-screen pipeline made so far.
#[derive(Debug)]
pub struct Shaders {
    frame: FrameLayout,
    made: Cell<u64>,
    programs: RefCell<HashMap<ProgramKey, Arc<Program>>>,
    fullscreen: RefCell<HashMap<FullscreenKey, Arc<FullscreenPipeline>>>,
    depth_clears: RefCell<HashMap<wgpu::TextureFormat, Pipeline>>,
    compile_ms: Cell<f64>,
    makers: Makers,
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
            makers: Makers::default(),
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
    fn compiling<T>(&self, compile: impl FnOnce() -> T) -> T {
        self.made.set(self.made.get() + 1);
        let started = web_time::Instant::now();
        let result = compile();
        self.compile_ms.set(self.compile_ms.get() + started.elapsed().as_secs_f64() * 1e3);
        result
    }

    /// The pipeline that `make` gives, which is counted; it may be made on another thread.
    pub(crate) fn pipeline(&self, make: impl Make) -> Pipeline {
        self.compiling(|| self.makers.promise(make))
    }

    /// Milliseconds in which frames waited for programs and pipelines so far. A driver may do more when it first draws.
    pub fn compile_ms(&self) -> f64 {
        self.compile_ms.get() + self.makers.waited_ms()
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
        super::dump::write(name, axes_on, &source)?;
        let program = Arc::new(self.compiling(|| Program::built_in(&self.frame, name, &source))?);
        self.programs.borrow_mut().insert(key, program.clone());
        Ok(program)
    }

    /// The pipeline that sets depth to 0 where it draws, because no part of a texture can be cleared for itself.
    ///
    /// # Errors
    /// The program does not compile.
    pub fn depth_clear(&self, format: wgpu::TextureFormat) -> Result<Pipeline, ProgramError> {
        if let Some(pipeline) = self.depth_clears.borrow().get(&format) {
            return Ok(pipeline.clone());
        }
        let program = self.program("fullscreen", &[])?;
        let device = self.frame.device.clone();
        let pipeline = self.pipeline(move || make_depth_clear(&device, &program, format));
        self.depth_clears.borrow_mut().insert(format, pipeline.clone());
        Ok(pipeline)
    }

    /// The pipeline that draws the program `name` over a whole target, where depth passes the test.
    ///
    /// # Errors
    /// The program does not compile or does not exist.
    pub fn fullscreen(
        &self,
        name: &'static str,
        axes_on: &[&'static str],
        target: FullscreenTarget,
        constants: &[Constant],
    ) -> Result<Arc<FullscreenPipeline>, ProgramError> {
        let (axes_on, on) = super::compose::axes_and_constants(name, axes_on);
        let constants = &[constants, &on].concat()[..];
        let declared = constants.iter().filter(|(constant, _)| super::compose::has_constant(name, constant));
        let key = ((name, axes_on), target, declared.copied().collect());
        if let Some(pipeline) = self.fullscreen.borrow().get(&key) {
            return Ok(pipeline.clone());
        }
        let program = self.program(name, &key.0.1)?;
        let triangle = self.program("fullscreen", &[])?;
        let (device, constants) = (self.frame.device.clone(), constants.to_vec());
        let made_of = program.clone();
        let make = move || FullscreenPipeline::make(&device, &made_of, &triangle, target, &constants);
        let pipeline = Arc::new(FullscreenPipeline { program, pipeline: self.pipeline(make) });
        self.fullscreen.borrow_mut().insert(key, pipeline.clone());
        Ok(pipeline)
    }
}

fn make_depth_clear(device: &wgpu::Device, program: &Program, format: wgpu::TextureFormat) -> wgpu::RenderPipeline {
    let triangle = program.specialised(&[]);
    let depth_stencil = wgpu::DepthStencilState {
        format,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Always),
        stencil: Default::default(),
        bias: Default::default(),
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("depth_clear"),
        layout: Some(&program.layout),
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
    })
}
