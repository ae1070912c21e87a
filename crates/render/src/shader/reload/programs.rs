//! The programs of the renderer, as its shaders declare them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// How the line begins by which a shader says that it is a program.
const PROGRAM: &str = "// Program: ";

/// After the name: there is a second program, for points.
const FOR_POINTS: &str = ", also for points";

/// After the name, and after [`FOR_POINTS`]: there is one more program, for materials with layers.
const WITH_LAYERS: &str = ", also with layers";

/// After these: there is one more program, for materials with maps over others, or with baked light.
const WITH_DETAIL: &str = ", also with detail";

/// After these: there is one more program, for materials with relief. It has the layers of the program, if that has
/// any.
const WITH_RELIEF: &str = ", also with relief";

/// After the name, and after all of these: features that are on in all variants.
const FEATURES: &str = ". Features: ";

/// After the features: the axes.
const AXES: &str = ". Axes: ";

/// The axis of what binds less where nothing is deformed. Only special materials are worth it, whose textures fill what
/// a stage has on WebGL 2; in all other programs it is on.
const SKINS: &str = "skins";

/// What is bound by programs for special materials, and by those for points, in any case: these are rare.
const TEXTURES: [&str; 2] = ["textures", "masks"];

/// A program.
#[derive(Debug)]
pub struct ProgramDeclaration {
    /// Its name; no other has it.
    pub name: String,
    /// Its WESL module, such as `package::passes::ids::ids`.
    pub module: String,
    /// A variant's index has bit `i` set if axis `i` is on.
    pub axes: Vec<String>,
    /// Features that are on in all of its variants.
    pub features: Vec<String>,
}

/// The programs of all shaders in `source`, by name. A shader is one if its first comment has a line such as one of
/// these:
///
/// ```wgsl
/// // Program: meter.
/// // Program: direct. Axes: tiled.
/// // Program: debug_surfaces, also for points. Features: textures.
/// // Program: forward, also for points, also with layers, also with relief. Axes: textures, skins.
/// ```
pub fn declared(source: &Path) -> Vec<ProgramDeclaration> {
    let mut programs = BTreeMap::new();
    find(source, "package", &mut |module, text| {
        let comment = text.lines().take_while(|line| line.starts_with("//"));
        for line in comment.filter_map(|line| line.strip_prefix(PROGRAM)) {
            for program in read(module, line).unwrap_or_else(|| panic!("{module}: `{PROGRAM}{line}` is not understood"))
            {
                let name = program.name.clone();
                assert!(programs.insert(name.clone(), program).is_none(), "{module}: another program is called {name}");
            }
        }
    });
    programs.into_values().collect()
}

/// The programs that `line` declares, without [`PROGRAM`].
fn read(module: &str, line: &str) -> Option<Vec<ProgramDeclaration>> {
    let list = |words: &str| words.split(", ").map(str::to_owned).collect::<Vec<String>>();
    let line = line.strip_suffix('.')?;
    let (line, axes) = line.split_once(AXES).map_or((line, Vec::new()), |(line, axes)| (line, list(axes)));
    let (name, common) = line.split_once(FEATURES).map_or((line, Vec::new()), |(line, common)| (line, list(common)));
    let is_word = |word: &str| {
        !word.is_empty() && word.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_')
    };
    let (name, with_relief) = name.strip_suffix(WITH_RELIEF).map_or((name, false), |name| (name, true));
    let (name, with_detail) = name.strip_suffix(WITH_DETAIL).map_or((name, false), |name| (name, true));
    let (name, with_layers) = name.strip_suffix(WITH_LAYERS).map_or((name, false), |name| (name, true));
    let (name, for_points) = name.strip_suffix(FOR_POINTS).map_or((name, false), |name| (name, true));
    if !is_word(name) || !axes.iter().chain(&common).all(|word| is_word(word)) {
        return None;
    }
    let declared = |name: String, features: &[&str], axes: Vec<String>| {
        let features = features.iter().map(|feature| (*feature).to_owned()).chain(common.iter().cloned());
        ProgramDeclaration { name, module: module.to_owned(), axes, features: features.collect() }
    };
    let (of_special, of_plain): (Vec<String>, Vec<String>) = axes.iter().cloned().partition(|axis| axis == SKINS);
    let special = |name: String, features: &[&str]| {
        let skins: &[&str] = if of_special.is_empty() { &[SKINS] } else { &[] };
        declared(name, &[features, &TEXTURES, skins].concat(), of_special.clone())
    };
    let mut programs = vec![declared(name.to_owned(), &[SKINS], of_plain)];
    if for_points {
        programs.push(declared(format!("{name}_points"), &[&["points", SKINS], &TEXTURES[..]].concat(), Vec::new()));
    }
    if with_layers {
        programs.push(special(format!("{name}_layered"), &["layered", "detailed"]));
    }
    if with_detail {
        programs.push(special(format!("{name}_detailed"), &["detailed"]));
    }
    if with_relief {
        let features: &[&str] = if with_layers { &["relief", "detailed", "layered"] } else { &["relief", "detailed"] };
        programs.push(special(format!("{name}_relief"), features));
    }
    Some(programs)
}

/// Module and text of every shader in `source`, in an order that does not depend on the file system.
pub fn shaders(source: &Path) -> BTreeMap<String, String> {
    let mut shaders = BTreeMap::new();
    find(source, "package", &mut |module, text| {
        shaders.insert(module.to_owned(), text.to_owned());
    });
    shaders
}

/// The shaders that stand in `source` itself, and the folders in it that have some.
pub fn watched(source: &Path) -> Vec<PathBuf> {
    let paths = fs::read_dir(source).expect("the sources are there").map(|entry| entry.expect("an entry").path());
    paths.filter(|path| if path.is_dir() { !shaders(path).is_empty() } else { is_shader(path) }).collect()
}

fn is_shader(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "wgsl")
}

/// Gives module and text of every shader in `folder`, whose own module is `module`.
fn find(folder: &Path, module: &str, give: &mut impl FnMut(&str, &str)) {
    for entry in fs::read_dir(folder).expect("the sources are there") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let module = format!("{module}::{stem}");
        if path.is_dir() {
            find(&path, &module, give);
        } else if is_shader(&path) {
            give(&module, &fs::read_to_string(&path).expect("a shader is text"));
        }
    }
}
