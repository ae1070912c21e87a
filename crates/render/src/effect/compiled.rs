//! An effect on a device: its pipelines and uniforms.

use super::EffectStage;
use super::declarations::BorrowedTexture;
use super::steps::Step;
use crate::gbuffer::RADIANCE;
use crate::gpu::Gpu;
use crate::shader::cache::{FullscreenPipeline, FullscreenTarget};
use crate::shader::program::{FrameLayout, Program, ProgramError, Slot};
use crate::shader::{compose, dump};
use crate::user_shader::uniforms::OWN_GROUP;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What draws an effect. A new text of it makes another one.
#[derive(Debug)]
pub(super) struct CompiledEffect {
    /// No other has it.
    pub id: u64,
    pub stage: EffectStage,
    pub passes: Vec<CompiledStep>,
    /// The textures that it reads of other effects, and of the frame where the header alone declares them.
    pub borrowed: Vec<BorrowedTexture>,
    /// The name and buffer of every uniform that the shader uses; the others have none.
    pub uniforms: Vec<(String, Option<wgpu::Buffer>)>,
    /// The tables that the shader reads, by their names in it.
    pub tables: Vec<(String, wgpu::TextureView)>,
    /// How it changes a pixel, if it knows that pixel alone.
    pub pixel: Option<Pixel>,
}

/// How an effect changes a pixel.
#[derive(Debug)]
pub(super) struct Pixel {
    /// The text of its file, as it was compiled.
    pub text: String,
    /// Its function, from a colour and a position to a colour.
    pub function: String,
    /// Whether it finds `drawn` declared.
    pub finds_drawn: bool,
}

/// A pass of an effect on a device.
#[derive(Debug)]
pub(super) struct CompiledStep {
    pub step: Step,
    pub pipeline: Arc<FullscreenPipeline>,
    /// The effect's own uniforms, if the pass uses any.
    pub own_group: Option<wgpu::BindGroup>,
}

impl CompiledEffect {
    /// A number for one more.
    pub fn next_id() -> u64 {
        static NEXT_ID: AtomicU64 = AtomicU64::new(0);
        NEXT_ID.fetch_add(1, Ordering::Relaxed)
    }
}

/// The passes `steps` of the effect `name`, whose whole text is `composed` and was parsed into `module`, with the buffers
/// of its own uniforms by their names. `file` appears in errors.
///
/// # Errors
/// The device refuses them.
pub(super) fn compiled_steps(
    gpu: &Gpu,
    (name, file): (&str, &str),
    (composed, module): (String, &naga::Module),
    steps: Vec<(Step, Vec<Vec<Slot>>)>,
    uniforms: &[(String, Option<wgpu::Buffer>)],
) -> Result<Vec<CompiledStep>, ProgramError> {
    let invalid = |message: String| ProgramError::Invalid { pass: name.into(), message };
    #[cfg(not(target_arch = "wasm32"))]
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let triangle = compose::source("fullscreen", &[]).map_err(&invalid)?;
    let frame = FrameLayout::new(&gpu.device);
    let triangle = Program::new(&frame, "fullscreen", &triangle)?;
    dump::write(&format!("effect.{name}"), &[], &composed)?;
    let composed = wgpu::ShaderSource::Wgsl(composed.into());
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(name), source: composed };
    let compiled = gpu.device.create_shader_module(descriptor);
    let is_only = steps.len() == 1;
    let make = |(step, slots): (Step, Vec<Vec<Slot>>)| {
        let pass = if is_only { name.to_owned() } else { format!("{name}.{}", step.name) };
        let program = Arc::new(Program::of_entry_point(&frame, &pass, &compiled, (module, &step.function), slots)?);
        let target = FullscreenTarget::of(RADIANCE);
        let pipeline = Arc::new(FullscreenPipeline::new(&gpu.device, program, &triangle, target, &[]));
        Ok(CompiledStep { step, pipeline, own_group: None })
    };
    let mut passes = steps.into_iter().map(make).collect::<Result<Vec<_>, ProgramError>>()?;
    #[cfg(not(target_arch = "wasm32"))]
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(invalid(format!("{file}: {error}")));
    }
    #[cfg(target_arch = "wasm32")]
    let _ = file;
    let resources: Vec<_> = uniforms
        .iter()
        .filter_map(|(name, buffer)| Some((name.as_str(), buffer.as_ref()?.as_entire_binding())))
        .collect();
    for CompiledStep { pipeline, own_group, .. } in &mut passes {
        let program = &pipeline.program;
        let bind = || program.bind(&gpu.device, OWN_GROUP, &resources);
        *own_group = program.uses_group(OWN_GROUP).then(bind).transpose()?;
    }
    Ok(passes)
}
