//! What is asked of every shader of the user's.

use super::loops::Loops;
use super::scan::{Declaration, Scan};
use super::size::check_size;
use super::source::Source;
use crate::diagnostic::Diagnostic;

/// Whether every loop of a module can end, all that it declares is there, and compilers can bear its size.
pub(crate) fn check_functions(
    source: Source<'_>,
    module: &naga::Module,
    info: &naga::valid::ModuleInfo,
) -> Result<(), Box<Diagnostic>> {
    use naga::AddressSpace;
    let functions = module.functions.iter().map(|(_, function)| function);
    for function in functions.chain(module.entry_points.iter().map(|entry| &entry.function)) {
        if let Some(span) = (Loops { module, function }).endless() {
            let start = span.to_range().map_or(0, |range| range.start);
            // `loop`, `while` or `for`.
            let word = source.text.get(start..).and_then(|rest| rest.find(|letter: char| !letter.is_alphabetic()));
            let message = "this loop never ends: it has no `break` or `return` that is ever reached";
            return Err(source.fault(start..start + word.unwrap_or(0), message));
        }
    }
    if let Some((handle, _)) = module.overrides.iter().find(|(_, constant)| constant.init.is_none()) {
        let place = module.overrides.get_span(handle).to_range().unwrap_or(0..0);
        return Err(source.fault(place, "an `override` without a value gets none; use a uniform"));
    }
    for (handle, global) in module.global_variables.iter() {
        let is_good = matches!(global.space, AddressSpace::Private | AddressSpace::Uniform | AddressSpace::Handle);
        if !is_good {
            let place = module.global_variables.get_span(handle).to_range().unwrap_or(0..0);
            let name = global.name.as_deref().unwrap_or_default();
            return Err(source.fault(place, format!("`{name}` is neither a uniform nor a texture nor a sampler")));
        }
    }
    check_size(source, module, info)
}

/// The member of a struct that is a `bool`, if a uniform that holds such a thing is what is wrong.
pub(crate) fn fault_of_bool(source: Source<'_>, scan: &Scan, fault: Box<Diagnostic>) -> Box<Diagnostic> {
    let is_bool = |declared: &&Declaration| source.text.get(declared.ty.clone()).map(str::trim) == Some("bool");
    let members = scan.members.values().chain(scan.variables.values()).filter(is_bool);
    let first = members.min_by_key(|declared| declared.ty.start).filter(|_| fault.message.contains("host-shareable"));
    let Some(declared) = first else { return fault };
    let name = source.text.get(declared.name.clone()).unwrap_or_default();
    let message = format!("`{name}` is a `bool`, and uniforms hold numbers alone");
    let note = format!("write `{name}: u32` with `// = 1 in 0..1` above it, and `{name} != 0u` where it is asked");
    Box::new(source.fault(declared.ty.clone(), message).note(note))
}
