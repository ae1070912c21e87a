//! A simulation on a device: its pipelines, and the buffers of its parameters.

use super::SimulationFile;
use super::file::{ENTRY, FilePass};
use crate::gpu::Gpu;
use crate::shader::locate;
use crate::shader::program::{ProgramError, Slot};
use crate::user_shader::padding;
use crate::user_shader::rounds::Rounds;
use crate::user_shader::uniforms::OWN_GROUP;

/// The format of states.
pub(super) const STATE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// The format of pictures.
pub(super) const PICTURE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The triangle that covers all cells, and the levels of pictures.
const MIPS: &str = include_str!("mips.wgsl");

/// What draws a simulation.
#[derive(Debug)]
pub(super) struct CompiledSimulation {
    pub start: Vec<CompiledPass>,
    pub step: Vec<CompiledPass>,
    pub shows: Vec<CompiledPass>,
    pub mips: Mips,
}

/// A pass on a device.
#[derive(Debug)]
pub(super) struct CompiledPass {
    /// The state or the picture that it writes.
    pub target: String,
    /// How often it is drawn.
    pub rounds: u32,
    pub pipeline: wgpu::RenderPipeline,
    /// What it binds in group 1.
    pub slots: Vec<Slot>,
    pub layout: wgpu::BindGroupLayout,
    /// Its parameters, if it looks at any.
    pub own: Option<wgpu::BindGroup>,
}

/// What draws the levels of pictures.
#[derive(Debug)]
pub(super) struct Mips {
    pub pipeline: wgpu::RenderPipeline,
    pub layout: wgpu::BindGroupLayout,
}

/// The pipelines of a simulation.
///
/// # Errors
/// The device refuses them.
pub(super) fn compiled(gpu: &Gpu, file: SimulationFile) -> Result<CompiledSimulation, ProgramError> {
    let name = file.name().to_owned();
    let SimulationFile { file, mut text, mut module, declared, start, step, shows, uniforms, .. } = file;
    if !gpu.capabilities.uniforms_of_any_size {
        (text, module) = padding::filled_up((&file, &name), (text, &declared), module, &uniforms)?;
    }
    drop(module);
    let buffers: Vec<(String, wgpu::Buffer)> =
        uniforms.blocks.iter().map(|block| (block.name.clone(), padding::buffer(gpu, block))).collect();
    #[cfg(not(target_arch = "wasm32"))]
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let source = |text: String| wgpu::ShaderSource::Wgsl(text.into());
    let descriptor = |label, source| wgpu::ShaderModuleDescriptor { label: Some(label), source };
    let shader = gpu.device.create_shader_module(descriptor(&name, source(locate::composed(&text, &declared))));
    let triangle = gpu.device.create_shader_module(descriptor("mips", source(MIPS.into())));
    let pass = |pass: FilePass, format: wgpu::TextureFormat| {
        let FilePass { pass, mut slots } = pass;
        let mut group = |group: usize| slots.get_mut(group).map(std::mem::take).unwrap_or_default();
        let (frame, own) = (group(1), group(OWN_GROUP as usize));
        let layout = |slots: &[Slot]| {
            let entries: Vec<_> = slots.iter().map(|slot| slot.entry).collect();
            gpu.device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(&name), entries: &entries })
        };
        let (layout, own_layout) = (layout(&frame), layout(&own));
        let entries: Vec<wgpu::BindGroupEntry<'_>> = own
            .iter()
            .filter_map(|slot| {
                let (_, buffer) = buffers.iter().find(|(known, _)| *known == slot.name)?;
                Some(wgpu::BindGroupEntry { binding: slot.entry.binding, resource: buffer.as_entire_binding() })
            })
            .collect();
        let own = (!own.is_empty()).then(|| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(&name),
                layout: &own_layout,
                entries: &entries,
            })
        });
        let layouts = [None, Some(&layout), Some(&own_layout)];
        let entry = format!("{ENTRY}{}", pass.function);
        let count = if own.is_some() { 3 } else { 2 };
        let pipeline =
            pipeline(gpu, (&name, layouts.get(..count).unwrap_or_default()), &triangle, (&shader, &entry), format);
        let rounds = match &pass.rounds {
            Rounds::Count(1) => 1,
            rounds => rounds.count(&name, &uniforms),
        };
        CompiledPass { target: pass.target, rounds, pipeline, slots: frame, layout, own }
    };
    let all = |passes: Vec<FilePass>, format| passes.into_iter().map(|one| pass(one, format)).collect();
    let (start, step, shows) = (all(start, STATE), all(step, STATE), all(shows, PICTURE));
    let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("mips"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: true },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        }],
    });
    let mips = Mips {
        pipeline: pipeline(gpu, ("mips", &[Some(&layout)]), &triangle, (&triangle, "fs_mips"), PICTURE),
        layout,
    };
    #[cfg(not(target_arch = "wasm32"))]
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(ProgramError::Invalid { pass: name.clone(), message: format!("{file}: {error}") });
    }
    #[cfg(target_arch = "wasm32")]
    let _ = file;
    Ok(CompiledSimulation { start, step, shows, mips })
}

fn pipeline(
    gpu: &Gpu,
    (label, layouts): (&str, &[Option<&wgpu::BindGroupLayout>]),
    triangle: &wgpu::ShaderModule,
    (shader, entry): (&wgpu::ShaderModule, &str),
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: layouts,
        ..Default::default()
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: triangle,
            entry_point: Some("vs_mips"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
