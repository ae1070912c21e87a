//! Uniforms as WebGL 2 takes them: blocks whose size is a multiple of 16 bytes. Every member keeps its name and its
//! place.

use super::scan::scan;
use super::uniforms::{Block, Uniforms};
use crate::gpu::Gpu;
use crate::shader::locate;
use crate::shader::program::ProgramError;
use naga::{Expression, GlobalVariable, Handle, Module, TypeInner};
use std::ops::Range;

/// Bytes of which the size of a block is a multiple.
pub(crate) const BLOCK_STEP_BYTES: usize = 16;

/// A piece of the text, and what takes its place.
type Edit = (Range<usize>, String);

/// The buffer of a uniform, as large as WebGL 2 takes it.
pub(crate) fn buffer(gpu: &Gpu, block: &Block) -> wgpu::Buffer {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&block.name),
        // Where uniforms are filled up, what the members leave is never read.
        size: block.bytes.len().next_multiple_of(BLOCK_STEP_BYTES) as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, &block.bytes);
    buffer
}

/// Text and module of an effect whose uniforms are of the sizes that WebGL 2 takes.
///
/// # Errors
/// A uniform that cannot be filled up.
pub(crate) fn filled_up(
    (file, name): (&str, &str),
    (text, further): (String, &str),
    module: naga::Module,
    uniforms: &Uniforms,
) -> Result<(String, naga::Module), ProgramError> {
    let is_odd = |block: &&Block| block.is_used && !block.bytes.len().is_multiple_of(BLOCK_STEP_BYTES);
    let odd: Vec<&str> = uniforms.blocks.iter().filter(is_odd).map(|block| block.name.as_str()).collect();
    let Some(first) = odd.first() else { return Ok((text, module)) };
    let padded = padded(&text, &module, &odd);
    let parsed = padded.and_then(|text| Some((locate::parse(file, &text, further).ok()?.0, text)));
    parsed.map(|(module, text)| (text, module)).ok_or_else(|| {
        let message = format!(
            "the size of the uniform `{first}` is not a multiple of 16 bytes, as this adapter (WebGL 2) requires, and it \
             cannot be padded: give it a struct of its own, with members whose names begin with `padding` at the end"
        );
        ProgramError::Misplaced { pass: name.into(), message }
    })
}

/// `text`, whose module is `module`, with the uniforms called `names` filled up: the last member of a struct grows by
/// `@size`, and a uniform without a struct becomes the only member of one. Lines keep their numbers. None where that is
/// not possible, as for a struct that another one holds, where it must stay as large as it is.
fn padded(text: &str, module: &Module, names: &[&str]) -> Option<String> {
    let mut edits: Vec<Edit> = Vec::new();
    let mut added = String::new();
    for (handle, global) in module.global_variables.iter() {
        let Some(name) = global.name.as_deref().filter(|name| names.contains(name)) else { continue };
        let found = match &module.types[global.ty].inner {
            TypeInner::Struct { .. } => vec![grown(text, module, global)?],
            _ => {
                let structure = fresh(text, &format!("{name}_block"))?;
                let (wrapped, declaration) = wrapped(text, module, (handle, name), &structure)?;
                added.push_str(&declaration);
                wrapped
            }
        };
        // Two uniforms may be of one struct.
        edits.extend(found.into_iter().filter(|edit| !edits.contains(edit)).collect::<Vec<_>>());
    }
    edits.sort_by_key(|(range, _)| range.start);
    let mut padded = text.to_owned();
    for (range, replacement) in edits.into_iter().rev() {
        padded.replace_range(range, &replacement);
    }
    Some(format!("{padded}\n{added}"))
}

/// The edit by which the last member of the uniform's struct fills it up.
fn grown(text: &str, module: &Module, global: &GlobalVariable) -> Option<Edit> {
    let ty = &module.types[global.ty];
    let TypeInner::Struct { members, span } = &ty.inner else { return None };
    let is_held = module.types.iter().any(|(_, other)| match &other.inner {
        TypeInner::Struct { members, .. } => members.iter().any(|member| member.ty == global.ty),
        TypeInner::Array { base, .. } => *base == global.ty,
        _ => false,
    });
    let last = members.last().filter(|_| !is_held)?;
    let scan = scan(text);
    let declared = scan.members.get(&(ty.name.clone()?, last.name.clone()?))?;
    let size = (*span as usize).next_multiple_of(BLOCK_STEP_BYTES) - last.offset as usize;
    let start = declared.name.start;
    Some((start..start, format!("@size({size}) ")))
}

/// The edits by which a uniform without a struct becomes the member `value` of `structure`, and the declaration of
/// that.
fn wrapped(
    text: &str,
    module: &Module,
    (handle, name): (Handle<GlobalVariable>, &str),
    structure: &str,
) -> Option<(Vec<Edit>, String)> {
    let scan = scan(text);
    let declared = scan.variables.get(name)?;
    let size = module.types[module.global_variables[handle].ty].inner.size(module.to_ctx()) as usize;
    let size = size.next_multiple_of(BLOCK_STEP_BYTES);
    let declaration = format!("struct {structure} {{ @size({size}) value: {} }}\n", &text[declared.ty.clone()]);
    let mut edits = vec![(declared.ty.clone(), structure.to_owned())];
    let entry_points = module.entry_points.iter().map(|entry| &entry.function);
    for function in module.functions.iter().map(|(_, function)| function).chain(entry_points) {
        for (expression, value) in function.expressions.iter() {
            if !matches!(value, Expression::GlobalVariable(used) if *used == handle) {
                continue;
            }
            let range = function.expressions.get_span(expression).to_range()?;
            if text.get(range.clone()) != Some(name) {
                return None;
            }
            edits.push((range.end..range.end, ".value".into()));
        }
    }
    Some((edits, declaration))
}

/// A name like `name` that the text does not hold.
fn fresh(text: &str, name: &str) -> Option<String> {
    (0..100).map(|number| format!("{name}_{number}")).find(|name| !text.contains(name.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAIN: &str = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {";

    /// The names of the uniforms, with their sizes.
    fn sizes(module: &Module) -> Vec<(String, u32)> {
        let own = module.global_variables.iter().filter(|(_, global)| global.binding.is_some_and(|at| at.group == 2));
        own.map(|(_, global)| {
            (global.name.clone().unwrap_or_default(), module.types[global.ty].inner.size(module.to_ctx()))
        })
        .collect()
    }

    /// The padded text, which is valid and whose uniforms are multiples of 16 bytes; none if it cannot be padded.
    fn checked(text: &str) -> Option<String> {
        let (module, _) = locate::parse("a.wgsl", text, "").expect("the test's own text is valid");
        let names = sizes(&module);
        let odd: Vec<&str> = names.iter().filter(|(_, size)| size % 16 != 0).map(|(name, _)| name.as_str()).collect();
        assert!(!odd.is_empty(), "nothing to pad: {text}");
        let padded = padded(text, &module, &odd)?;
        let (module, _) = locate::parse("a.wgsl", &padded, "").unwrap_or_else(|error| panic!("{padded}\n{error}"));
        assert!(sizes(&module).iter().all(|(_, size)| size % 16 == 0), "{padded}");
        // Errors of a driver still name the lines of the file.
        assert_eq!(
            padded.lines().position(|line| line.contains("fn fs")),
            text.lines().position(|line| line.contains("fn fs"))
        );
        Some(padded)
    }

    #[test]
    fn structs_grow_at_their_end() {
        let text = format!(
            "struct Two {{ a: f32, /* a name: b */ b: f32 }}\nstruct One {{\n    // = 1\n    c: f32,\n}}\n\
             @group(2) @binding(0) var<uniform> two: Two;\n@group(2) @binding(1) var<uniform> one: One;\n\
             @group(2) @binding(2) var<uniform> again: One;\n\
             {MAIN} return vec4f(two.b, one.c, again.c, two.a); }}"
        );
        let padded = checked(&text).expect("it can be padded");
        assert!(padded.contains("a: f32, /* a name: b */ @size(12) b:"), "{padded}");
        assert!(padded.contains("    @size(16) c: f32,"), "{padded}");
        let twelve = format!(
            "struct Three {{ a: f32, b: f32, c: f32 }} @group(2) @binding(0) var<uniform> three: Three;\n\
             {MAIN} return vec4f(three.a, three.b, three.c, 1.0); }}"
        );
        assert!(checked(&twelve).expect("it can be padded").contains("@size(8) c"));
    }

    #[test]
    fn uniforms_without_a_struct_become_a_member_wherever_they_are_used() {
        let text = format!(
            "@group(2) @binding(0) var<uniform> share: f32;\n@group(2) @binding(1) var<uniform> tint: vec3f;\n\
             fn more(x: f32) -> f32 {{ let y = x * share; return y + share; }}\n\
             fn hidden(share: f32) -> f32 {{ return share; }}\n\
             {MAIN} let at = &tint; return vec4f(tint.x * share, (*at).yz, tint[1]) * more(hidden(tint.b)); }}"
        );
        let padded = checked(&text).expect("it can be padded");
        assert_eq!(padded.matches("share.value").count(), 3, "{padded}");
        assert!(padded.contains("hidden(share: f32) -> f32 { return share; }") && padded.contains("tint.value.x"));
    }

    #[test]
    fn a_struct_that_another_holds_stays_as_it_is() {
        let text = format!(
            "struct Inner {{ a: f32 }} struct Outer {{ inner: Inner, b: vec3f }}\n\
             @group(2) @binding(0) var<uniform> inner: Inner; @group(2) @binding(1) var<uniform> outer: Outer;\n\
             {MAIN} return vec4f(inner.a + outer.inner.a); }}"
        );
        assert_eq!(checked(&text), None);
    }
}
