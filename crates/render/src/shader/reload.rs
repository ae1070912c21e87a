//! Modules of programs as the sources are now: a changed shader needs no build. `build.rs` has the same `compose` and
//! `programs`.
//!
//! Names of programs, axes and constants stay those of the build.

use crate::constants;
use std::path::Path;

#[allow(dead_code, reason = "the prelude of effects stays that of the build")]
mod compose;
#[allow(dead_code, reason = "the build script watches shaders, too")]
mod programs;

/// The sources that the library was built from.
const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src");

/// The WGSL of a program's variant.
///
/// # Errors
/// The sources are not there, lack the program, or are refused by WESL.
pub(super) fn module(program: &str, variant: usize) -> Result<String, String> {
    let source = Path::new(SOURCE);
    if !source.is_dir() {
        return Err(format!("{SOURCE} is not there, from which the feature `reload` composes shaders"));
    }
    let declared = programs::declared(source).into_iter().find(|declared| declared.name == program);
    let declared = declared.ok_or_else(|| format!("no program `{program}` in {SOURCE}"))?;
    compose::module(source, &declared, variant).map(|declarations| declarations.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::super::compose::PROGRAMS;
    use super::*;

    #[test]
    fn what_the_sources_give_is_what_was_built() {
        for program in PROGRAMS.iter().filter(|program| ["meter", "geometry"].contains(&program.name)) {
            for (variant, text) in program.modules().enumerate() {
                assert_eq!(module(program.name, variant).as_ref(), Ok(&text), "{}", program.name);
            }
        }
        assert!(module("none", 0).unwrap_err().contains("no program `none`"));
    }
}
