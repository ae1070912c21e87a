//! The variants of every built-in module, composed by `build.rs` with WESL.

use super::program::Constant;

include!(concat!(env!("OUT_DIR"), "/programs.rs"));

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
pub fn source(program: &str, axes_on: &[&str]) -> Result<&'static str, String> {
    let (_, axes, variants) =
        PROGRAMS.iter().find(|(name, ..)| *name == program).ok_or_else(|| format!("no program `{program}`"))?;
    let mut index = 0;
    for axis in axes_on {
        let bit = axes
            .iter()
            .position(|known| known == axis)
            .ok_or_else(|| format!("program `{program}` has no axis `{axis}`"))?;
        index |= 1usize << bit;
    }
    variants.get(index).copied().ok_or_else(|| format!("program `{program}` has no variant {index}"))
}

/// The program that draws points where `program` draws triangles, if there is one.
pub fn points_of(program: &str) -> Option<&'static str> {
    PROGRAMS.iter().map(|(name, ..)| *name).find(|name| name.strip_suffix("_points") == Some(program))
}

/// The program that draws materials with layers where `program` draws others, if there is one.
pub fn layered_of(program: &str) -> Option<&'static str> {
    PROGRAMS.iter().map(|(name, ..)| *name).find(|name| name.strip_suffix("_layered") == Some(program))
}

/// The program that draws materials with maps over others, or with baked light, where `program` draws others, if there
/// is one.
pub fn detailed_of(program: &str) -> Option<&'static str> {
    PROGRAMS.iter().map(|(name, ..)| *name).find(|name| name.strip_suffix("_detailed") == Some(program))
}

/// The program that draws materials with relief where `program` draws others, if there is one.
pub fn relief_of(program: &str) -> Option<&'static str> {
    PROGRAMS.iter().map(|(name, ..)| *name).find(|name| name.strip_suffix("_relief") == Some(program))
}

/// Whether a program has variants with and without `axis`.
pub fn has_axis(program: &str, axis: &str) -> bool {
    PROGRAMS.iter().any(|(name, axes, _)| *name == program && axes.contains(&axis))
}

/// Whether a program, or one that draws other surfaces in its place, declares the `override` constant `constant`.
pub fn has_constant_somewhere(program: &str, constant: &str) -> bool {
    let mut others = [points_of, layered_of, detailed_of, relief_of].into_iter().filter_map(|of| of(program));
    has_constant(program, constant) || others.any(|other| has_constant(other, constant))
}

/// Whether any variant of a program declares the `override` constant `constant`.
pub fn has_constant(program: &str, constant: &str) -> bool {
    CONSTANTS.iter().any(|(name, declared)| *name == program && declared.contains(&constant))
}
