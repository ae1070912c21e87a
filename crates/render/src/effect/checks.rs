//! What is asked of an effect's text beside that it is WGSL.

use super::declarations::{BorrowedTexture, FIRST_TEXTURE, declarations, texture_declaration};
use super::fused::PIXEL_ENTRY;
use super::header::{Header, READS};
use super::steps::{self, Step};
use crate::diagnostic::Diagnostic;
use crate::shader::frame_group::OWN_TEXTURES_MAX;
use crate::shader::locate;
use crate::shader::program::Slot;
use crate::user_shader::Source;
use crate::user_shader::checks::check_functions;
use crate::user_shader::scan::Scan;
use crate::user_shader::uniforms::OWN_GROUP;
use std::ops::Range;

/// Whether the function that a header names changes a pixel and looks at no other.
pub(super) fn check_pixel(
    source: Source<'_>,
    scan: &Scan,
    header: &Header,
    (name, place): &(String, Range<usize>),
    (module, info): (&naga::Module, &naga::valid::ModuleInfo),
) -> Result<(), Box<Diagnostic>> {
    if !header.steps.is_empty() || !module.entry_points.is_empty() {
        let message = "an effect of `//! pixel:` has neither `//! passes:` nor `@fragment` functions";
        return Err(source.fault(place.clone(), message));
    }
    let found = module.functions.iter().find(|(_, function)| function.name.as_deref() == Some(name));
    let Some((handle, function)) = found else {
        return Err(source.fault(place.clone(), format!("there is no function `{name}`")));
    };
    let declared = scan.functions.get(name).cloned().unwrap_or_else(|| place.clone());
    let vector = |size| naga::TypeInner::Vector { size, scalar: naga::Scalar::F32 };
    let (vec2f, vec4f) = (vector(naga::VectorSize::Bi), vector(naga::VectorSize::Quad));
    let arguments: Vec<_> = function.arguments.iter().map(|argument| &module.types[argument.ty].inner).collect();
    let result = function.result.as_ref().map(|result| &module.types[result.ty].inner);
    if arguments != [&vec4f, &vec2f] || result != Some(&vec4f) {
        let message = format!("`{name}` is not a pixel function");
        let note = format!("write `fn {name}(color: vec4f, position: vec2f) -> vec4f`");
        return Err(Box::new(source.fault(declared, message).note(note)));
    }
    if let Some(place) = discarded(module, function).and_then(|span| span.to_range()) {
        let place = if place.start < source.text.len() { place } else { declared };
        let message = format!("`{name}` changes a pixel, and `discard` would drop the results of other effects, too");
        let note = "give back `color` as it is, or a coverage of 0: `vec4f(0.0)`";
        return Err(Box::new(source.fault(place, message).note(note)));
    }
    let is_used = |texture: &str| {
        let global = module.global_variables.iter().find(|(_, global)| global.name.as_deref() == Some(texture));
        global.is_some_and(|(global, _)| !info[handle][global].is_empty())
    };
    if let Some(texture) = ["radiance", "display", "previous"].into_iter().find(|texture| is_used(texture)) {
        let message = format!("`{name}` reads `{texture}`, but a function of a pixel is given its colour");
        let note = "what looks at other pixels is a `@fragment` function of its own";
        return Err(Box::new(source.fault(declared, message).note(note)));
    }
    Ok(())
}

/// The first `discard` of a function, or of one that it calls. Each function is looked at once, however often it is called.
fn discarded(module: &naga::Module, function: &naga::Function) -> Option<naga::Span> {
    type VisitedFunctions = std::collections::HashSet<naga::Handle<naga::Function>>;
    fn of_block(module: &naga::Module, block: &naga::Block, looked: &mut VisitedFunctions) -> Option<naga::Span> {
        use naga::Statement;
        block.span_iter().find_map(|(statement, span)| match statement {
            Statement::Kill => Some(*span),
            Statement::Call { function, .. } if looked.insert(*function) => {
                of_block(module, &module.functions[*function].body, looked)
            }
            Statement::Block(block) => of_block(module, block, looked),
            Statement::If { accept, reject, .. } => {
                of_block(module, accept, looked).or_else(|| of_block(module, reject, looked))
            }
            Statement::Switch { cases, .. } => cases.iter().find_map(|case| of_block(module, &case.body, looked)),
            Statement::Loop { body, continuing, .. } => {
                of_block(module, body, looked).or_else(|| of_block(module, continuing, looked))
            }
            _ => None,
        })
    }
    of_block(module, &function.body, &mut VisitedFunctions::new())
}

/// The names of the textures in groups, if those are there.
fn textures_of(groups: Option<&[Vec<Slot>]>) -> Vec<&str> {
    let is_texture = |slot: &&Slot| matches!(slot.entry.ty, wgpu::BindingType::Texture { .. });
    groups.into_iter().flatten().flatten().filter(is_texture).map(|slot| slot.name.as_str()).collect()
}

/// Whether each pass reads what is there, and no more than every adapter can bind.
pub(super) fn check_textures(
    source: Source<'_>,
    scan: &Scan,
    steps: &[(Step, Vec<Vec<Slot>>)],
) -> Result<(), Box<Diagnostic>> {
    let mut read = Vec::with_capacity(steps.len());
    for (step, slots) in steps {
        // Tables lie in the groups after that of what is read.
        let bound = textures_of(slots.get(1..)).len();
        if bound > OWN_TEXTURES_MAX {
            let place = scan.functions.get(&step.function).cloned().unwrap_or(0..0);
            let message =
                format!("`{}` reads {bound} textures; a pass reads at most {OWN_TEXTURES_MAX}", step.function);
            return Err(source.fault(place, message));
        }
        read.push((step, textures_of(slots.get(1..2))));
    }
    steps::check(source, &read)
}

/// Whether the names that a header gives to textures are free: neither the file's own, nor those by which a header calls
/// what is read.
pub(super) fn check_names(source: Source<'_>, scan: &Scan, header: &Header) -> Result<(), Box<Diagnostic>> {
    let is_taken = |texture: &str| {
        READS.iter().any(|(name, _)| *name == texture)
            || scan.functions.contains_key(texture)
            || scan.variables.contains_key(texture)
            || scan.members.keys().any(|(structure, _)| structure == texture)
    };
    let taken = header.steps.iter().find(|step| step.texture.as_deref().is_some_and(is_taken));
    if let Some(step) = taken {
        return Err(taken_name(source, step));
    }
    let is_own = |name: &str| {
        scan.functions.contains_key(name)
            || scan.variables.contains_key(name)
            || header.steps.iter().any(|step| step.texture.as_deref() == Some(name))
    };
    if let Some(borrowed) = header.borrowed().into_iter().find(|borrowed| is_own(&borrowed.variable)) {
        let BorrowedTexture { key, variable, .. } = borrowed;
        let message = format!("`{key}` is called `{variable}` in the shader, which is declared already");
        return Err(source.fault(header.place_of_reads(), message));
    }
    match scan.functions.get(PIXEL_ENTRY).filter(|_| header.pixel.is_some()) {
        Some(place) => Err(source.fault(place.clone(), format!("`//! pixel:` declares `{PIXEL_ENTRY}` itself"))),
        None => Ok(()),
    }
}

/// The fault of a file that is no WGSL with what its header declares: one of its textures, if that by itself is none
/// beside what effects find declared.
pub(super) fn fault_of_names(source: Source<'_>, header: &Header, fault: Box<Diagnostic>) -> Box<Diagnostic> {
    let is_fault = |step: &&Step| {
        let Some(texture) = &step.texture else { return false };
        let alone = format!("{}{}", texture_declaration(FIRST_TEXTURE, texture), declarations(true, true, &[], &[]),);
        locate::parse(source.file, &alone, "").is_err()
    };
    header.steps.iter().find(is_fault).map_or_else(|| with_types(with_words(fault)), |step| taken_name(source, step))
}

fn taken_name(source: Source<'_>, step: &Step) -> Box<Diagnostic> {
    let texture = step.texture.as_deref().unwrap_or_default();
    let fault = source.fault(step.place.clone(), format!("a texture cannot be called `{texture}`"));
    Box::new(fault.note("it is a word of WGSL, or something of that name is declared already"))
}

/// The fault of a file that gives back something else than colours, with what they are.
fn with_types(fault: Box<Diagnostic>) -> Box<Diagnostic> {
    if !fault.message.contains("does not match the declared return type") {
        return fault;
    }
    Box::new(fault.note("a pass gives back colour and coverage: of a `vec3f`, `vec4f(color, 1.0)`"))
}

/// The fault of a file that uses what only words of its header declare, with these words.
fn with_words(fault: Box<Diagnostic>) -> Box<Diagnostic> {
    let is_unknown =
        |name: &str| fault.message.contains("no definition in scope") && fault.message.contains(&format!("`{name}`"));
    let note = if ["display", "display_at"].into_iter().any(is_unknown) {
        "`//! reads: display` in the header declares it"
    } else if ["drawn", "uv_at"].into_iter().any(is_unknown) {
        "`//! reads: display` in the header declares it, and so does a list of several `//! passes:`"
    } else if ["occlusion", "motion", "ids"].into_iter().any(is_unknown) {
        "`//! reads: occlusion` (or `motion`, or `ids`) in the header declares it"
    } else {
        return fault;
    };
    Box::new(fault.note(note))
}

/// Whether the module's entry points are fragment shaders from a position to a colour.
pub(super) fn check_module(
    source: Source<'_>,
    scan: &Scan,
    module: &naga::Module,
    info: &naga::valid::ModuleInfo,
) -> Result<(), Box<Diagnostic>> {
    for entry in &module.entry_points {
        check_entry_point(source, scan, module, entry)?;
    }
    check_functions(source, module, info)
}

fn check_entry_point(
    source: Source<'_>,
    scan: &Scan,
    module: &naga::Module,
    entry: &naga::EntryPoint,
) -> Result<(), Box<Diagnostic>> {
    use naga::{Binding, BuiltIn};
    let fault = |message: String| source.fault(scan.functions.get(&entry.name).cloned().unwrap_or(0..0), message);
    if entry.stage != naga::ShaderStage::Fragment {
        return Err(fault(format!("the entry point `{}` is not a `@fragment` function", entry.name)));
    }
    let is_position = |argument: &naga::FunctionArgument| {
        matches!(argument.binding, Some(Binding::BuiltIn(BuiltIn::Position { .. })))
    };
    if !entry.function.arguments.iter().all(is_position) {
        return Err(fault(format!("`{}` takes nothing but `@builtin(position) position: vec4f`", entry.name)));
    }
    let vec4f = naga::TypeInner::Vector { size: naga::VectorSize::Quad, scalar: naga::Scalar::F32 };
    let is_color = entry.function.result.as_ref().is_some_and(|result| {
        matches!(result.binding, Some(Binding::Location { location: 0, .. })) && module.types[result.ty].inner == vec4f
    });
    if !is_color {
        let message = format!("`{}` has to return `@location(0) vec4f`: colour, and coverage as alpha", entry.name);
        return Err(fault(message));
    }
    Ok(())
}

/// Whether what the shader itself declares are uniforms in group 2, and filtering is used where formats allow it.
pub(super) fn check_slots(source: Source<'_>, scan: &Scan, groups: &[Vec<Slot>]) -> Result<(), Box<Diagnostic>> {
    for (group, slots) in groups.iter().enumerate() {
        for slot in slots {
            let name = &slot.name;
            let is_uniform = matches!(slot.entry.ty, wgpu::BindingType::Buffer { .. });
            let own = scan.variables.get(name.as_str());
            if let Some(declared) = own.filter(|_| !(is_uniform && group == OWN_GROUP as usize)) {
                let message = format!("`{name}` in group {group}: an effect's own bindings are uniforms in group 2");
                let fault = source.fault(declared.name.clone(), message);
                return Err(Box::new(if is_uniform {
                    fault.note(format!(
                        "groups 0 and 1 are the frame's; write `@group(2) @binding(0) var<uniform> {name}: …`"
                    ))
                } else {
                    let note = "textures and samplers of the frame are declared already, by names such as `radiance`, `normal`, \
                                `linear_depth` and `linear_clamp`";
                    fault.note(note).note("an effect's own textures are only look-up tables, which are `.cube` files")
                }));
            }
            let is_filtered = matches!(
                slot.entry.ty,
                wgpu::BindingType::Texture { sample_type: wgpu::TextureSampleType::Float { filterable: true }, .. }
            );
            if is_filtered && matches!(name.as_str(), "linear_depth" | "motion") {
                let is_code = |at: &usize| !scan.comments.iter().any(|comment| comment.range.contains(at));
                let at = source.text.match_indices(name.as_str()).map(|(at, _)| at).find(is_code).unwrap_or(0);
                let function = if name == "motion" { "textureLoad" } else { "distance_at(pixel)" };
                let message = format!("`{name}` cannot be filtered; use `{function}` or `nearest_clamp`");
                return Err(source.fault(at..at + name.len(), message));
            }
        }
    }
    Ok(())
}
