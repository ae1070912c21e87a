//! Effects: passes of the user's own between shading and accumulation, most of them one WGSL file.

use crate::frame::Shared;
use crate::gbuffer::{Gbuffer, RADIANCE};
use crate::gpu::Gpu;
use crate::shader::compose;
use crate::shader::program::{self, FullscreenPipeline, Program, ProgramError, Slot};
use manypass_graph::{ColorLoad, Graph, Handle, TextureDesc};
use std::fmt::Debug;
use std::sync::Arc;

/// A pass, or several, that make new radiance of a view's radiance: after its surfaces, before accumulation and the
/// tone curve. [`crate::FrameRequest::effects`] lists them in their order.
///
/// [`WgslEffect`] is the one for a single full-screen shader. Implement this trait for anything else: a blur of two
/// passes, a pass with textures of its own.
pub trait Effect: Debug + wgpu::WasmNotSendSync {
    /// Records the passes and returns what holds the new radiance: the format of `radiance`, pre-exposed, with coverage in
    /// alpha. `gbuffer` is none on the forward path.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    fn record<'f>(
        &'f self,
        graph: &mut Graph<'f>,
        shared: &'f Shared<'f>,
        gbuffer: Option<&Gbuffer>,
        radiance: Handle,
    ) -> Result<Handle, ProgramError>;
}

/// An effect of one full-screen fragment shader, which returns the new radiance of its pixel.
///
/// The shader finds this declared, beside what WGSL has (all of it is [`compose::EFFECT_PRELUDE`]):
/// - textures of the frame's size: `radiance`, `base_color`, `normal`, `material`, `linear_depth`; samplers
///   `linear_clamp` and `nearest_clamp`; the uniform `view`;
/// - `radiance_at(pixel)`, `distance_at(pixel)` in metres (`DISTANCE_BACKGROUND_M` and more: nothing is there), and
///   `surface_at(pixel)` with `normal_world`, `base_color`, `metallic`, `roughness_perceptual`, `occlusion`;
/// - `position_world_from_pixel(position.xy, distance_m)` and its like.
///
/// Its own uniforms lie in group 2 and are set by their names.
///
/// ```no_run
/// # use manypass::{FrameRequest, Gpu, Renderer, WgslEffect, scene};
/// let scene = scene::demo::hall();
/// let mut renderer = Renderer::new(Gpu::headless(None)?)?;
/// renderer.load(&scene)?;
/// let vignette = WgslEffect::new(
///     renderer.gpu(),
///     "vignette.wgsl",
///     "@group(2) @binding(0) var<uniform> strength: f32;
///
///      @fragment
///      fn fs_vignette(@builtin(position) position: vec4f) -> @location(0) vec4f {
///          let from_middle = uv_from_pixel(position.xy) - 0.5;
///          let here = radiance_at(vec2i(position.xy));
///          return vec4f(here.rgb * (1.0 - strength * dot(from_middle, from_middle)), here.a);
///      }",
/// )?;
/// vignette.set_uniform("strength", &1.5f32.to_le_bytes())?;
/// let mut request = FrameRequest::of_scene(&scene, 640, 360);
/// request.effects.push(std::sync::Arc::new(vignette));
/// renderer.render(&scene, &request)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct WgslEffect {
    gpu: Gpu,
    pipeline: Arc<FullscreenPipeline>,
    uniforms: Vec<(String, wgpu::Buffer)>,
    own_group: Option<wgpu::BindGroup>,
}

/// The group of an effect's own uniforms.
const OWN_GROUP: u32 = 2;

impl WgslEffect {
    /// Compiles `source`. `file` appears in errors; its name without the ending is the name of the pass. Uniforms are
    /// zero until they are set.
    ///
    /// # Errors
    /// The source is not WGSL, or not one fragment shader that fits the frame; the message says where and why.
    pub fn new(gpu: &Gpu, file: &str, source: &str) -> Result<Self, ProgramError> {
        let name = std::path::Path::new(file).file_stem().map_or(file.into(), |stem| stem.to_string_lossy());
        let invalid = |message: String| ProgramError::Invalid { pass: name.to_string(), message };
        let composed = format!("{source}\n{}", compose::EFFECT_PRELUDE);
        let (module, info) = program::parse(&name, file, &composed)?;
        let slots = program::reflect_bindings(&module, &info, &composed);
        let own_lines = source.lines().count() as u32;
        check_module(&module, &composed).map_err(|message| invalid(format!("{file}:{message}")))?;
        check_slots(&slots, own_lines).map_err(|message| invalid(format!("{file}:{message}")))?;
        // What the checks above do not foresee is the device's to find.
        #[cfg(not(target_arch = "wasm32"))]
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let triangle = compose::source("fullscreen", &[]).map_err(&invalid)?;
        let triangle = Program::new(&gpu.device, "fullscreen", triangle)?;
        let program = Arc::new(Program::from_parsed(&gpu.device, &name, &composed, &module, slots));
        let pipeline = FullscreenPipeline::new(&gpu.device, program.clone(), &triangle, RADIANCE, None, None);
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(invalid(format!("{file}: {error}")));
        }
        let uniforms: Vec<_> =
            program.slots(OWN_GROUP).iter().map(|slot| (slot.name.clone(), buffer(gpu, slot))).collect();
        let resources: Vec<_> =
            uniforms.iter().map(|(name, buffer)| (name.as_str(), buffer.as_entire_binding())).collect();
        let own_group =
            program.uses_group(OWN_GROUP).then(|| program.bind(&gpu.device, OWN_GROUP, &resources)).transpose()?;
        Ok(Self { gpu: gpu.clone(), pipeline: Arc::new(pipeline), uniforms, own_group })
    }

    /// The name of the pass: in plans, timers and reports.
    pub fn name(&self) -> &str {
        &self.pipeline.program.name
    }

    /// Sets the uniform `name` from the next frame on: its bytes as WGSL lays them out.
    ///
    /// # Errors
    /// The shader uses no such uniform, or it has another size.
    pub fn set_uniform(&self, name: &str, bytes: &[u8]) -> Result<(), ProgramError> {
        let fault = |message: String| ProgramError::Uniform { pass: self.name().into(), uniform: name.into(), message };
        let (_, buffer) = self.uniforms.iter().find(|(known, _)| known == name).ok_or_else(|| {
            let known: Vec<_> = self.uniforms.iter().map(|(name, _)| name.as_str()).collect();
            fault(format!("the shader uses no such uniform in group 2; it uses: {}", known.join(", ")))
        })?;
        if buffer.size() != bytes.len() as u64 {
            return Err(fault(format!("it has {} bytes, not {}", buffer.size(), bytes.len())));
        }
        self.gpu.queue.write_buffer(buffer, 0, bytes);
        Ok(())
    }
}

impl Effect for WgslEffect {
    fn record<'f>(
        &'f self,
        graph: &mut Graph<'f>,
        shared: &'f Shared<'f>,
        gbuffer: Option<&Gbuffer>,
        radiance: Handle,
    ) -> Result<Handle, ProgramError> {
        if !shared.gpu.is_same(&self.gpu) {
            let message = "it was compiled for another device than that of `Renderer::gpu`".into();
            return Err(ProgramError::Invalid { pass: self.name().into(), message });
        }
        let step = shared.own_fullscreen(&self.pipeline, self.own_group.as_ref())?;
        let offered = textures(gbuffer, &radiance);
        let TextureDesc { width, height, .. } = radiance.desc();
        let target = graph.texture(format!("{}.radiance", self.name()), TextureDesc::new_2d(width, height, RADIANCE));
        let mut pass = graph.pass(self.name().to_owned());
        let mut reads = Vec::new();
        for slot in self.pipeline.program.slots(1) {
            match offered.iter().find(|(name, _)| *name == slot.name) {
                Some((name, handle)) => reads.push((*name, pass.read(handle))),
                None if slot.name.ends_with("_clamp") => {}
                None => {
                    let known: Vec<_> = offered.iter().map(|(name, _)| *name).collect();
                    let message = format!(
                        "it reads `{}`, which this path does not have; there is: {}",
                        slot.name,
                        known.join(", ")
                    );
                    return Err(ProgramError::Invalid { pass: self.name().into(), message });
                }
            }
        }
        let output = pass.color(target, ColorLoad::Discard);
        pass.draw(move |context| {
            let linear = shared.frame_resources.iter().find(|(name, _)| *name == "linear_clamp").cloned();
            let nearest = ("nearest_clamp", wgpu::BindingResource::Sampler(shared.nearest_clamp));
            let samplers: Vec<_> = linear.into_iter().chain([nearest]).collect();
            step.draw(context, &reads, &samplers);
        });
        Ok(output)
    }
}

/// The textures that an effect may read, by their names.
fn textures<'h>(gbuffer: Option<&'h Gbuffer>, radiance: &'h Handle) -> Vec<(&'static str, &'h Handle)> {
    let mut offered = vec![("radiance", radiance)];
    if let Some(gbuffer) = gbuffer {
        offered.extend([
            ("base_color", &gbuffer.base_color),
            ("normal", &gbuffer.normal),
            ("material", &gbuffer.material),
            ("linear_depth", &gbuffer.linear_depth),
        ]);
    }
    offered
}

fn buffer(gpu: &Gpu, slot: &Slot) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&slot.name),
        size: u64::from(slot.size_bytes),
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Whether the module is one fragment shader from a position to a colour; else the line, and why not.
fn check_module(module: &naga::Module, source: &str) -> Result<(), String> {
    use naga::{AddressSpace, Binding, BuiltIn};
    let [entry] = module.entry_points.as_slice() else {
        return Err(format!(
            "1: an effect has one entry point, a `@fragment` function, not {}",
            module.entry_points.len()
        ));
    };
    if entry.stage != naga::ShaderStage::Fragment {
        return Err(format!("1: the entry point `{}` is not a `@fragment` function", entry.name));
    }
    let is_position = |argument: &naga::FunctionArgument| {
        matches!(argument.binding, Some(Binding::BuiltIn(BuiltIn::Position { .. })))
    };
    if !entry.function.arguments.iter().all(is_position) {
        return Err(format!("1: `{}` takes nothing but `@builtin(position) position: vec4f`", entry.name));
    }
    let vec4f = naga::TypeInner::Vector { size: naga::VectorSize::Quad, scalar: naga::Scalar::F32 };
    let is_color = entry.function.result.as_ref().is_some_and(|result| {
        matches!(result.binding, Some(Binding::Location { location: 0, .. })) && module.types[result.ty].inner == vec4f
    });
    if !is_color {
        return Err(format!("1: `{}` returns `@location(0) vec4f`, the new radiance and coverage", entry.name));
    }
    if module.overrides.iter().any(|(_, constant)| constant.init.is_none()) {
        return Err("1: nobody gives a value to an `override` without one; use a uniform".into());
    }
    for (handle, global) in module.global_variables.iter() {
        let is_good = matches!(global.space, AddressSpace::Private | AddressSpace::Uniform | AddressSpace::Handle);
        if !is_good {
            let line = module.global_variables.get_span(handle).location(source).line_number;
            let name = global.name.as_deref().unwrap_or_default();
            return Err(format!("{line}: `{name}` is neither a uniform nor a texture nor a sampler"));
        }
    }
    Ok(())
}

/// Whether what the shader itself declares are uniforms in group 2, and filtering is used where formats allow it; else the
/// line, and why not. Declarations after `own_lines` are the prelude's.
fn check_slots(groups: &[Vec<Slot>], own_lines: u32) -> Result<(), String> {
    for (group, slots) in groups.iter().enumerate() {
        for slot in slots {
            let Slot { name, line, .. } = slot;
            let is_uniform = matches!(slot.entry.ty, wgpu::BindingType::Buffer { .. });
            let is_own = *line <= own_lines;
            if is_own && !(is_uniform && group == OWN_GROUP as usize) {
                return Err(format!(
                    "{line}: `{name}` in group {group}: an effect's own bindings are uniforms in group 2; textures and \
                     samplers of the frame are declared already"
                ));
            }
            let is_filtered = matches!(
                slot.entry.ty,
                wgpu::BindingType::Texture { sample_type: wgpu::TextureSampleType::Float { filterable: true }, .. }
            );
            if is_filtered && name == "linear_depth" {
                return Err("1: `linear_depth` cannot be filtered; use `distance_at(pixel)` or `nearest_clamp`".into());
            }
        }
    }
    Ok(())
}
