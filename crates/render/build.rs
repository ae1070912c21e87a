//! Composes every variant of every program with WESL, and keeps each of their declarations once.
//!
//! It reads shaders alone. Cargo runs it after a change in a folder that has some, because it looks at all files of a
//! folder that it is told of, and new ones must be found. The script does something only if a shader, a constant or the
//! script itself is another than the last time: else it takes some milliseconds.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::{env, fmt::Write as _, fs, path::Path};

#[path = "src/shader/reload/compose.rs"]
mod compose;
#[path = "src/constants.rs"]
mod constants;
#[path = "build/declarations.rs"]
mod declarations;
#[path = "src/shader/reload/programs.rs"]
mod programs;

fn main() {
    let source = Path::new("src");
    // A folder of shaders that is new is a module of the crate, which `lib.rs` declares.
    for path in ["build.rs", "build", "src/constants.rs", "src/lib.rs", "src/shader/reload"] {
        println!("cargo::rerun-if-changed={path}");
    }
    for path in programs::watched(source) {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    let out = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    let out = Path::new(&out);
    let (stamp, inputs) = (out.join("inputs"), inputs(source));
    if fs::read_to_string(&stamp).is_ok_and(|last| last == inputs) {
        return;
    }
    // What ends early leaves no stamp of other output behind.
    let _ = fs::remove_file(&stamp);
    fs::write(out.join("programs.rs"), list(source)).expect("the output folder is writable");
    fs::write(stamp, inputs).expect("the output folder is writable");
}

/// A number of all that the output depends on: the shaders, and this program, which has the constants in it.
fn inputs(source: &Path) -> String {
    let mut hasher = DefaultHasher::new();
    let program = env::current_exe().and_then(|program| program.metadata()?.modified());
    program.expect("this program is a file").hash(&mut hasher);
    for shader in programs::shaders(source) {
        shader.hash(&mut hasher);
    }
    format!("{:016x}", hasher.finish())
}

/// The programs as Rust: their declarations, each once, and which of them each variant has.
fn list(source: &Path) -> String {
    let mut declarations = declarations::Table::default();
    let mut list = String::from("/// Every program, by name.\npub static PROGRAMS: &[BuiltIn] = &[\n");
    for program in programs::declared(source) {
        let programs::ProgramDeclaration { name, axes, .. } = &program;
        let modules = (0..1 << axes.len()).map(|variant| {
            compose::module(source, &program, variant)
                .unwrap_or_else(|error| panic!("{name}, variant {variant}:\n{error}"))
        });
        let modules: Vec<Vec<String>> = modules.collect();
        let constants = Vec::from_iter(declarations::constants(&modules));
        let _ =
            writeln!(list, "    BuiltIn {{ name: {name:?}, axes: &{axes:?}, constants: &{constants:?}, variants: &[");
        for module in modules {
            let _ = writeln!(list, "        &{:?},", declarations.indices(module));
        }
        list.push_str("    ] },\n");
    }
    let _ = writeln!(list, "];\n\n/// What programs declare, each text once.\nstatic DECLARATIONS: &[&str] = &[");
    for text in declarations.texts() {
        let _ = writeln!(list, "    {text:?},");
    }
    let prelude = compose::prelude(source).unwrap_or_else(|error| panic!("prelude of effects:\n{error}"));
    let _ = writeln!(list, "];\n\n/// What effects find declared.\npub const EFFECT_PRELUDE: &str = {prelude:?};");
    list
}
