//! Which inputs the arguments name: files, folders, patterns of files; and what stands for each in the names of
//! outputs.

use crate::failure::{Failure, Kind};
use crate::input::Input;
use crate::stage::leave_out_named_models;
use manypass_scene::formats::is_model;
use manypass_scene::stage::is_stage;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// What stands for an input in the names of its outputs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// `{parent}`: the name of the folder that holds it.
    pub parent: String,
    /// `{stem}`: its name without its ending; with it, where the batch has both `m.glb` and `m.gltf` of one folder.
    pub stem: String,
}

/// An input, and what stands for it.
#[derive(Clone, Debug)]
pub struct Item {
    /// Where its scene comes from.
    pub input: Input,
    /// What stands for it in the names of its outputs.
    pub names: Names,
}

/// All inputs of a call, in the order of the arguments, and by name within one argument.
#[derive(Debug, Default)]
pub struct Inputs {
    /// All that were found.
    pub items: Vec<Item>,
    /// Folders and patterns in which no input was found, beside other arguments: as they were typed, and why.
    pub unfound: Vec<(String, Failure)>,
    /// Whether an argument stands for as many inputs as there happen to be, or there are several arguments.
    pub is_batch: bool,
    /// Folders that could not be looked into.
    pub warnings: Vec<String>,
}

/// Whether a file's ending is that of a model or of a stage.
fn is_input(path: &Path) -> bool {
    is_stage(path) || is_model(path)
}

impl Inputs {
    /// Everything that `arguments` name. A folder is every model and stage in it and, if `recursive`, in the folders
    /// below. An argument with `*`, `?` or `**` that is no file itself is every such file that matches. In both a stage
    /// stands for the model that it names, which is not drawn by itself, too. Hidden files and folders
    /// are left out, links to folders are not followed. A folder or pattern without any does not hinder other
    /// arguments.
    ///
    /// # Errors
    /// Wrong usage, or the only argument is a folder that cannot be read or stands for no model.
    pub fn gather(arguments: &[impl AsRef<OsStr>], recursive: bool) -> Result<Self, Failure> {
        let mut gathered = Self { is_batch: arguments.len() > 1, ..Self::default() };
        let mut inputs = Vec::new();
        for argument in arguments {
            let path = Path::new(argument);
            // What is no UTF-8 is the name of a file, and no pattern.
            let text = path.to_str().unwrap_or_default();
            let is_pattern = text.contains(['*', '?']) && fs::symlink_metadata(path).is_err();
            if text == "-" || text.starts_with("demo:") || !(path.is_dir() || is_pattern) {
                inputs.extend(Input::parse(argument)?);
                continue;
            }
            gathered.is_batch = true;
            let files = if is_pattern {
                matching(text, &mut gathered.warnings)
            } else {
                in_folder(path, recursive, &mut gathered.warnings)
            };
            match files {
                Ok(files) => inputs.extend(files.into_iter().map(Input::File)),
                Err(failure) if arguments.len() == 1 => return Err(failure),
                Err(failure) => gathered.unfound.push((path.display().to_string(), failure)),
            }
        }
        let names = names(&inputs);
        gathered.items = inputs.into_iter().zip(names).map(|(input, names)| Item { input, names }).collect();
        Ok(gathered)
    }

    /// How many inputs there are, with those that were not found.
    pub fn count(&self) -> usize {
        self.items.len() + self.unfound.len()
    }
}

/// The models and stages of a folder, by name; never none.
///
/// # Errors
/// If the folder cannot be read, or there are none.
pub fn in_folder(folder: &Path, recursive: bool, warnings: &mut Vec<String>) -> Result<Vec<PathBuf>, Failure> {
    let failed = |error: &dyn std::fmt::Display, hint: &str| {
        Failure::new(Kind::Failed, format!("cannot read {}: {error}", folder.display()), hint)
    };
    let hint = "name a folder of models (.glb, .gltf, .obj, .stl, .ply, .3mf) or .stage.toml files";
    fs::read_dir(folder).map_err(|error| failed(&error, hint))?;
    let mut files = Vec::new();
    let parts: &[&str] = if recursive { &["**", "*"] } else { &["*"] };
    collect(folder, parts, &mut files, warnings);
    if files.is_empty() {
        let has_folders = entries(folder, "*", &mut Vec::new()).iter().any(|(path, _)| path.is_dir());
        let hint = if recursive || !has_folders { hint } else { "add --recursive to look into its folders, too" };
        return Err(failed(&"it holds no model", hint));
    }
    files.sort();
    leave_out_named_models(&mut files);
    Ok(files)
}

/// The models and stages that a pattern matches, by name; never none.
fn matching(pattern: &str, warnings: &mut Vec<String>) -> Result<Vec<PathBuf>, Failure> {
    let (start, below) = start(pattern);
    let mut parts: Vec<&str> = below.split(std::path::is_separator).filter(|part| !part.is_empty()).collect();
    // `a/**/**/b` is `a/**/b`, and `a/**` is every file below.
    parts.dedup_by(|a, b| a == b && *a == "**");
    if parts.last() == Some(&"**") {
        parts.push("*");
    }
    let mut files = Vec::new();
    collect(&start, &parts, &mut files, warnings);
    files.sort();
    files.dedup();
    if files.is_empty() {
        let message = format!("no model matches `{pattern}`");
        return Err(Failure::new(Kind::Failed, message, "* and ? stand for letters of a name, ** for any folders"));
    }
    leave_out_named_models(&mut files);
    Ok(files)
}

/// The drive and the root that a pattern begins with, such as `C:\`, `\\server\share\` or `/`, and what follows them.
fn start(pattern: &str) -> (PathBuf, &str) {
    let is_start = |part: &Component<'_>| matches!(part, Component::Prefix(_) | Component::RootDir);
    let start: PathBuf = Path::new(pattern).components().take_while(is_start).collect();
    let below = start.to_str().and_then(|start| pattern.get(start.len()..));
    (start, below.unwrap_or(pattern))
}

/// Adds the models and stages below `folder` whose path matches `parts`.
fn collect(folder: &Path, parts: &[&str], files: &mut Vec<PathBuf>, warnings: &mut Vec<String>) {
    let Some((part, rest)) = parts.split_first() else { return };
    if *part == "**" {
        collect(folder, rest, files, warnings);
        for (path, is_link) in entries(folder, "*", warnings) {
            if !is_link && path.is_dir() {
                collect(&path, parts, files, warnings);
            }
        }
        return;
    }
    let found = if part.contains(['*', '?']) {
        entries(folder, part, warnings).into_iter().map(|(path, _)| path).collect()
    } else {
        vec![folder.join(part)]
    };
    for path in found {
        if !rest.is_empty() {
            collect(&path, rest, files, warnings);
        } else if is_input(&path) && !path.is_dir() {
            // What cannot be read, such as a link to nowhere, is an input that fails, and not one that is missed.
            files.push(path);
        }
    }
}

/// What a folder holds whose name matches, and whether it is a link. A folder that is none holds nothing.
fn entries(folder: &Path, pattern: &str, warnings: &mut Vec<String>) -> Vec<(PathBuf, bool)> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = match fs::read_dir(here) {
        Ok(entries) => entries,
        Err(_) if !here.is_dir() => return Vec::new(),
        Err(error) => {
            let warning = format!("cannot read {}: {error}; its files are left out", here.display());
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
            return Vec::new();
        }
    };
    let named = entries.flatten().filter(|entry| matches(pattern, &entry.file_name().to_string_lossy()));
    named.map(|entry| (folder.join(entry.file_name()), entry.file_type().is_ok_and(|kind| kind.is_symlink()))).collect()
}

/// Whether a name matches a pattern of letters, `?` (one letter) and `*` (any number of them). The dot of a hidden name
/// must be there in the pattern.
fn matches(pattern: &str, name: &str) -> bool {
    if name.starts_with('.') && !pattern.starts_with('.') {
        return false;
    }
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut at, mut name_at) = (0, 0);
    // Where to go on after the last `*`, should what follows it not match.
    let mut retry: Option<(usize, usize)> = None;
    while name_at < name.len() {
        match pattern.get(at) {
            Some('*') => {
                retry = Some((at + 1, name_at));
                at += 1;
            }
            Some(letter) if *letter == '?' || Some(letter) == name.get(name_at) => {
                at += 1;
                name_at += 1;
            }
            _ => {
                let Some((after_star, start)) = retry else { return false };
                retry = Some((after_star, start + 1));
                (at, name_at) = (after_star, start + 1);
            }
        }
    }
    pattern.get(at..).is_none_or(|rest| rest.iter().all(|letter| *letter == '*'))
}

/// What stands for each input.
fn names(inputs: &[Input]) -> Vec<Names> {
    let folder = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned())
    };
    let file_name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut of_stem: BTreeMap<(PathBuf, String), BTreeSet<String>> = BTreeMap::new();
    for input in inputs {
        if let Input::File(path) = input {
            of_stem.entry((folder(path), input.stem())).or_default().insert(file_name(path));
        }
    }
    let name = |input: &Input| match input {
        Input::Stdin => Names { parent: "stdin".into(), stem: input.stem() },
        Input::Demo(_) => Names { parent: "demo".into(), stem: input.stem() },
        Input::File(path) => {
            let folder = folder(path);
            // A link is called as it is typed.
            let typed = path.parent().and_then(Path::file_name);
            let parent = typed.or(folder.file_name()).map_or("root".into(), |name| name.to_string_lossy().into_owned());
            let has_twin = of_stem.get(&(folder, input.stem())).is_some_and(|names| names.len() > 1);
            Names { parent, stem: if has_twin { file_name(path) } else { input.stem() } }
        }
    };
    inputs.iter().map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_letters_and_leave_hidden_names_out() {
        for (pattern, name) in [("*", "a.glb"), ("a?c*.glb", "abcd.glb"), ("*b*b", "abab"), ("", ""), (".*", ".a")] {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [("*", ".a.glb"), ("?a", ".a"), ("a?", "a"), ("*b", "abc"), ("a", "")] {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }

    #[test]
    fn patterns_keep_their_drive_and_root() {
        assert_eq!(start("/a/*.glb"), (PathBuf::from("/"), "a/*.glb"));
        assert_eq!(start("a/*.glb"), (PathBuf::new(), "a/*.glb"));
        assert_eq!(start("./*.glb"), (PathBuf::new(), "./*.glb"));
        if cfg!(windows) {
            assert_eq!(start(r"C:\a\*.glb"), (PathBuf::from(r"C:\"), r"a\*.glb"));
            assert_eq!(start(r"C:a\*.glb"), (PathBuf::from("C:"), r"a\*.glb"));
            assert_eq!(start(r"\\s\t\a\*.glb"), (PathBuf::from(r"\\s\t\"), r"a\*.glb"));
        }
    }

    #[test]
    fn folders_and_patterns_find_files_and_names_tell_them_apart() {
        let root = std::env::temp_dir().join(format!("manypass-gather-{}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        for file in ["m.glb", "m.gltf", "n.GLB", "n.txt", "in/m.glb", "in/deep/o.gltf", ".h.glb", ".hide/p.glb"] {
            let path = root.join(file);
            fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
            fs::write(path, b"").expect("written");
        }
        fs::create_dir(root.join("folder.glb")).expect("a folder");
        let found = |argument: &str, recursive| {
            let argument = format!("{}{argument}", root.display());
            let inputs = Inputs::gather(&[argument], recursive).expect("found");
            assert!(inputs.is_batch && inputs.warnings.is_empty());
            let stems: Vec<String> = inputs.items.into_iter().map(|item| item.names.stem).collect();
            stems.join(" ")
        };
        assert_eq!(found("", false), "m.glb m.gltf n");
        assert_eq!(found("", true), "o m m.glb m.gltf n");
        assert_eq!(found("/**/*.glb", false), "m m");
        assert_eq!(found("/**", false), "o m m.glb m.gltf n");
        assert_eq!(found("/*/**/**/?.gl*", false), "o m");
        assert_eq!(found("/.h*/*", false), "p");
        let parents = Inputs::gather(&[format!("{}/in/**", root.display())], false).expect("found");
        assert_eq!(parents.items.iter().map(|item| item.names.parent.as_str()).collect::<Vec<_>>(), ["deep", "in"]);
        let nothing = format!("{}/x*", root.display());
        assert!(Inputs::gather(std::slice::from_ref(&nothing), false).is_err());
        let others = Inputs::gather(&[nothing.clone(), "demo:hall".into()], false).expect("one of two");
        assert!(others.items.len() == 1 && others.count() == 2 && others.unfound[0].0 == nothing, "{others:?}");
        let _ = fs::remove_dir_all(root);
    }
}
