//! Effects: passes of the user's own between shading and accumulation, most of them one WGSL file.

mod file;
mod header;
mod padding;
mod scan;
mod uniforms;

pub use file::EffectFile;

use crate::gbuffer::{Gbuffer, RADIANCE};
use crate::gpu::Gpu;
use crate::record::Recorder;
use crate::settings::{SettingInfo, SettingValue, Settings, SettingsError, Written};
use crate::shader::cache::{FullscreenPipeline, FullscreenTarget};
use crate::shader::program::{FrameLayout, Program, ProgramError};
use crate::shader::{compose, locate};
use manypass_graph::{ColorLoad, Handle, TextureDesc};
use std::fmt::Debug;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use uniforms::{Block, OWN_GROUP, Uniforms};

/// A pass, or several, that make new radiance of a view's radiance: after its surfaces, before accumulation and the
/// tone curve. [`crate::FrameRequest::effects`] lists them in their order.
///
/// [`WgslEffect`] is the one for a single full-screen shader. Implement this trait for anything else: a blur of two
/// passes, a pass with textures of its own.
pub trait Effect: Debug + wgpu::WasmNotSendSync {
    /// Records the passes and returns what holds the new radiance: the format of `radiance`, pre-exposed, with coverage
    /// in alpha. `gbuffer` is none on the forward path.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    fn record<'f>(
        &'f self,
        r: &mut Recorder<'_, 'f>,
        gbuffer: Option<&Gbuffer>,
        radiance: Handle,
    ) -> Result<Handle, ProgramError>;
}

/// An effect of one full-screen fragment shader, which returns the new radiance of its pixel.
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
    pipeline: Arc<FullscreenPipeline>,
    /// The same as those of `uniforms`, which keeps their values.
    settings: Vec<SettingInfo>,
    uniforms: Mutex<Uniforms>,
    /// A buffer for every block of `uniforms`; none if the shader does not use it.
    buffers: Vec<Option<wgpu::Buffer>>,
    own_group: Option<wgpu::BindGroup>,
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
        let EffectFile { file, mut text, name, mut module, slots, uniforms } = effect;
        let invalid = |message: String| ProgramError::Invalid { pass: name.clone(), message };
        if !gpu.capabilities.uniforms_of_any_size {
            (text, module) = padding::filled_up(&file, &name, text, module, &uniforms)?;
        }
        #[cfg(not(target_arch = "wasm32"))]
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let triangle = compose::source("fullscreen", &[]).map_err(&invalid)?;
        let frame = FrameLayout::new(&gpu.device);
        let triangle = Program::new(&frame, "fullscreen", triangle)?;
        let composed = locate::composed(&text);
        let program = Arc::new(Program::from_parsed(&frame, &name, &composed, &module, slots)?);
        let pipeline =
            FullscreenPipeline::new(&gpu.device, program.clone(), &triangle, FullscreenTarget::of(RADIANCE), &[]);
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
        let own_group =
            program.uses_group(OWN_GROUP).then(|| program.bind(&gpu.device, OWN_GROUP, &resources)).transpose()?;
        let settings = uniforms.settings.clone();
        let uniforms = Mutex::new(uniforms);
        Ok(Self { gpu: gpu.clone(), pipeline: Arc::new(pipeline), settings, uniforms, buffers, own_group })
    }

    /// The name of the pass: in plans, timers, reports and the keys of its settings.
    pub fn name(&self) -> &str {
        &self.pipeline.program.name
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
        if self.uniforms().is_off {
            return Ok(radiance);
        }
        if let Some((_, missing)) = self.uniforms().missing() {
            return Err(Box::new(missing.clone()).into());
        }
        let TextureDesc { width, height, .. } = radiance.desc();
        let desc = TextureDesc::new_2d(width, height, RADIANCE);
        let keeps = self.pipeline.program.slots(1).iter().any(|slot| slot.name == "previous");
        let (previous, target) = if keeps {
            let history = r.history(self.name().to_owned(), desc);
            ((!history.is_first).then_some(history.previous), history.next)
        } else {
            (None, r.texture_of(format!("{}.radiance", self.name()), desc))
        };
        let offered = textures(gbuffer, &radiance, previous.as_ref());
        let mut step = r.own_fullscreen(self.name().to_owned(), self.pipeline.clone(), self.own_group.clone());
        for slot in self.pipeline.program.slots(1) {
            match offered.iter().find(|(name, _)| *name == slot.name) {
                Some((name, handle)) => step = step.read(name, handle),
                None if slot.name.ends_with("_clamp") => {}
                None => {
                    let known: Vec<_> = offered.iter().map(|(name, _)| *name).collect();
                    let message = format!(
                        "it reads `{}`, which this path does not have; there is: {}",
                        slot.name,
                        known.join(", ")
                    );
                    return Err(ProgramError::Misplaced { pass: self.name().into(), message });
                }
            }
        }
        step.draw_into(target, ColorLoad::Discard)
    }
}

/// The textures that an effect may read, by their names.
fn textures<'h>(
    gbuffer: Option<&'h Gbuffer>,
    radiance: &'h Handle,
    previous: Option<&'h Handle>,
) -> Vec<(&'static str, &'h Handle)> {
    let mut offered = vec![("radiance", radiance), ("previous", previous.unwrap_or(radiance))];
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
