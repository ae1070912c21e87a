//! The passes of an effect in a frame.

use super::chain::FrameTextures;
use super::compiled::{CompiledEffect, CompiledStep};
use super::declarations::IDS;
use super::header::DISPLAY;
use super::{EffectStage, WgslEffect};
use crate::gbuffer::RADIANCE;
use crate::record::Recorder;
use crate::shader::program::{ProgramError, Slot};
use manypass_graph::{ColorLoad, Handle, TextureDesc};
use std::collections::HashMap;

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

/// Records all passes of `effect`, which change `color`, and leaves its textures among `left` as `EFFECT.TEXTURE`.
///
/// # Errors
/// It reads what is not there.
pub(super) fn record(
    r: &mut Recorder<'_, '_>,
    effect: &WgslEffect,
    compiled: &CompiledEffect,
    of_frame: &FrameTextures<'_>,
    left: &mut HashMap<String, Handle>,
    color: Handle,
) -> Result<Handle, ProgramError> {
    let name = effect.name();
    let TextureDesc { width, height, .. } = color.desc();
    let desc = TextureDesc::new_2d(width, height, RADIANCE);
    let reads_previous =
        |pass: &CompiledStep| pass.pipeline.program.slots(1).iter().any(|slot| slot.name == "previous");
    let (previous, result) = if compiled.passes.iter().any(reads_previous) {
        let history = r.graph.history(name.to_owned(), desc);
        let goes_on = match compiled.stage {
            EffectStage::Display => r.view.display_goes_on,
            _ => r.view.effects_go_on,
        };
        let is_first = history.is_first || !goes_on;
        ((!is_first).then_some(history.previous), history.next)
    } else {
        (None, r.texture_of(format!("{name}.{}", word(compiled.stage)), desc))
    };
    let Some((last, others)) = compiled.passes.split_last() else { return Ok(color) };
    let rounds = effect.rounds(compiled);
    let mut own: HashMap<String, Handle> = HashMap::new();
    // How often each function was drawn, because no two passes of a frame have one name.
    let mut drawn: HashMap<&str, u32> = HashMap::new();
    let unread = unread(&[effect]);
    let shown =
        EffectInputs { of_frame, color: &color, previous: previous.as_ref(), stage: compiled.stage, unread: &unread };
    for (pass, rounds) in others.iter().zip(rounds) {
        // All but the last pass write a texture.
        let texture = pass.step.texture.as_deref().unwrap_or_default();
        let side = |of: u32| of.div_ceil(pass.step.divisor);
        let desc = TextureDesc::new_2d(side(width), side(height), RADIANCE);
        for round in 0..rounds {
            let target = r.texture_of(format!("{name}.{texture}"), desc);
            let count = drawn.entry(&pass.step.name).or_default();
            *count += 1;
            let offered = PassTextures { shown: &shown, own: &own, compiled, left };
            let written = draw(r, name, pass, &offered, (*count, round, rounds), target)?;
            own.insert(texture.to_owned(), written);
        }
    }
    let count = drawn.get(&*last.step.name).copied().unwrap_or_default() + 1;
    let drawn = draw(r, name, last, &PassTextures { shown: &shown, own: &own, compiled, left }, (count, 0, 1), result)?;
    left.extend(own.into_iter().map(|(texture, handle)| (format!("{name}.{texture}"), handle)));
    Ok(drawn)
}

/// What passes of `effects` declare and none of them looks at as its settings are, by the names in the shader.
fn unread(effects: &[&WgslEffect]) -> Vec<String> {
    let (mut read, mut unread) = (Vec::new(), Vec::new());
    for effect in effects {
        for borrowed in &effect.needs().borrowed {
            let list = if effect.wants(borrowed) { &mut read } else { &mut unread };
            list.push(borrowed.variable.clone());
        }
    }
    unread.retain(|variable| !read.contains(variable));
    unread
}

/// Records one pass that changes `color`, of several effects at once; `name` is theirs.
///
/// # Errors
/// It reads what is not there.
pub(super) fn record_fused(
    r: &mut Recorder<'_, '_>,
    name: &str,
    (effects, fused): (&[&WgslEffect], &CompiledEffect),
    of_frame: &FrameTextures<'_>,
    left: &HashMap<String, Handle>,
    color: &Handle,
) -> Result<Option<Handle>, ProgramError> {
    let Some(pass) = fused.passes.last() else { return Ok(None) };
    let TextureDesc { width, height, .. } = color.desc();
    let desc = TextureDesc::new_2d(width, height, RADIANCE);
    let result = r.texture_of(format!("{name}.{}", word(fused.stage)), desc);
    let unread = unread(effects);
    let shown = EffectInputs { of_frame, color, previous: None, stage: fused.stage, unread: &unread };
    let offered = PassTextures { shown: &shown, own: &HashMap::new(), compiled: fused, left };
    draw(r, name, pass, &offered, (1, 0, 1), result).map(Some)
}

/// What effects of a stage call what they change.
fn word(stage: EffectStage) -> &'static str {
    if stage == EffectStage::Display { DISPLAY } else { "radiance" }
}

/// Records one round of a pass of the effect `effect`, whose function is drawn for the `count`th time.
fn draw(
    r: &mut Recorder<'_, '_>,
    effect: &str,
    CompiledStep { pipeline, own_group, .. }: &CompiledStep,
    offered: &PassTextures<'_>,
    (count, round, rounds): (u32, u32, u32),
    target: Handle,
) -> Result<Handle, ProgramError> {
    let name = &pipeline.program.name;
    let name = if count == 1 { name.clone() } else { format!("{name}.{count}") };
    let TextureDesc { width, height, .. } = target.desc();
    let size_px = [width as f32, height as f32];
    let inverse_size_px = size_px.map(f32::recip);
    let drawn = DrawnUniform { size_px, inverse_size_px, round, rounds, padding: [0.0; 2] };
    let (white, no_ids) = (r.frame.resources.textures.white(), &r.frame.tables.no_ids);
    let mut step = r.own_fullscreen(name, pipeline.clone(), own_group.clone());
    for slot in pipeline.program.slots(1) {
        match offered.get(&slot.name) {
            Some(handle) => step = step.read(slot.name.clone(), handle),
            None if slot.name == "drawn" => step = step.uniform("drawn", &drawn),
            None if slot.name.ends_with("_clamp") => {}
            None => match offered.table(&slot.name) {
                Some(table) => step = step.table(slot.name.clone(), table),
                None if offered.shown.unread.contains(&slot.name) => {
                    let stand_in = if is_of_ids(slot) { no_ids } else { white };
                    step = step.table(slot.name.clone(), stand_in);
                }
                None => return Err(offered.missing(effect, &slot.name)),
            },
        }
    }
    step.draw_into(target, ColorLoad::Discard)
}

/// What an effect changes, and what else there is of the frame.
struct EffectInputs<'h> {
    of_frame: &'h FrameTextures<'h>,
    color: &'h Handle,
    /// What it made in the frame before; without it `color` stands for that.
    previous: Option<&'h Handle>,
    stage: EffectStage,
    /// What the frame need not have, because nobody looks at it.
    unread: &'h [String],
}

/// Whether the texels of a texture are whole numbers, as ids are.
fn is_of_ids(slot: &Slot) -> bool {
    matches!(slot.entry.ty, wgpu::BindingType::Texture { sample_type: wgpu::TextureSampleType::Uint, .. })
}

impl<'h> EffectInputs<'h> {
    /// The textures of the frame that an effect may read, by their names in shaders.
    fn textures(&self) -> Vec<(&'static str, &'h Handle)> {
        let mut offered = vec![(word(self.stage), self.color), ("previous", self.previous.unwrap_or(self.color))];
        if self.stage == EffectStage::Display {
            return offered;
        }
        let FrameTextures { gbuffer, occlusion, motion, ids } = *self.of_frame;
        if let Some(gbuffer) = gbuffer {
            offered.extend([
                ("base_color", &gbuffer.base_color),
                ("normal", &gbuffer.normal),
                ("material", &gbuffer.material),
                ("linear_depth", &gbuffer.linear_depth),
            ]);
        }
        offered.extend(occlusion.map(|handle| ("occlusion", handle)));
        offered.extend(motion.map(|handle| ("motion", handle)));
        offered.extend(ids.map(|handle| (IDS, handle)));
        offered
    }
}

/// The textures that a pass of an effect may read, by their names in the shader.
struct PassTextures<'h> {
    shown: &'h EffectInputs<'h>,
    /// What the effect's passes wrote so far.
    own: &'h HashMap<String, Handle>,
    compiled: &'h CompiledEffect,
    /// What effects before it wrote.
    left: &'h HashMap<String, Handle>,
}

impl PassTextures<'_> {
    fn get(&self, name: &str) -> Option<&Handle> {
        let of_others = || {
            let borrowed = self.compiled.borrowed.iter().find(|borrowed| borrowed.variable == name)?;
            self.left.get(&borrowed.key)
        };
        let of_frame = || self.shown.textures().into_iter().find(|(known, _)| *known == name).map(|(_, handle)| handle);
        self.own.get(name).or_else(of_others).or_else(of_frame)
    }

    fn table(&self, name: &str) -> Option<&wgpu::TextureView> {
        self.compiled.tables.iter().find(|(known, _)| known == name).map(|(_, table)| table)
    }

    fn missing(&self, effect: &str, name: &str) -> ProgramError {
        let name = if name == "linear_depth" { "depth" } else { name };
        let remedy = match name {
            "occlusion" => "; it needs occlusion.enabled=true and another render.path than gouraud",
            "motion" => "; it needs render.path=deferred",
            IDS => "; it needs render.path=deferred and camera.fisheye=none",
            "base_color" | "normal" | "material" | "depth" => "; it needs render.path=deferred and camera.fisheye=none",
            _ => "",
        };
        let known: Vec<_> = self.shown.textures().iter().map(|(name, _)| *name).collect();
        let known = known.join(", ");
        let message = format!("it reads `{name}`, which this frame does not have{remedy}; there is: {known}");
        ProgramError::Misplaced { pass: effect.into(), message }
    }
}
