//! The built-in programs, composed by `build.rs` with WESL. A variant is a list of declarations, each of which is kept
//! once for all programs. It becomes a text when its module is made.

use super::program::Constant;

/// A program that is built in.
#[derive(Debug)]
pub struct BuiltIn {
    /// Its name; no other has it.
    pub name: &'static str,
    /// A variant's index has bit `i` set if axis `i` is on.
    pub axes: &'static [&'static str],
    /// The `override` constants that any of its variants declares.
    pub constants: &'static [&'static str],
    /// The places in [`DECLARATIONS`] of what each variant declares.
    variants: &'static [&'static [u16]],
}

include!(concat!(env!("OUT_DIR"), "/programs.rs"));

impl BuiltIn {
    /// The WGSL of each variant: two for each axis.
    pub fn modules(&self) -> impl DoubleEndedIterator<Item = String> + ExactSizeIterator {
        self.variants.iter().map(|indices| text(indices))
    }
}

/// The declarations with these places, with a blank line between them.
fn text(indices: &[u16]) -> String {
    let declarations = indices.iter().filter_map(|index| DECLARATIONS.get(usize::from(*index)).copied());
    declarations.collect::<Vec<_>>().join("\n")
}

/// What the texts of all programs take in the library.
pub fn embedded_bytes() -> usize {
    let indices: usize =
        PROGRAMS.iter().flat_map(|program| program.variants).map(|indices| size_of_val(*indices)).sum();
    DECLARATIONS.iter().map(|text| text.len() + size_of::<&str>()).sum::<usize>() + indices
}

fn named(program: &str) -> Option<&'static BuiltIn> {
    PROGRAMS.iter().find(|known| known.name == program)
}

/// The program whose name is that of `program` and this ending, if there is one.
fn with_ending(program: &str, ending: &str) -> Option<&'static str> {
    PROGRAMS.iter().map(|known| known.name).find(|name| name.strip_suffix(ending) == Some(program))
}

/// Tells apart what `axes` are for a program: its axes, and names of its `override` constants, which are 1 then.
pub(crate) fn axes_and_constants(program: &str, axes: &[&'static str]) -> (Vec<&'static str>, Vec<Constant>) {
    let (constants, axes): (Vec<&str>, Vec<&str>) =
        axes.iter().copied().partition(|axis| !has_axis(program, axis) && has_constant(program, axis));
    (axes, constants.into_iter().map(|constant| (constant, 1)).collect())
}

/// The WGSL of a program with the given axes on.
///
/// # Errors
/// The name of the program or axis that does not exist.
pub fn source(program: &str, axes_on: &[&str]) -> Result<String, String> {
    let BuiltIn { axes, variants, .. } = named(program).ok_or_else(|| format!("no program `{program}`"))?;
    let mut index = 0;
    for axis in axes_on {
        let bit = axes
            .iter()
            .position(|known| known == axis)
            .ok_or_else(|| format!("program `{program}` has no axis `{axis}`"))?;
        index |= 1usize << bit;
    }
    let indices = variants.get(index).ok_or_else(|| format!("program `{program}` has no variant {index}"))?;
    reloaded(program, index).unwrap_or_else(|| Ok(text(indices)))
}

/// A program's variant as the sources are now.
#[cfg(all(feature = "reload", debug_assertions, not(target_arch = "wasm32")))]
fn reloaded(program: &str, variant: usize) -> Option<Result<String, String>> {
    Some(super::reload::module(program, variant))
}

/// Nothing: programs are those of the build.
#[cfg(not(all(feature = "reload", debug_assertions, not(target_arch = "wasm32"))))]
const fn reloaded(_: &str, _: usize) -> Option<Result<String, String>> {
    None
}

/// The program that draws points where `program` draws triangles, if there is one.
pub fn points_of(program: &str) -> Option<&'static str> {
    with_ending(program, "_points")
}

/// The program that draws materials with layers where `program` draws others, if there is one.
pub fn layered_of(program: &str) -> Option<&'static str> {
    with_ending(program, "_layered")
}

/// The program that draws materials with maps over others, or with baked light, where `program` draws others, if there
/// is one.
pub fn detailed_of(program: &str) -> Option<&'static str> {
    with_ending(program, "_detailed")
}

/// The program that draws materials with relief where `program` draws others, if there is one.
pub fn relief_of(program: &str) -> Option<&'static str> {
    with_ending(program, "_relief")
}

/// Whether a program has variants with and without `axis`.
pub fn has_axis(program: &str, axis: &str) -> bool {
    named(program).is_some_and(|program| program.axes.contains(&axis))
}

/// Whether a program, or one that draws other surfaces in its place, declares the `override` constant `constant`.
pub fn has_constant_somewhere(program: &str, constant: &str) -> bool {
    let mut others = [points_of, layered_of, detailed_of, relief_of].into_iter().filter_map(|of| of(program));
    has_constant(program, constant) || others.any(|other| has_constant(other, constant))
}

/// Whether any variant of a program declares the `override` constant `constant`.
pub fn has_constant(program: &str, constant: &str) -> bool {
    named(program).is_some_and(|program| program.constants.contains(&constant))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_declaration_is_kept_once_and_used() {
        let used: BTreeSet<u16> =
            PROGRAMS.iter().flat_map(|program| program.variants).flat_map(|indices| indices.iter().copied()).collect();
        assert!(used.into_iter().map(usize::from).eq(0..DECLARATIONS.len()));
        assert_eq!(DECLARATIONS.iter().collect::<BTreeSet<_>>().len(), DECLARATIONS.len());
    }

    #[test]
    fn a_variant_is_its_declarations_with_blank_lines_between_them() {
        let text = source("meter", &[]).unwrap();
        assert!(text.ends_with("}\n") && !text.contains("\n\n\n"), "{text}");
        let parts = text.trim_end().split("\n\n").count();
        assert_eq!(named("meter").unwrap().variants[0].len(), parts);
        assert!(source("meter", &["textures"]).unwrap_err().contains("no axis `textures`"));
        assert!(source("none", &[]).unwrap_err().contains("no program `none`"));
        assert_ne!(source("geometry", &["textures"]).unwrap(), source("geometry", &[]).unwrap());
    }
}
