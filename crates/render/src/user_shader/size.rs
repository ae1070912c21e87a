//! How large a shader of the user's becomes for the compilers of drivers, which have no bounds of their own: they put
//! functions in place of their calls, and keep variables in registers.

use super::source::Source;
use crate::diagnostic::Diagnostic;
use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{AddressSpace, Block, Function, Module, Statement};
use std::collections::HashMap;
use std::ops::Range;

/// An entry point has at most so many expressions and statements, with those of the functions that it calls in place of
/// each call. Compilers take longer than in proportion to that number; the built-in effects have a few thousand.
pub(crate) const INSTRUCTIONS_MAX: u64 = 50_000;
/// A `switch` has at most so many cases; compilers compare them one by one, and with each other.
pub(crate) const CASES_MAX: usize = 1000;
/// The variables of a shader have at most so many bytes in all. Each pixel that is drawn has its own.
pub(crate) const VARIABLE_BYTES_MAX: u64 = 16 << 10;

/// Whether a module is small enough, and its variables are.
///
/// # Errors
/// The first function or variable that is too large.
pub(crate) fn check_size(source: Source<'_>, module: &Module, info: &ModuleInfo) -> Result<(), Box<Diagnostic>> {
    check_variables(source, module)?;
    let mut sizes = Sizes { known: HashMap::new() };
    // Functions are declared before they are called, so that no call leads further than to what is known.
    for (handle, function) in module.functions.iter() {
        let size = sizes.of_function(function);
        sizes.known.insert(handle, size);
        let place = || module.functions.get_span(handle).to_range();
        check_function(source, module, (function, &info[handle]), size, place)?;
    }
    for (index, entry) in module.entry_points.iter().enumerate() {
        let size = sizes.of_function(&entry.function);
        check_function(source, module, (&entry.function, info.get_entry_point(index)), size, || None)?;
    }
    Ok(())
}

/// Counts expressions and statements.
struct Sizes {
    known: HashMap<naga::Handle<Function>, u64>,
}

impl Sizes {
    fn of_function(&self, function: &Function) -> u64 {
        self.of_block(&function.body).saturating_add(function.expressions.len() as u64)
    }

    fn of_block(&self, block: &Block) -> u64 {
        let of_statement = |statement: &Statement| match statement {
            Statement::Call { function, .. } => self.known.get(function).copied().unwrap_or(0),
            Statement::Block(block) => self.of_block(block),
            Statement::If { accept, reject, .. } => self.of_block(accept).saturating_add(self.of_block(reject)),
            Statement::Switch { cases, .. } => {
                cases.iter().fold(0, |sum: u64, case| sum.saturating_add(self.of_block(&case.body)))
            }
            Statement::Loop { body, continuing, .. } => self.of_block(body).saturating_add(self.of_block(continuing)),
            _ => 0,
        };
        block.iter().fold(0, |sum: u64, statement| sum.saturating_add(1).saturating_add(of_statement(statement)))
    }
}

fn check_function(
    source: Source<'_>,
    module: &Module,
    (function, info): (&Function, &FunctionInfo),
    size: u64,
    place: impl FnOnce() -> Option<Range<usize>>,
) -> Result<(), Box<Diagnostic>> {
    let within = |range: Option<Range<usize>>| range.filter(|range| range.end <= source.text.len()).unwrap_or(0..0);
    if let Some(span) = large_switch(&function.body) {
        return Err(switch_fault(source, within(span.to_range())));
    }
    let large = function.expressions.iter().find(|(handle, _)| {
        let inner = info[*handle].ty.inner_with(&module.types);
        u64::from(inner.size(module.to_ctx())) > VARIABLE_BYTES_MAX
    });
    if let Some((handle, _)) = large {
        let place = within(function.expressions.get_span(handle).to_range());
        return Err(too_large(source, place, "this value"));
    }
    if size > INSTRUCTIONS_MAX {
        let name = function.name.as_deref().unwrap_or_default();
        let message = format!(
            "`{name}` has more than {INSTRUCTIONS_MAX} expressions, with those of the functions that it calls in place of \
             each call"
        );
        let place = within(place());
        let fault = source.fault(place.start..place.start + place.len().min(2), message);
        return Err(Box::new(
            fault.note("compilers put functions in place of their calls; a loop keeps a shader short"),
        ));
    }
    Ok(())
}

/// The fault of a `switch` of too many cases. All of its lines would hide the message.
pub(super) fn switch_fault(source: Source<'_>, place: Range<usize>) -> Box<Diagnostic> {
    let message = format!("a `switch` has at most {CASES_MAX} cases");
    source.fault(place.start..place.start + place.len().min("switch".len()), message)
}

/// The first `switch` of too many cases.
fn large_switch(block: &Block) -> Option<naga::Span> {
    block.span_iter().find_map(|(statement, span)| match statement {
        Statement::Switch { cases, .. } if cases.len() > CASES_MAX => Some(*span),
        Statement::Switch { cases, .. } => cases.iter().find_map(|case| large_switch(&case.body)),
        Statement::Block(block) => large_switch(block),
        Statement::If { accept, reject, .. } => large_switch(accept).or_else(|| large_switch(reject)),
        Statement::Loop { body, continuing, .. } => large_switch(body).or_else(|| large_switch(continuing)),
        _ => None,
    })
}

/// Adds the variables up, in the order of the text as far as that is known.
fn check_variables(source: Source<'_>, module: &Module) -> Result<(), Box<Diagnostic>> {
    let size = |ty: naga::Handle<naga::Type>| u64::from(module.types[ty].inner.size(module.to_ctx()));
    let privates = module.global_variables.iter().filter(|(_, global)| global.space == AddressSpace::Private);
    let privates = privates.map(|(handle, global)| {
        (global.name.clone(), size(global.ty), module.global_variables.get_span(handle).to_range())
    });
    let functions = module.functions.iter().map(|(_, function)| function);
    let locals = functions.chain(module.entry_points.iter().map(|entry| &entry.function));
    let locals = locals.flat_map(|function| function.local_variables.iter().map(move |of| (function, of)));
    let locals = locals.map(|(function, (handle, variable))| {
        (variable.name.clone(), size(variable.ty), function.local_variables.get_span(handle).to_range())
    });
    let mut bytes = 0u64;
    for (name, size, place) in privates.chain(locals) {
        bytes = bytes.saturating_add(size);
        if bytes > VARIABLE_BYTES_MAX {
            let place = place.filter(|range| range.end <= source.text.len()).unwrap_or(0..0);
            let name = name.map_or("a variable".into(), |name| format!("`{name}`"));
            return Err(too_large(source, place, &name));
        }
    }
    Ok(())
}

fn too_large(source: Source<'_>, place: Range<usize>, what: &str) -> Box<Diagnostic> {
    let most = VARIABLE_BYTES_MAX >> 10;
    let message = format!("{what} makes the variables of this shader larger than {most} KiB");
    let note = "each pixel that is drawn has its own; large tables belong into a uniform, or into a `.cube` file";
    Box::new(source.fault(place, message).note(note))
}
