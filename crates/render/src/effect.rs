//! Effects: passes of the user's own between shading and accumulation, most of them one WGSL file.

mod file;
mod header;
mod library;
mod padding;
mod scan;
mod steps;
mod uniforms;

pub use file::EffectFile;

use crate::gbuffer::{Gbuffer, RADIANCE};
use crate::gpu::Gpu;
use crate::record::Recorder;
use crate::settings::{SettingInfo, SettingValue, Settings, SettingsError, Written};
use crate::shader::cache::{FullscreenPipeline, FullscreenTarget};
use crate::shader::program::{FrameLayout, Program, ProgramError, Slot};
use crate::shader::{compose, locate};
use header::DISPLAY;
use manypass_graph::{ColorLoad, Handle, TextureDesc};
use std::collections::HashMap;
use std::fmt::Debug;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use steps::{Rounds, STEPS_MAX, Step};
use uniforms::{Block, OWN_GROUP, Uniforms};

/// What an effect makes new, and so where in a frame it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EffectStage {
    /// Radiance, of every sample: after the surfaces, before the tone curve.
    #[default]
    Radiance,
    /// Display colours, of the mean of all samples: after the tone curve and over the background, before they become
    /// 8 bits. Linear files, which hold radiance, know nothing of it.
    Display,
}

/// A pass, or several, that make new radiance of a view's radiance, or new display colours.
/// [`crate::FrameRequest::effects`] lists them in their order; those of one stage follow each other.
///
/// [`WgslEffect`] is the one of full-screen shaders in one file. Implement this trait for anything else, such as passes
/// with buffers of their own.
pub trait Effect: Debug + wgpu::WasmNotSendSync {
    /// Records the passes and returns what holds the new radiance: the format of `radiance`, pre-exposed, with coverage
    /// in alpha. `gbuffer` is none on the forward path. At [`EffectStage::Display`] it is given display colours, linear
    /// and multiplied by alpha, and no `gbuffer`.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    fn record<'f>(
        &'f self,
        r: &mut Recorder<'_, 'f>,
        gbuffer: Option<&Gbuffer>,
        radiance: Handle,
    ) -> Result<Handle, ProgramError>;

    /// What it makes new.
    fn stage(&self) -> EffectStage {
        EffectStage::Radiance
    }

    /// Whether it draws anything in the next frame; where it does not, the frame is as if it were not listed.
    fn is_on(&self) -> bool {
        true
    }
}

/// An effect of full-screen fragment shaders in one file, whose last one returns the new radiance, or display colour, of
/// its pixel.
///
/// The shader finds this declared, beside what WGSL has (all of it is [`compose::EFFECT_PRELUDE`]):
/// - textures of the frame's size: `radiance`, `base_color`, `normal`, `material`, `linear_depth`, and `previous`, what
///   the effect itself made in the frame before; samplers `linear_clamp` and `nearest_clamp`; the uniform `view`;
/// - `radiance_at(pixel)`, `distance_at(pixel)` in metres (`DISTANCE_BACKGROUND_M` and more: nothing is there), and
///   `surface_at(pixel)` with `normal_world`, `base_color`, `metallic`, `roughness_perceptual`, `occlusion`;
/// - `position_world_from_pixel(position.xy, distance_m)` and its like.
///
/// Its own uniforms lie in group 2. Their members are settings, whose defaults and ranges stand in comments above them;
/// the page `docs/effects.md` has the whole form of the file.
///
/// ```no_run
/// # use manypass::{FrameRequest, Gpu, Renderer, WgslEffect, scene};
/// let scene = scene::demo::hall();
/// let mut renderer = Renderer::new(Gpu::headless(None)?)?;
/// renderer.load(&scene)?;
/// let vignette = WgslEffect::new(
///     renderer.gpu(),
///     "vignette.wgsl",
///     "/// How much light the corners lose, share
///      // = 0.5 in 0..1
///      @group(2) @binding(0) var<uniform> strength: f32;
///
///      @fragment
///      fn fs_vignette(@builtin(position) position: vec4f) -> @location(0) vec4f {
///          let from_middle = uv_from_pixel(position.xy) - 0.5;
///          let here = radiance_at(vec2i(position.xy));
///          return vec4f(here.rgb * (1.0 - strength * 2.0 * dot(from_middle, from_middle)), here.a);
///      }",
/// )?;
/// vignette.set("vignette.strength", "0.8")?;
/// let mut request = FrameRequest::of_scene(&scene, 640, 360);
/// request.effects.push(std::sync::Arc::new(vignette));
/// renderer.render(&scene, &request)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct WgslEffect {
    gpu: Gpu,
    name: String,
    stage: EffectStage,
    passes: Vec<CompiledStep>,
    /// The same as those of `uniforms`, which keeps their values.
    settings: Vec<SettingInfo>,
    uniforms: Mutex<Uniforms>,
    /// A buffer for every block of `uniforms`; none if the shader does not use it.
    buffers: Vec<Option<wgpu::Buffer>>,
}

/// A pass of an effect on a device.
#[derive(Debug)]
struct CompiledStep {
    step: Step,
    pipeline: Arc<FullscreenPipeline>,
    /// The effect's own uniforms, if the pass uses any.
    own_group: Option<wgpu::BindGroup>,
}

/// The uniform of `steps.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct DrawnUniform {
    /// Width and height of what the pass draws into.
    size_px: [f32; 2],
    /// 1 / the same.
    inverse_size_px: [f32; 2],
    /// How often the pass was drawn before in this frame.
    round: u32,
    /// How often it is drawn in all.
    rounds: u32,
    /// Zero.
    padding: [f32; 2],
}

impl WgslEffect {
    /// Compiles `source`. `file` appears in errors; its name without the ending is the name of the pass where the
    /// header gives none. Settings have their defaults until they are set.
    ///
    /// # Errors
    /// As [`EffectFile::parse`] and [`Self::compile`].
    pub fn new(gpu: &Gpu, file: &str, source: &str) -> Result<Self, ProgramError> {
        Self::compile(gpu, EffectFile::parse(file, source)?)
    }

    /// Compiles an effect for a device; its settings keep the values that they have.
    ///
    /// # Errors
    /// The device refuses what [`EffectFile::parse`] does not foresee.
    pub fn compile(gpu: &Gpu, effect: EffectFile) -> Result<Self, ProgramError> {
        let EffectFile { file, mut text, name, mut module, further, steps, stage, uniforms } = effect;
        let invalid = |message: String| ProgramError::Invalid { pass: name.clone(), message };
        if !gpu.capabilities.uniforms_of_any_size {
            (text, module) = padding::filled_up((&file, &name), (text, &further), module, &uniforms)?;
        }
        #[cfg(not(target_arch = "wasm32"))]
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let triangle = compose::source("fullscreen", &[]).map_err(&invalid)?;
        let frame = FrameLayout::new(&gpu.device);
        let triangle = Program::new(&frame, "fullscreen", triangle)?;
        let composed = wgpu::ShaderSource::Wgsl(locate::composed(&text, &further).into());
        let descriptor = wgpu::ShaderModuleDescriptor { label: Some(&name), source: composed };
        let compiled = gpu.device.create_shader_module(descriptor);
        let is_only = steps.len() == 1;
        let make = |(step, slots): (Step, Vec<Vec<Slot>>)| {
            let pass = if is_only { name.clone() } else { format!("{name}.{}", step.name) };
            let program =
                Arc::new(Program::of_entry_point(&frame, &pass, &compiled, (&module, &step.function), slots)?);
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
        let buffers: Vec<_> = uniforms.blocks.iter().map(|block| block.is_used.then(|| buffer(gpu, block))).collect();
        let named = uniforms.blocks.iter().zip(&buffers);
        let resources: Vec<_> = named
            .filter_map(|(block, buffer)| Some((block.name.as_str(), buffer.as_ref()?.as_entire_binding())))
            .collect();
        for CompiledStep { pipeline, own_group, .. } in &mut passes {
            let program = &pipeline.program;
            let bind = || program.bind(&gpu.device, OWN_GROUP, &resources);
            *own_group = program.uses_group(OWN_GROUP).then(bind).transpose()?;
        }
        let settings = uniforms.settings.clone();
        let uniforms = Mutex::new(uniforms);
        Ok(Self { gpu: gpu.clone(), name, stage, passes, settings, uniforms, buffers })
    }

    /// The name: in reports and the keys of its settings; in plans and timers that of its only pass, or what the names of
    /// several begin with.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The members of its uniforms that text can give, in the order of their declaration; then whether it is drawn.
    pub fn settings(&self) -> &[SettingInfo] {
        &self.settings
    }

    /// The present values of all settings, by their keys.
    pub fn values(&self) -> Vec<(String, SettingValue)> {
        self.uniforms().values()
    }

    /// Sets `key`, `EFFECT.MEMBER` or `EFFECT.UNIFORM.MEMBER`, from the next frame on: one number, or the components of
    /// a vector with commas between; `EFFECT.enabled` to `false` leaves the effect out.
    ///
    /// # Errors
    /// An unknown key, another number of numbers, or one outside the range.
    pub fn set(&self, key: &str, value: &str) -> Result<(), SettingsError> {
        let mut uniforms = self.uniforms();
        if let Some(block) = uniforms.set(self.name(), key, &value.into())? {
            self.upload(&uniforms, block);
        }
        Ok(())
    }

    /// Sets the whole uniform `name` from the next frame on: its bytes as WGSL lays them out. Ranges do not count.
    ///
    /// # Errors
    /// The shader uses no such uniform, or it has another size.
    pub fn set_uniform(&self, name: &str, bytes: &[u8]) -> Result<(), ProgramError> {
        let fault = |message: String| ProgramError::Uniform { pass: self.name().into(), uniform: name.into(), message };
        let mut uniforms = self.uniforms();
        let used = || uniforms.blocks.iter().enumerate().filter(|(_, block)| block.is_used);
        let found = used().find(|(_, block)| block.name == name).map(|(index, block)| (index, block.bytes.len()));
        let (block, size) = found.ok_or_else(|| {
            let known: Vec<_> = used().map(|(_, block)| block.name.as_str()).collect();
            fault(format!("the shader uses no such uniform in group 2; it uses: {}", known.join(", ")))
        })?;
        if size != bytes.len() {
            return Err(fault(format!("it has {size} bytes, not {}", bytes.len())));
        }
        uniforms.set_block(block, bytes);
        self.upload(&uniforms, block);
        Ok(())
    }

    fn uniforms(&self) -> MutexGuard<'_, Uniforms> {
        // Nothing panics while it is held; if it did, the bytes would still be whole numbers.
        self.uniforms.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn upload(&self, uniforms: &Uniforms, block: usize) {
        if let (Some(Some(buffer)), Some(block)) = (self.buffers.get(block), uniforms.blocks.get(block)) {
            self.gpu.queue.write_buffer(buffer, 0, &block.bytes);
        }
    }
}

/// Sets `key` to what was written among the settings of `effects` and those of the frame. Keys of effects come first,
/// so that a setting which a later version adds takes nothing from a file that works today.
///
/// # Errors
/// A key that nobody has, or a value that it does not take.
pub fn set(
    settings: &mut Settings,
    effects: &mut [EffectFile],
    key: &str,
    written: &Written,
) -> Result<(), SettingsError> {
    if let Some(effect) = effects.iter_mut().find(|effect| effect.has(key)) {
        return effect.give(key, written);
    }
    let result = settings.give(key, written);
    if !matches!(result, Err(SettingsError::UnknownKey { .. })) {
        return result;
    }
    let own = effects.iter().flat_map(EffectFile::settings);
    Err(crate::setting::unknown_key(key, own.chain(Settings::declared()).map(|info| &*info.key)))
}

impl Effect for WgslEffect {
    fn record<'f>(
        &'f self,
        r: &mut Recorder<'_, 'f>,
        gbuffer: Option<&Gbuffer>,
        radiance: Handle,
    ) -> Result<Handle, ProgramError> {
        if !r.frame.gpu.is_same(&self.gpu) {
            let message = "it was compiled for another device than that of `Renderer::gpu`".into();
            return Err(ProgramError::Misplaced { pass: self.name().into(), message });
        }
        if let Some((_, missing)) = self.uniforms().missing() {
            return Err(Box::new(missing.clone()).into());
        }
        let TextureDesc { width, height, .. } = radiance.desc();
        let desc = TextureDesc::new_2d(width, height, RADIANCE);
        let keeps =
            self.passes.iter().any(|pass| pass.pipeline.program.slots(1).iter().any(|slot| slot.name == "previous"));
        let (previous, result) = if keeps {
            let history = r.history(self.name.clone(), desc);
            let is_first = history.is_first || self.stage == EffectStage::Display && !r.view.display_goes_on;
            ((!is_first).then_some(history.previous), history.next)
        } else {
            let kind = if self.stage == EffectStage::Display { DISPLAY } else { "radiance" };
            (None, r.texture_of(format!("{}.{kind}", self.name), desc))
        };
        let Some((last, others)) = self.passes.split_last() else { return Ok(radiance) };
        let mut offered =
            Offered { of_frame: textures(self.stage, gbuffer, &radiance, previous.as_ref()), own: HashMap::new() };
        // How often each function was drawn, because no two passes of a frame have one name.
        let mut drawn: HashMap<&str, u32> = HashMap::new();
        for pass in others {
            // All but the last pass write a texture.
            let texture = pass.step.texture.as_deref().unwrap_or_default();
            let side = |of: u32| of.div_ceil(pass.step.divisor);
            let desc = TextureDesc::new_2d(side(width), side(height), RADIANCE);
            let rounds = self.rounds(&pass.step);
            for round in 0..rounds {
                let target = r.texture_of(format!("{}.{texture}", self.name), desc);
                let count = drawn.entry(&pass.step.name).or_default();
                *count += 1;
                let written = self.draw(r, pass, &offered, (*count, round, rounds), target)?;
                offered.own.insert(texture.to_owned(), written);
            }
        }
        let count = drawn.get(&*last.step.name).copied().unwrap_or_default() + 1;
        self.draw(r, last, &offered, (count, 0, 1), result)
    }

    fn stage(&self) -> EffectStage {
        self.stage
    }

    fn is_on(&self) -> bool {
        !self.uniforms().is_off
    }
}

impl WgslEffect {
    /// How often a pass is drawn.
    fn rounds(&self, step: &Step) -> u32 {
        let count = match &step.rounds {
            Rounds::Count(count) => Some(*count),
            Rounds::Setting(setting) => self.uniforms().count(&self.name, &format!("{}.{setting}", self.name)),
        };
        // A whole uniform that was set by its bytes has passed no range.
        count.unwrap_or(1).clamp(1, STEPS_MAX as u32)
    }

    /// Records one round of a pass, whose function is drawn for the `count`th time.
    fn draw<'f>(
        &'f self,
        r: &mut Recorder<'_, 'f>,
        pass: &'f CompiledStep,
        offered: &Offered<'_>,
        (count, round, rounds): (u32, u32, u32),
        target: Handle,
    ) -> Result<Handle, ProgramError> {
        let CompiledStep { pipeline, own_group, .. } = pass;
        let name = &pipeline.program.name;
        let name = if count == 1 { name.clone() } else { format!("{name}.{count}") };
        let TextureDesc { width, height, .. } = target.desc();
        let size_px = [width as f32, height as f32];
        let inverse_size_px = size_px.map(f32::recip);
        let drawn = DrawnUniform { size_px, inverse_size_px, round, rounds, padding: [0.0; 2] };
        let mut step = r.own_fullscreen(name, pipeline.clone(), own_group.clone());
        for slot in pipeline.program.slots(1) {
            match offered.get(&slot.name) {
                Some(handle) => step = step.read(slot.name.clone(), handle),
                None if slot.name == "drawn" => step = step.uniform("drawn", &drawn),
                None if slot.name.ends_with("_clamp") => {}
                None => {
                    let known: Vec<_> = offered.of_frame.iter().map(|(name, _)| *name).collect();
                    let message = format!(
                        "it reads `{}`, which this path does not have; there is: {}",
                        slot.name,
                        known.join(", ")
                    );
                    return Err(ProgramError::Misplaced { pass: self.name.clone(), message });
                }
            }
        }
        step.draw_into(target, ColorLoad::Discard)
    }
}

/// The textures that a pass of an effect may read, by their names.
struct Offered<'h> {
    of_frame: Vec<(&'static str, &'h Handle)>,
    /// What its passes wrote so far.
    own: HashMap<String, Handle>,
}

impl Offered<'_> {
    fn get(&self, name: &str) -> Option<&Handle> {
        let of_frame = || self.of_frame.iter().find(|(known, _)| *known == name).map(|(_, handle)| *handle);
        self.own.get(name).or_else(of_frame)
    }
}

/// The textures of the frame that an effect may read.
fn textures<'h>(
    stage: EffectStage,
    gbuffer: Option<&'h Gbuffer>,
    radiance: &'h Handle,
    previous: Option<&'h Handle>,
) -> Vec<(&'static str, &'h Handle)> {
    let previous = ("previous", previous.unwrap_or(radiance));
    if stage == EffectStage::Display {
        return vec![(DISPLAY, radiance), previous];
    }
    let mut offered = vec![("radiance", radiance), previous];
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

fn buffer(gpu: &Gpu, block: &Block) -> wgpu::Buffer {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&block.name),
        // Where uniforms are filled up, what the members leave is never read.
        size: block.bytes.len().next_multiple_of(padding::BLOCK_STEP_BYTES) as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, &block.bytes);
    buffer
}
