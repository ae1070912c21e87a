//! Effects of WGSL files on a device.

use super::compiled::{CompiledEffect, CompiledStep, Pixel, compiled_steps};
use super::declarations::BorrowedTexture;
use super::fallback::Fallback;
use super::fused::FusedPass;
use super::lut::Table;
use super::{Effect, EffectFile, EffectStage, chain, draw};
use crate::gbuffer::Gbuffer;
use crate::gpu::Gpu;
use crate::record::Recorder;
use crate::settings::{SettingInfo, SettingValue, SettingsError};
use crate::shader::locate;
use crate::shader::program::ProgramError;
use crate::user_shader::padding;
use crate::user_shader::uniforms::Uniforms;
use manypass_graph::Handle;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// An effect of full-screen fragment shaders in one file, whose last one returns the new radiance, or display colour, of
/// its pixel.
///
/// The shader finds this declared, beside what WGSL has (all of it is [`crate::shader::compose::EFFECT_PRELUDE`]):
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
    file: String,
    name: String,
    state: Mutex<State>,
}

/// What another text of the effect replaces.
#[derive(Debug)]
struct State {
    compiled: Arc<CompiledEffect>,
    uniforms: Uniforms,
    /// The passes that it shares with effects that follow it, by the numbers of all of them; none where it cannot.
    fused: Vec<(Vec<u64>, Option<Arc<FusedPass>>)>,
    /// What its text says that is drawn in its place where time is short.
    fallback: Option<Fallback>,
    /// The same on the device, once it was drawn.
    compiled_fallback: Option<Arc<WgslEffect>>,
}

impl State {
    /// Of a text that was compiled.
    fn new(compiled: CompiledEffect, uniforms: Uniforms, fallback: Option<Fallback>) -> Self {
        Self { compiled: Arc::new(compiled), uniforms, fused: Vec::new(), fallback, compiled_fallback: None }
    }
}

/// An effect keeps so many passes that it shares with others: as many as there are sets of those that are on.
const FUSED_MAX: usize = 8;

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
        let (file, name) = (effect.file.clone(), effect.name.clone());
        let fallback = effect.fallback;
        let (compiled, uniforms) = compiled(gpu, effect)?;
        let state = State::new(compiled, uniforms, fallback);
        Ok(Self { gpu: gpu.clone(), file, name, state: Mutex::new(state) })
    }

    /// Compiles another text for it, which is drawn from the next frame on. Settings that it has too keep their values
    /// where they take them; others have their defaults.
    ///
    /// # Errors
    /// As [`Self::new`], another name, or a setting without a value; the effect stays as it is then.
    pub fn replace(&self, source: &str) -> Result<(), ProgramError> {
        let effect = EffectFile::parse_replacing((&self.file, &self.name), self.values(), source)?;
        let fallback = effect.fallback;
        let (compiled, uniforms) = compiled(&self.gpu, effect)?;
        *self.state() = State::new(compiled, uniforms, fallback);
        Ok(())
    }

    /// The name: in reports and the keys of its settings; in plans and timers that of its only pass, or what the names of
    /// several begin with.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The members of its uniforms that text can give, in the order of their declaration; then whether it is drawn.
    pub fn settings(&self) -> Vec<SettingInfo> {
        self.state().uniforms.settings.clone()
    }

    /// The present values of all settings, by their keys.
    pub fn values(&self) -> Vec<(String, SettingValue)> {
        self.state().uniforms.values()
    }

    /// Sets `key`, `EFFECT.MEMBER` or `EFFECT.UNIFORM.MEMBER`, from the next frame on: one number, or the components of
    /// a vector with commas between; `EFFECT.enabled` to `false` leaves the effect out.
    ///
    /// # Errors
    /// An unknown key, another number of numbers, or one outside the range.
    pub fn set(&self, key: &str, value: &str) -> Result<(), SettingsError> {
        let mut state = self.state();
        if let Some(block) = state.uniforms.set(self.name(), key, &value.into())? {
            self.upload(&state, block);
        }
        Ok(())
    }

    /// Sets the whole uniform `name` from the next frame on: its bytes as WGSL lays them out. Ranges do not count.
    ///
    /// # Errors
    /// The shader uses no such uniform, or it has another size.
    pub fn set_uniform(&self, name: &str, bytes: &[u8]) -> Result<(), ProgramError> {
        let fault = |message: String| ProgramError::Uniform { pass: self.name().into(), uniform: name.into(), message };
        let mut state = self.state();
        let used = || state.uniforms.blocks.iter().enumerate().filter(|(_, block)| block.is_used);
        let found = used().find(|(_, block)| block.name == name).map(|(index, block)| (index, block.bytes.len()));
        let (block, size) = found.ok_or_else(|| {
            let known: Vec<_> = used().map(|(_, block)| block.name.as_str()).collect();
            fault(format!("the shader uses no such uniform in group 2; it uses: {}", known.join(", ")))
        })?;
        if size != bytes.len() {
            return Err(fault(format!("it has {size} bytes, not {}", bytes.len())));
        }
        state.uniforms.set_block(block, bytes);
        self.upload(&state, block);
        Ok(())
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Nothing panics while it is held; if it did, the bytes would still be whole numbers.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn upload(&self, state: &State, block: usize) {
        let buffer = state.compiled.uniforms.get(block).and_then(|(_, buffer)| buffer.as_ref());
        if let (Some(buffer), Some(block)) = (buffer, state.uniforms.blocks.get(block)) {
            self.gpu.queue.write_buffer(buffer, 0, &block.bytes);
        }
    }

    /// What draws it.
    ///
    /// # Errors
    /// It is of another device, or a setting has no value.
    pub(super) fn compiled(&self, r: &Recorder<'_, '_>) -> Result<Arc<CompiledEffect>, ProgramError> {
        if !r.frame.gpu.is_same(&self.gpu) {
            let message = "it was compiled for another device than that of `Renderer::gpu`".into();
            return Err(ProgramError::Misplaced { pass: self.name().into(), message });
        }
        let state = self.state();
        if let Some((_, missing)) = state.uniforms.missing() {
            return Err(Box::new(missing.clone()).into());
        }
        Ok(state.compiled.clone())
    }

    /// Whether its settings let it look at what it borrows.
    pub(super) fn wants(&self, borrowed: &BorrowedTexture) -> bool {
        self.state().uniforms.wants(&self.name, &borrowed.settings)
    }

    /// What it knows of others in the chain.
    pub(super) fn needs(&self) -> Arc<CompiledEffect> {
        self.state().compiled.clone()
    }

    /// Whether it comes with the renderer, and so makes numbers of numbers.
    pub(super) fn is_built_in(&self) -> bool {
        EffectFile::is_built_in(&self.file)
    }

    /// What its text says that is drawn in its place where time is short.
    pub(super) fn fallback(&self) -> Option<Fallback> {
        self.state().fallback
    }

    pub(super) fn compiled_fallback(&self) -> Option<Arc<Self>> {
        self.state().compiled_fallback.clone()
    }

    pub(super) fn keep_fallback(&self, compiled: Arc<Self>) {
        self.state().compiled_fallback = Some(compiled);
    }

    /// The device that it was compiled for.
    pub(super) fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// How often each of its passes is drawn.
    pub(super) fn rounds(&self, compiled: &CompiledEffect) -> Vec<u32> {
        let state = self.state();
        let rounds = |pass: &CompiledStep| pass.step.rounds.count(&self.name, &state.uniforms);
        compiled.passes.iter().map(rounds).collect()
    }

    /// The pass that it shares with `followers`, made by `make` when they first follow it.
    pub(super) fn fused(
        &self,
        followers: &[Arc<CompiledEffect>],
        make: impl FnOnce(&Gpu) -> Option<FusedPass>,
    ) -> Option<Arc<FusedPass>> {
        let mut state = self.state();
        let ids: Vec<u64> = followers.iter().map(|follower| follower.id).collect();
        if let Some((_, fused)) = state.fused.iter().find(|(known, _)| *known == ids) {
            return fused.clone();
        }
        let fused = make(&self.gpu).map(Arc::new);
        if state.fused.len() == FUSED_MAX {
            state.fused.remove(0);
        }
        state.fused.push((ids, fused.clone()));
        fused
    }
}

impl Effect for WgslEffect {
    fn record<'f>(
        &'f self,
        r: &mut Recorder<'_, 'f>,
        gbuffer: Option<&Gbuffer>,
        radiance: Handle,
    ) -> Result<Handle, ProgramError> {
        let of_frame = chain::FrameTextures { gbuffer, ..Default::default() };
        let compiled = self.compiled(r)?;
        draw::record(r, self, &compiled, &of_frame, &mut HashMap::new(), radiance)
    }

    fn stage(&self) -> EffectStage {
        self.state().compiled.stage
    }

    fn is_on(&self) -> bool {
        !self.state().uniforms.is_off
    }

    fn wgsl(&self) -> Option<&WgslEffect> {
        Some(self)
    }
}

/// An effect on a device, and the values of its uniforms.
fn compiled(gpu: &Gpu, effect: EffectFile) -> Result<(CompiledEffect, Uniforms), ProgramError> {
    let EffectFile {
        file, mut text, name, mut module, further, steps, stage, uniforms, borrowed, pixel, table, ..
    } = effect;
    if !gpu.capabilities.uniforms_of_any_size {
        (text, module) = padding::filled_up((&file, &name), (text, &further), module, &uniforms)?;
    }
    let buffers =
        uniforms.blocks.iter().map(|block| (block.name.clone(), block.is_used.then(|| padding::buffer(gpu, block))));
    let buffers: Vec<_> = buffers.collect();
    let composed = locate::composed(&text, &further);
    let passes = compiled_steps(gpu, (&name, &file), (composed, &module), steps, &buffers)?;
    let pixel = pixel.map(|function| Pixel { text, function, finds_drawn: stage == EffectStage::Display });
    let tables = table.iter().map(|table| (table.variable.clone(), texture(gpu, table))).collect();
    Ok((
        CompiledEffect { id: CompiledEffect::next_id(), stage, passes, borrowed, uniforms: buffers, tables, pixel },
        uniforms,
    ))
}

fn texture(gpu: &Gpu, table: &Table) -> wgpu::TextureView {
    let [width, height, depth_or_array_layers] = table.size;
    let size = wgpu::Extent3d { width, height, depth_or_array_layers };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&table.variable),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * width), rows_per_image: Some(height) };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&table.texels), layout, size);
    texture.create_view(&Default::default())
}
