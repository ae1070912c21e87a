//! Effects that follow each other and change pixels alone, in one pass: their functions one after the other, without
//! textures between them.

use super::EffectStage;
use super::compiled::{CompiledEffect, compiled_steps};
use super::declarations::{BorrowedTexture, declarations, table_declarations};
use super::rename::renamed;
use super::steps::Step;
use crate::gpu::Gpu;
use crate::shader::frame_group::OWN_TEXTURES_MAX;
use crate::shader::locate;
use crate::shader::program::Slot;
use crate::shader::reflection::reflect_bindings_of;
use crate::user_shader::scan::scan;
use std::fmt::Write;
use std::sync::Arc;

/// The entry point of an effect that changes pixels alone.
pub(super) const PIXEL_ENTRY: &str = "fs_each_pixel";
/// So many effects share a pass: those of more would only grow the shader.
pub(super) const FUSED_EFFECTS_MAX: usize = 8;
/// So many uniforms of theirs fit a stage on every adapter, beside those of the view and of `drawn`.
pub(super) const FUSED_UNIFORMS_MAX: usize = 8;

/// The pass that several effects share.
#[derive(Debug)]
pub(super) struct FusedPass {
    pub compiled: CompiledEffect,
}

/// The declaration of the entry point that calls `functions` one after the other. What is no number, or more than half
/// floats hold, does not leave it.
pub(super) fn entry_point<'t>(stage: EffectStage, functions: impl Iterator<Item = &'t str>) -> String {
    let at = if stage == EffectStage::Display { "display_at" } else { "radiance_at" };
    let calls: String = functions.map(|function| format!("    color = {function}(color, position.xy);\n")).collect();
    format!(
        "@fragment\nfn {PIXEL_ENTRY}(@builtin(position) position: vec4f) -> @location(0) vec4f {{\n    \
         var color = {at}(vec2i(position.xy));\n{calls}    \
         return vec4f(half_float_clamped(color.rgb), max(color.a, 0.0));\n}}\n"
    )
}

/// Compiles the pass of effects that all change pixels alone; none where they do not fit together, because one of them
/// is written in a way that this cannot read, or they read too much.
pub(super) fn compile(gpu: &Gpu, name: &str, effects: &[Arc<CompiledEffect>]) -> Option<FusedPass> {
    let stage = effects.first()?.stage;
    let mut text = String::new();
    let mut functions = Vec::new();
    let mut uniforms = Vec::new();
    let mut borrowed = Vec::new();
    let mut tables = Vec::new();
    for (index, effect) in effects.iter().enumerate() {
        let pixel = effect.pixel.as_ref()?;
        let prefix = format!("e{index}_");
        writeln!(text, "{}", renamed(&pixel.text, &scan(&pixel.text), &prefix, uniforms.len())?).ok()?;
        functions.push(format!("{prefix}{}", pixel.function));
        uniforms.extend(effect.uniforms.iter().map(|(name, buffer)| (format!("{prefix}{name}"), buffer.clone())));
        tables.extend(effect.tables.iter().cloned());
        // What several read is declared once, whichever settings it is for.
        let is_new = |one: &&BorrowedTexture| borrowed.iter().all(|known: &BorrowedTexture| known.key != one.key);
        borrowed.extend(effect.borrowed.iter().filter(is_new).cloned().collect::<Vec<_>>());
    }
    let finds_drawn = effects.iter().filter_map(|effect| effect.pixel.as_ref()).any(|pixel| pixel.finds_drawn);
    let mut further = declarations(stage == EffectStage::Display, finds_drawn, &[], &borrowed);
    further.push_str(&table_declarations(tables.iter().map(|(name, _)| name.as_str())));
    further.push_str(&entry_point(stage, functions.iter().map(String::as_str)));
    let (module, info) = locate::parse(name, &text, &further).ok()?;
    let composed = locate::composed(&text, &further);
    let entry = module.entry_points.iter().position(|entry| entry.name == PIXEL_ENTRY)?;
    let slots = reflect_bindings_of(&module, &info, &composed, entry..entry + 1);
    let is_texture = |slot: &&Slot| matches!(slot.entry.ty, wgpu::BindingType::Texture { .. });
    let fits = slots.iter().skip(1).flatten().filter(is_texture).count() <= OWN_TEXTURES_MAX;
    if !fits {
        return None;
    }
    let steps = vec![(Step::only(PIXEL_ENTRY.into()), slots)];
    let passes = compiled_steps(gpu, (name, name), (composed, &module), steps, &uniforms).ok()?;
    let compiled =
        CompiledEffect { id: CompiledEffect::next_id(), stage, passes, borrowed, uniforms, tables, pixel: None };
    Some(FusedPass { compiled })
}
