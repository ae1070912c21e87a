//! The chain of effects: in which order they are drawn, and which of them together.

use super::compiled::CompiledEffect;
use super::declarations::BorrowedTexture;
use super::fused::{self, FUSED_EFFECTS_MAX, FUSED_UNIFORMS_MAX};
use super::{Effect, EffectFile, EffectStage, WgslEffect, draw};
use crate::gbuffer::Gbuffer;
use crate::passes::scrub;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{Handle, TextureDesc};
use std::collections::HashMap;
use std::sync::Arc;

/// What effects on radiance may read of the frame, beside radiance.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FrameTextures<'h> {
    /// What is known of surfaces, on the deferred path.
    pub gbuffer: Option<&'h Gbuffer>,
    /// The share of the environment's light that reaches them, if it is found.
    pub occlusion: Option<&'h Handle>,
    /// How far they moved since the frame before, pixels, if somebody wants it.
    pub motion: Option<&'h Handle>,
    /// Which nodes and materials they are of, if somebody wants it.
    pub ids: Option<&'h Handle>,
}

/// Records the effects of a stage that are on, in the order of the chain; what they change is `color`.
///
/// # Errors
/// As [`Effect::record`], and as [`EffectFile::check_chain`].
pub(crate) fn record<'f>(
    r: &mut Recorder<'_, 'f>,
    effects: &'f [Arc<dyn Effect>],
    stage: EffectStage,
    of_frame: &FrameTextures<'_>,
    mut color: Handle,
) -> Result<Handle, ProgramError> {
    let order = {
        let nodes: Vec<Node> = effects.iter().map(|effect| Node::of(&**effect)).collect();
        ordered(&nodes)?
    };
    let drawn: Vec<&'f Arc<dyn Effect>> = order
        .into_iter()
        .filter_map(|index| effects.get(index))
        .filter(|effect| effect.is_on() && effect.stage() == stage)
        .collect();
    let mut left = HashMap::new();
    let mut scrubs = 0;
    // The tone curve leaves numbers alone.
    let mut is_clean = stage == EffectStage::Display;
    let mut rest = &drawn[..];
    while let Some((first, after)) = rest.split_first() {
        let is_of_pixel = first.wgsl().is_some_and(|effect| effect.needs().pixel.is_some());
        if !is_of_pixel && !is_clean {
            color = scrub::record(r, scrubs, &color)?;
            scrubs += 1;
        }
        // Functions of pixels are followed by the same.
        is_clean = is_of_pixel || first.wgsl().is_some_and(WgslEffect::is_built_in);
        let Some(effect) = first.wgsl() else {
            let given = color.desc();
            color = first.record(r, of_frame.gbuffer, color)?;
            check_returned(given, &color)?;
            rest = after;
            continue;
        };
        let together = together(r, rest)?;
        if let Some((name, pass)) = fused_of(effect, &together) {
            let effects: Vec<&WgslEffect> = together.iter().map(|(effect, _)| *effect).collect();
            let drawn = draw::record_fused(r, &name, (&effects, &pass.compiled), of_frame, &left, &color)?;
            color = drawn.unwrap_or(color);
            rest = rest.get(together.len()..).unwrap_or_default();
            continue;
        }
        let compiled = effect.compiled(r)?;
        color = draw::record(r, effect, &compiled, of_frame, &mut left, color)?;
        rest = after;
    }
    Ok(color)
}

/// Checks that what an effect returns has the shape of what it was given: passes after it are made for that.
fn check_returned(given: TextureDesc, returned: &Handle) -> Result<(), ProgramError> {
    let desc = returned.desc();
    if desc == given {
        return Ok(());
    }
    let shape = |desc: TextureDesc| {
        let TextureDesc { width, height, layers, mips, samples, format } = desc;
        format!("{width} × {height} {format:?} ({layers} layers, {mips} mips, {samples} samples)")
    };
    let message = format!("it returns {}, but was given {}", shape(desc), shape(given));
    Err(ProgramError::Misplaced { pass: returned.name().into(), message })
}

/// The first effects of a list that change pixels alone and fit one pass, each with what draws it.
fn together<'e>(
    r: &Recorder<'_, '_>,
    effects: &[&'e Arc<dyn Effect>],
) -> Result<Vec<(&'e WgslEffect, Arc<CompiledEffect>)>, ProgramError> {
    let mut together: Vec<(&WgslEffect, Arc<CompiledEffect>)> = Vec::new();
    let mut uniforms = 0;
    for effect in effects.iter().take(FUSED_EFFECTS_MAX) {
        let Some(effect) = effect.wgsl() else { break };
        let compiled = effect.compiled(r)?;
        let of_one =
            |compiled: &CompiledEffect| compiled.uniforms.iter().filter(|(_, buffer)| buffer.is_some()).count();
        uniforms += of_one(&compiled);
        if compiled.pixel.is_none() || uniforms > FUSED_UNIFORMS_MAX {
            break;
        }
        together.push((effect, compiled));
    }
    Ok(together)
}

/// The pass of several effects, and its name.
fn fused_of(
    first: &WgslEffect,
    together: &[(&WgslEffect, Arc<CompiledEffect>)],
) -> Option<(String, Arc<fused::FusedPass>)> {
    if together.len() < 2 {
        return None;
    }
    let names: Vec<&str> = together.iter().map(|(effect, _)| effect.name()).collect();
    let name = names.join("+");
    let compiled: Vec<Arc<CompiledEffect>> = together.iter().map(|(_, compiled)| compiled.clone()).collect();
    let pass = first.fused(&compiled, |gpu| fused::compile(gpu, &name, &compiled))?;
    Some((name, pass))
}

/// Whether an effect that is on reads `texture` of the frame, which only the header of its file declares, and its settings
/// let it look at that.
pub(crate) fn is_read(effects: &[Arc<dyn Effect>], texture: &str) -> bool {
    let reads = |effect: &WgslEffect| {
        effect.needs().borrowed.iter().any(|borrowed| borrowed.key == texture && effect.wants(borrowed))
    };
    effects.iter().any(|effect| effect.is_on() && effect.wgsl().is_some_and(reads))
}

impl EffectFile {
    /// The effects of a chain, in its order: for each of `names` the one of `given` that is called so, or the built-in one,
    /// or what `read` makes of it, a file's name; then those of `given` that it does not name.
    ///
    /// # Errors
    /// What `read` says, and two effects of one name, whose settings and passes nobody could tell apart.
    pub fn chain<E: From<ProgramError>>(
        names: &[String],
        mut given: Vec<Self>,
        mut read: impl FnMut(&str) -> Result<Self, E>,
    ) -> Result<Vec<Self>, E> {
        let mut chain: Vec<Self> = Vec::new();
        for name in names {
            let of_given = given.iter().position(|file| file.name == *name);
            let effect = match (of_given, Self::built_in(name)) {
                (Some(index), _) => given.remove(index),
                (None, Some(built_in)) => built_in?,
                (None, None) => read(name)?,
            };
            // The same file may be given, too.
            given.retain(|other| !(other.name == effect.name && other.text == effect.text));
            chain.push(effect);
        }
        chain.append(&mut given);
        for (index, file) in chain.iter().enumerate() {
            if let Some(other) = chain.iter().take(index).find(|other| other.name == file.name) {
                let message = if other.text == file.text {
                    "it stands twice in the chain".into()
                } else {
                    format!(
                        "{} and {} are both called so; give one another name, in its first line: `//! effect NAME`",
                        other.file, file.file
                    )
                };
                return Err(ProgramError::Misplaced { pass: file.name.clone(), message }.into());
            }
        }
        Ok(chain)
    }

    /// Checks whether effects that read each other's textures can be put into an order.
    ///
    /// # Errors
    /// One that reads a texture of an effect that is not there, is off, or belongs to the other stage, or that none of its
    /// passes writes; effects that read each other's in a circle.
    pub fn check_chain(effects: &[Self]) -> Result<(), ProgramError> {
        let node = |file: &'_ Self| Node {
            name: file.name.clone(),
            stage: file.stage,
            is_on: !file.uniforms.is_off,
            borrowed: file.borrowed.clone(),
            textures: file.steps.iter().filter_map(|(step, _)| step.texture.clone()).collect(),
        };
        ordered(&effects.iter().map(node).collect::<Vec<_>>()).map(drop)
    }
}

/// An effect of a chain, as far as the order goes.
struct Node {
    name: String,
    stage: EffectStage,
    is_on: bool,
    borrowed: Vec<BorrowedTexture>,
    /// What others may read of it.
    textures: Vec<String>,
}

impl Node {
    fn of(effect: &dyn Effect) -> Self {
        let (name, borrowed, textures) = match effect.wgsl() {
            None => Default::default(),
            Some(wgsl) => {
                let compiled = wgsl.needs();
                let textures = compiled.passes.iter().filter_map(|pass| pass.step.texture.clone()).collect();
                (wgsl.name().to_owned(), compiled.borrowed.clone(), textures)
            }
        };
        Self { name, stage: effect.stage(), is_on: effect.is_on(), borrowed, textures }
    }
}

/// The order in which effects are drawn: as they are listed, but each after those whose textures it reads.
fn ordered(nodes: &[Node]) -> Result<Vec<usize>, ProgramError> {
    let mut order = Order { nodes, done: Vec::new(), path: Vec::new() };
    for index in 0..nodes.len() {
        order.visit(index)?;
    }
    Ok(order.done)
}

struct Order<'n> {
    nodes: &'n [Node],
    /// In their order.
    done: Vec<usize>,
    /// Those that wait for one that is looked at.
    path: Vec<usize>,
}

impl Order<'_> {
    fn visit(&mut self, index: usize) -> Result<(), ProgramError> {
        if self.done.contains(&index) {
            return Ok(());
        }
        let nodes = self.nodes;
        let node = &nodes[index];
        if let Some(start) = self.path.iter().position(|known| *known == index) {
            let circle: Vec<&str> =
                self.path[start..].iter().chain([&index]).map(|index| nodes[*index].name.as_str()).collect();
            let message = format!("it reads textures of effects that wait for it: {}", circle.join(" reads of "));
            return Err(ProgramError::Misplaced { pass: node.name.clone(), message });
        }
        self.path.push(index);
        // What is off reads nothing.
        for borrowed in node.borrowed.iter().filter(|_| node.is_on) {
            if let Some((effect, texture)) = borrowed.of_effect() {
                let other = self.provider(node, (effect, texture)).map_err(|reason| {
                    let message = format!("it reads `{}`: {reason}", borrowed.key);
                    ProgramError::Misplaced { pass: node.name.clone(), message }
                })?;
                self.visit(other)?;
            }
        }
        self.path.pop();
        self.done.push(index);
        Ok(())
    }

    /// Who writes a texture that `reader` reads, or why nobody does.
    fn provider(&self, reader: &Node, (effect, texture): (&str, &str)) -> Result<usize, String> {
        let Some(index) = self.nodes.iter().position(|node| node.name == effect) else {
            return Err(format!("there is no effect `{effect}`; list it too, anywhere"));
        };
        let other = &self.nodes[index];
        if !other.is_on {
            return Err(format!("`{effect}` is off; set {effect}.enabled=true, or {}.enabled=false", reader.name));
        }
        if other.stage != reader.stage {
            return Err(format!(
                "`{effect}` and `{}` stand on two sides of the tone curve; effects read those of their own side",
                reader.name
            ));
        }
        if !other.textures.iter().any(|known| known == texture) {
            let mut known = other.textures.clone();
            known.dedup();
            let known = if known.is_empty() { "none".into() } else { known.join(", ") };
            return Err(format!("`{effect}` writes no texture `{texture}`; it writes: {known}"));
        }
        Ok(index)
    }
}
