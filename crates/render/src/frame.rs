//! The whole frame, top to bottom, on one page.

use crate::aov::AovPasses;
use crate::draws::DrawList;
use crate::effect::Effect;
use crate::environment::{Background, EnvironmentUniform};
use crate::gbuffer::{Gbuffer, RADIANCE};
use crate::gpu::Gpu;
use crate::passes::present::Target;
use crate::passes::{
    accumulate, background, direct, emission, forward, geometry, ids, indirect, linear_depth, motion, present, tone_map,
};
pub use crate::render_settings::Path;
use crate::resources::SceneResources;
use crate::resources::filtering::Sampling;
use crate::shader::program::{FullscreenPipeline, ProgramError};
use crate::shader::{Program, Shaders};
use crate::surfaces::SurfacePipelines;
use crate::tone_curve::Tonemap;
use manypass_graph::{Graph, Handle, PassContext, Read};
use std::cell::RefCell;
use std::sync::Arc;

/// Adds colour to the target and leaves its alpha, the coverage, alone (the source's alpha is 0).
pub const ADD: wgpu::BlendState = {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState { color: component, alpha: component }
};

/// What all passes of one view share: its draws, lists of lights, environment and uniforms.
#[derive(Debug)]
pub struct Shared<'f> {
    /// The device and what it can do.
    pub gpu: &'f Gpu,
    /// The device.
    pub device: &'f wgpu::Device,
    /// Programs and full-screen pipelines.
    pub shaders: &'f Shaders,
    /// Pipelines that draw surfaces.
    pub surface_pipelines: &'f SurfacePipelines,
    /// The scene on the device.
    pub resources: &'f SceneResources,
    /// What the view draws.
    pub draws: &'f DrawList,
    /// How samplers of textures filter.
    pub sampling: Sampling,
    /// The instances of the draws.
    pub instances: &'f wgpu::Buffer,
    /// Width and height at which the view is shaded.
    pub size: (u32, u32),
    /// The format of depth and stencil.
    pub depth_format: wgpu::TextureFormat,
    /// What is seen behind the surfaces.
    pub background: Background,
    /// The curve from radiance to display colours.
    pub tonemap: Tonemap,
    /// Where shading happens.
    pub path: Path,
    /// The number of lights.
    pub light_count: u32,
    /// The environment.
    pub environment: EnvironmentUniform,
    /// Names of group 0, with what they stand for.
    pub frame_resources: &'f [(&'static str, wgpu::BindingResource<'f>)],
    /// The uniform of `accumulate`.
    pub accumulation: &'f wgpu::Buffer,
    /// The uniform of `tone_map`.
    pub tone_map: &'f wgpu::Buffer,
    /// The uniform of `present`.
    pub present: &'f wgpu::Buffer,
    /// A sampler that does not filter.
    pub nearest_clamp: &'f wgpu::Sampler,
    /// The passes that variables need.
    pub aov_passes: AovPasses,
    /// Whether the picture is shown after this frame, or only added to.
    pub is_shown: bool,
    /// Whether there is a previous pose to compute motion from.
    pub has_previous: bool,
    /// What went wrong while passes were recorded.
    pub errors: &'f RefCell<Vec<ProgramError>>,
}

/// What the shaded view consists of.
#[derive(Debug)]
pub struct ViewOutputs {
    /// Scene-linear radiance, pre-exposed; alpha is coverage.
    pub radiance: Handle,
    /// The G-buffer; none on the forward path.
    pub gbuffer: Option<Gbuffer>,
    /// What surfaces emit, pre-exposed, if a variable needs it.
    pub emission: Option<Handle>,
    /// Nodes and materials, if a variable needs them.
    pub ids: Option<Handle>,
    /// Pixels moved since the previous frame, if a variable needs it.
    pub motion: Option<Handle>,
}

/// Everything from geometry to radiance, for one camera. Mirrors and probes call it again with other cameras.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn view_passes<'f>(graph: &mut Graph<'f>, shared: &'f Shared<'f>) -> Result<ViewOutputs, ProgramError> {
    if shared.path == Path::Forward {
        let (radiance, depth) = forward::record_opaque(graph, shared)?;
        let radiance = background::record(graph, shared, &depth, radiance)?;
        let radiance = forward::record_blended(graph, shared, radiance, &depth)?;
        return Ok(ViewOutputs { radiance, gbuffer: None, emission: None, ids: None, motion: None });
    }
    let (variables, gbuffer, depth) = surface_passes(graph, shared)?;
    let radiance = indirect::record(graph, shared, &gbuffer, &depth, variables.radiance)?;
    let radiance = direct::record(graph, shared, &gbuffer, &depth, radiance)?;
    let radiance = background::record(graph, shared, &depth, radiance)?;
    let radiance = forward::record_blended(graph, shared, radiance, &depth)?;
    Ok(ViewOutputs { radiance, gbuffer: Some(gbuffer), ..variables })
}

/// The variables of the frame in a view of their own, for pictures that are shaded at another size: all that is known of
/// surfaces before light reaches them. The names begin with `aov/`.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn variable_passes<'f>(graph: &mut Graph<'f>, shared: &'f Shared<'f>) -> Result<ViewOutputs, ProgramError> {
    graph.set_view("aov");
    let (variables, gbuffer, _) = surface_passes(graph, shared)?;
    graph.set_view("");
    Ok(ViewOutputs { gbuffer: Some(gbuffer), ..variables })
}

/// The G-buffer and the passes that variables need; `radiance` holds emission so far. Also gives depth.
fn surface_passes<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
) -> Result<(ViewOutputs, Gbuffer, Handle), ProgramError> {
    let geometry = geometry::record(graph, shared)?;
    let linear_depth = linear_depth::record(graph, shared, &geometry.depth)?;
    let gbuffer =
        Gbuffer { base_color: geometry.base_color, normal: geometry.normal, material: geometry.material, linear_depth };
    let wanted = shared.aov_passes;
    let emission = wanted.emission.then(|| emission::record(graph, shared, &geometry.radiance)).transpose()?;
    let ids = wanted.ids.then(|| ids::record(graph, shared, &geometry.depth)).transpose()?;
    let motion = wanted.motion.then(|| motion::record(graph, shared, &geometry.depth)).transpose()?;
    let outputs = ViewOutputs { radiance: geometry.radiance, gbuffer: None, emission, ids, motion };
    Ok((outputs, gbuffer, geometry.depth))
}

/// The user's effects, each on the radiance of the one before.
///
/// # Errors
/// As [`Effect::record`].
pub fn effect_passes<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    effects: &'f [Arc<dyn Effect>],
    mut outputs: ViewOutputs,
) -> Result<ViewOutputs, ProgramError> {
    for effect in effects {
        outputs.radiance = effect.record(graph, shared, outputs.gbuffer.as_ref(), outputs.radiance)?;
    }
    Ok(outputs)
}

/// The means over the samples so far, each with the texture for the next one.
#[derive(Debug)]
pub enum Means {
    /// Of display colours.
    Display(Handle, Handle),
    /// Of radiance.
    Radiance(Handle, Handle),
    /// Of display colours, then of radiance.
    Both([(Handle, Handle); 2]),
}

/// From radiance to the picture: accumulation over the samples of a still, the display transform, and the caller's
/// `target` if there is one.
///
/// # Errors
/// A program that does not compile, or declares what nobody binds.
pub fn output_passes<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    radiance: &Handle,
    means: Means,
    display: Handle,
    target: Option<&Target>,
) -> Result<(), ProgramError> {
    let of_display = ("accumulate", accumulate::Average::Display(shared.tonemap));
    // Beside the other it has a name of its own.
    let of_radiance = |name| (name, accumulate::Average::Radiance);
    let (mean, curve) = match means {
        Means::Display(previous, next) => {
            (accumulate::record(graph, shared, of_display, radiance, &previous, next)?, Tonemap::None)
        }
        Means::Radiance(previous, next) => {
            (accumulate::record(graph, shared, of_radiance("accumulate"), radiance, &previous, next)?, shared.tonemap)
        }
        Means::Both([(previous, next), (previous_radiance, next_radiance)]) => {
            let name = of_radiance("accumulate.radiance");
            let linear = accumulate::record(graph, shared, name, radiance, &previous_radiance, next_radiance)?;
            graph.export(linear);
            (accumulate::record(graph, shared, of_display, radiance, &previous, next)?, Tonemap::None)
        }
    };
    let display = tone_map::record(graph, shared, curve, &mean, display)?;
    graph.export(mean);
    if let Some(target) = target {
        present::record(graph, shared, &display, target)?;
    }
    // Otherwise the passes that make it are culled.
    if shared.is_shown {
        graph.export(display);
    }
    Ok(())
}

/// A part of the picture, told by depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PicturePart {
    /// Where there is an opaque or masked surface.
    Surfaces,
    /// Where there is none.
    Background,
}

/// A full-screen pass: its pipeline, and the bind group of the frame.
#[derive(Debug)]
pub struct FullscreenStep<'f> {
    pipeline: Arc<FullscreenPipeline>,
    frame: Option<wgpu::BindGroup>,
    own: Option<&'f wgpu::BindGroup>,
    errors: &'f RefCell<Vec<ProgramError>>,
}

impl<'f> Shared<'f> {
    /// Group 0 of a program.
    ///
    /// # Errors
    /// The program declares what nobody binds.
    pub fn frame_bind_group(&self, program: &Program) -> Result<wgpu::BindGroup, ProgramError> {
        program.bind(self.device, 0, self.frame_resources)
    }

    /// The full-screen pass of the program `name`.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    pub fn fullscreen(
        &self,
        name: &'static str,
        axes_on: &[&'static str],
        format: wgpu::TextureFormat,
        blend: Option<wgpu::BlendState>,
    ) -> Result<FullscreenStep<'f>, ProgramError> {
        let pipeline = self.shaders.fullscreen(name, axes_on, format, blend, None)?;
        self.own_fullscreen(&pipeline, None)
    }

    /// The full-screen pass of the program `name` over the pixels of radiance that `part` means. The pass attaches
    /// depth, read-only. Pixels of the other part cost nothing, and would be changed by nothing.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    pub fn fullscreen_over(
        &self,
        part: PicturePart,
        name: &'static str,
        blend: Option<wgpu::BlendState>,
    ) -> Result<FullscreenStep<'f>, ProgramError> {
        // Depth is reversed and cleared to 0, where the triangle lies.
        let compare = match part {
            PicturePart::Surfaces => wgpu::CompareFunction::Less,
            PicturePart::Background => wgpu::CompareFunction::GreaterEqual,
        };
        let depth = Some((self.depth_format, compare));
        let pipeline = self.shaders.fullscreen(name, &[], RADIANCE, blend, depth)?;
        self.own_fullscreen(&pipeline, None)
    }

    /// The full-screen pass of a pipeline from elsewhere, with a bind group of its own as group 2.
    ///
    /// # Errors
    /// The program declares in group 0 what nobody binds.
    pub fn own_fullscreen(
        &self,
        pipeline: &Arc<FullscreenPipeline>,
        own: Option<&'f wgpu::BindGroup>,
    ) -> Result<FullscreenStep<'f>, ProgramError> {
        let program = &pipeline.program;
        let frame = if program.uses_group(0) { Some(self.frame_bind_group(program)?) } else { None };
        Ok(FullscreenStep { pipeline: pipeline.clone(), frame, own, errors: self.errors })
    }
}

impl FullscreenStep<'_> {
    /// Draws the triangle; group 1 is found by name among what the pass reads and what else it gives.
    pub fn draw(
        &self,
        context: &mut PassContext<'_, '_>,
        reads: &[(&'static str, Read)],
        others: &[(&'static str, wgpu::BindingResource<'_>)],
    ) {
        let program = &self.pipeline.program;
        let group = if program.uses_group(1) {
            let resources: Vec<_> = reads
                .iter()
                .map(|(name, read)| (*name, wgpu::BindingResource::TextureView(context.view(*read))))
                .chain(others.iter().cloned())
                .collect();
            match program.bind(context.device, 1, &resources) {
                Ok(group) => Some(group),
                Err(error) => return self.errors.borrow_mut().push(error),
            }
        } else {
            None
        };
        context.render_pass.set_pipeline(&self.pipeline.pipeline);
        if let Some(frame) = &self.frame {
            context.render_pass.set_bind_group(0, frame, &[]);
        }
        if let Some(group) = &group {
            context.render_pass.set_bind_group(1, group, &[]);
        }
        if let Some(own) = self.own {
            context.render_pass.set_bind_group(2, own, &[]);
        }
        context.render_pass.draw(0..3, 0..1);
    }
}
