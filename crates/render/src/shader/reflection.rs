//! What a module declares: its bindings by group, and the inputs of its vertices.

use super::program::{ProgramError, Slot};
use naga::front::wgsl;
use naga::valid::{Capabilities, GlobalUse, ValidationFlags, Validator};
use std::ops::Range;

/// Parses and validates a built-in module.
pub(super) fn parse(pass: &str, source: &str) -> Result<(naga::Module, naga::valid::ModuleInfo), ProgramError> {
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
    entries: &Range<usize>,
    global: naga::Handle<naga::GlobalVariable>,
) -> wgpu::ShaderStages {
    let mut stages = wgpu::ShaderStages::empty();
    for (index, entry) in module.entry_points.iter().enumerate().filter(|(index, _)| entries.contains(index)) {
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
fn filtered_textures(
    module: &naga::Module,
    info: &naga::valid::ModuleInfo,
    entries: &Range<usize>,
) -> Vec<naga::Handle<naga::GlobalVariable>> {
    let mut filtered = Vec::new();
    for index in entries.clone() {
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
pub(super) fn reflect_bindings(module: &naga::Module, info: &naga::valid::ModuleInfo, source: &str) -> Vec<Vec<Slot>> {
    reflect_bindings_of(module, info, source, 0..module.entry_points.len())
}

/// As [`reflect_bindings`], of some of its entry points.
pub(crate) fn reflect_bindings_of(
    module: &naga::Module,
    info: &naga::valid::ModuleInfo,
    source: &str,
    entries: Range<usize>,
) -> Vec<Vec<Slot>> {
    let filtered = filtered_textures(module, info, &entries);
    let mut groups: Vec<Vec<Slot>> = Vec::new();
    for (handle, global) in module.global_variables.iter() {
        let Some(binding) = global.binding else { continue };
        let visibility = stages_of(info, module, &entries, handle);
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

pub(super) fn reflect_inputs(module: &naga::Module) -> Vec<(String, u32)> {
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
