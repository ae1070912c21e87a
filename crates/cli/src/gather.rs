//! Which inputs the arguments name: files, folders, patterns of files; and what stands for each in the names of
//! outputs.

use crate::failure::Failure;
use crate::input::Input;
use crate::model_files::{in_folder, matching};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

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
