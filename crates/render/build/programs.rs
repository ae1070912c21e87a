//! The programs of the renderer, as its shaders declare them.

use std::{collections::BTreeMap, fs, path::Path};

/// How the line begins by which a shader says that it is a program.
const PROGRAM: &str = "// Program: ";

/// After the name: there is a second program, for points.
const FOR_POINTS: &str = ", also for points";

/// After the name, and after [`FOR_POINTS`]: there is one more program, for materials with layers.
const WITH_LAYERS: &str = ", also with layers";

/// After these: there is one more program, for materials with maps over others, or with baked light.
const WITH_DETAIL: &str = ", also with detail";

/// After these: there is one more program, for materials with relief. It has the layers of the program, if that has any.
const WITH_RELIEF: &str = ", also with relief";

/// Axes that only surfaces with layers have.
const AXES_OF_LAYERS: [&str; 1] = ["transmissive"];

/// An axis that they have not, because it is on: few are worth no variants.
const ALWAYS_WITH_LAYERS: &str = "occlusion_apart";

/// The same of programs with detail.
const ALWAYS_WITH_DETAIL: [&str; 2] = ["textured", ALWAYS_WITH_LAYERS];

/// The same of programs with relief.
const ALWAYS_WITH_RELIEF: [&str; 3] = ["textured", ALWAYS_WITH_LAYERS, "masked"];

/// Axes that surfaces have and points do not: their discs are cut out in any case, so that masks, whose cutoff is 0 where
/// there is none, need no variants; and they have no tangents.
const AXES_OF_SURFACES: [&str; 2] = ["masked", "normal_map"];

/// A program.
#[derive(Debug)]
pub struct Declared {
    /// Its name; no other has it.
    pub name: String,
    /// Its WESL module, such as `package::passes::ids::ids`.
    pub module: String,
    /// A variant's index has bit `i` set if axis `i` is on.
    pub axes: Vec<String>,
    /// Features that are on in all of its variants.
    pub features: &'static [&'static str],
}

/// The programs of all shaders in `source`, by name. A shader is one if its first comment has a line such as one of these:
///
/// ```wgsl
/// // Program: meter.
/// // Program: direct. Axes: tiled, global.
/// // Program: ids, also for points. Axes: textured, masked, deformed.
/// // Program: forward, also for points, also with layers, also with relief. Axes: textured, transmissive.
/// ```
pub fn declared(source: &Path) -> Vec<Declared> {
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
fn read(module: &str, line: &str) -> Option<Vec<Declared>> {
    let (name, axes) = match line.strip_suffix('.')?.split_once(". Axes: ") {
        Some((name, axes)) => (name, axes.split(", ").map(str::to_owned).collect()),
        None => (line.strip_suffix('.')?, Vec::new()),
    };
    let is_word = |word: &str| {
        !word.is_empty() && word.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_')
    };
    let (name, with_relief) = name.strip_suffix(WITH_RELIEF).map_or((name, false), |name| (name, true));
    let (name, with_detail) = name.strip_suffix(WITH_DETAIL).map_or((name, false), |name| (name, true));
    let (name, with_layers) = name.strip_suffix(WITH_LAYERS).map_or((name, false), |name| (name, true));
    let (name, for_points) = name.strip_suffix(FOR_POINTS).map_or((name, false), |name| (name, true));
    if !is_word(name) || !axes.iter().all(|axis| is_word(axis)) {
        return None;
    }
    let declared = |name: String, features, has: &dyn Fn(&str) -> bool| Declared {
        name,
        module: module.to_owned(),
        axes: axes.iter().filter(|axis| has(axis)).cloned().collect(),
        features,
    };
    let is_of_surfaces = |axis: &str| !AXES_OF_LAYERS.contains(&axis);
    let is_of_points = |axis: &str| is_of_surfaces(axis) && !AXES_OF_SURFACES.contains(&axis);
    let mut programs = vec![declared(name.to_owned(), &[], &is_of_surfaces)];
    if for_points {
        programs.push(declared(format!("{name}_points"), &["points", "masked"], &is_of_points));
    }
    if with_layers {
        let features = &["layered", "detailed", ALWAYS_WITH_LAYERS];
        programs.push(declared(format!("{name}_layered"), features, &|axis| axis != ALWAYS_WITH_LAYERS));
    }
    if with_detail {
        let features = &["detailed", "textured", ALWAYS_WITH_LAYERS];
        let has = |axis: &str| is_of_surfaces(axis) && !ALWAYS_WITH_DETAIL.contains(&axis);
        programs.push(declared(format!("{name}_detailed"), features, &has));
    }
    if with_relief {
        let all: &'static [&'static str] = &["relief", "detailed", "textured", ALWAYS_WITH_LAYERS, "masked", "layered"];
        let features = if with_layers { all } else { &all[..all.len() - 1] };
        let has = |axis: &str| is_of_surfaces(axis) && !ALWAYS_WITH_RELIEF.contains(&axis);
        programs.push(declared(format!("{name}_relief"), features, &has));
    }
    Some(programs)
}

/// Gives module and text of every shader in `folder`, whose own module is `module`.
fn find(folder: &Path, module: &str, give: &mut impl FnMut(&str, &str)) {
    for entry in fs::read_dir(folder).expect("the sources are there") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let module = format!("{module}::{stem}");
        if path.is_dir() {
            find(&path, &module, give);
        } else if path.extension().is_some_and(|extension| extension == "wgsl") {
            give(&module, &fs::read_to_string(&path).expect("a shader is text"));
        }
    }
}
