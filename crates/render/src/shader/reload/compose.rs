//! Composes modules with WESL.

use super::constants;
use super::programs::ProgramDeclaration;
use std::path::Path;
use wesl::{CompileOptions, CompileResult, FileResolver, ManglerKind, Router, VirtualResolver, Wesl};

/// The declarations of a program's variant, each with the end of its last line. With a blank line between them they are
/// the module's text.
///
/// # Errors
/// What WESL says of a shader.
pub fn module(source: &Path, program: &ProgramDeclaration, variant: usize) -> Result<Vec<String>, String> {
    let ProgramDeclaration { module, axes, features, .. } = program;
    let mut wesl = composer(source, true, |_| true);
    for (bit, axis) in axes.iter().enumerate() {
        wesl.set_feature(axis, variant >> bit & 1 == 1);
    }
    for feature in features {
        wesl.set_feature(feature, true);
    }
    // An axis that a module does not list is off.
    wesl.set_missing_feature_behavior(false);
    wesl.keep_all_entrypoints();
    let path = module.parse().map_err(|error| format!("{module}: {error}"))?;
    wesl.compile(&path).map_err(|error| error.to_string()).and_then(|result| declarations(&result))
}

/// Sorted, because WESL orders modules by chance: every build gives the same texts, which caches of drivers know.
fn declarations(result: &CompileResult) -> Result<Vec<String>, String> {
    let declarations = result.syntax.global_declarations.iter().map(|declaration| format!("{declaration}\n"));
    // A semicolon between others is one, too.
    let mut declarations: Vec<String> = declarations.filter(|text| text != ";\n").collect();
    if declarations.join("\n") != result.to_string() {
        return Err(format!("directives are not supported:\n{result}"));
    }
    declarations.sort();
    Ok(declarations)
}

/// Every declaration of the modules that `prelude.wgsl` imports, used or not; of constants only those which they need,
/// because every name is one that effects cannot give.
///
/// # Errors
/// What WESL says of a shader.
pub fn prelude(source: &Path) -> Result<String, String> {
    let path = "package::effect::prelude".parse().map_err(|error| format!("{error}"))?;
    let is_wanted = |name: &str| name.starts_with("SRGB_") || ["DISTANCE_BACKGROUND_M", "RADIANCE_MAX"].contains(&name);
    let wesl = composer(source, false, is_wanted);
    let result = wesl.compile(&path).map_err(|error| error.to_string())?;
    declarations(&result).map(|declarations| declarations.join("\n"))
}

/// Finds modules in the folder `source`, and the constants that are `wanted` in `package::constants`.
fn composer(source: &Path, strip: bool, wanted: impl Fn(&str) -> bool) -> Wesl<Router> {
    let mut virtual_modules = VirtualResolver::new();
    virtual_modules.add_module("package".parse().expect("a path"), constants::as_wgsl(wanted).into());
    let mut router = Router::new();
    router.mount_resolver("package::constants".parse().expect("a path"), virtual_modules);
    router.mount_fallback_resolver(FileResolver::new(source));
    let mut wesl = Wesl::new(source).set_custom_resolver(router);
    wesl.set_mangler(ManglerKind::None);
    wesl.set_options(CompileOptions { strip, imports: true, condcomp: true, lower: false, ..Default::default() });
    wesl
}
