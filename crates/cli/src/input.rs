//! Inputs: files, folders, standard input and the built-in demos.

use crate::failure::{Failure, Kind};
use crate::gather;
use manypass_offline::atomic;
use manypass_scene::{LoadError, Scene, gltf_file};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// A file.
    File(PathBuf),
    /// A .glb on standard input.
    Stdin,
    /// A built-in scene.
    Demo(String),
}

/// The built-in scenes.
pub mod demo {
    use manypass_scene::Scene;

    /// Their names.
    pub const NAMES: &[&str] = &["hall"];

    /// The scene called `name`.
    pub fn scene(name: &str) -> Option<Scene> {
        (name == "hall").then(manypass_scene::demo::hall)
    }
}

/// What to do about a file that cannot be read.
fn hint(error: &LoadError) -> &'static str {
    match error {
        LoadError::Io { .. } => "name a readable .glb or .gltf file",
        LoadError::Invalid { .. } => "correct the file at that place, or export the model again",
        LoadError::UnsupportedExtension { .. } => "export the model without it, or let a converter unpack it",
    }
}

impl Input {
    /// The inputs that an argument names: a folder is every glTF file in it that is not hidden, by name.
    ///
    /// # Errors
    /// If a folder cannot be read or holds no glTF file.
    pub fn parse(argument: &str) -> Result<Vec<Self>, Failure> {
        if argument.is_empty() {
            return Err(Failure::usage("the name of an input is empty", "name a .glb or .gltf file, or a folder"));
        }
        if argument == "-" {
            return Ok(vec![Self::Stdin]);
        }
        if let Some(name) = argument.strip_prefix("demo:") {
            if !demo::NAMES.contains(&name) {
                let hint = match demo::NAMES {
                    [] => "there are no built-in demos in this build".into(),
                    names => format!("demos: {}", names.join(", ")),
                };
                return Err(Failure::usage(format!("unknown demo `{name}`"), hint));
            }
            return Ok(vec![Self::Demo(name.to_owned())]);
        }
        let path = Path::new(argument);
        if !path.is_dir() {
            return Ok(vec![Self::File(path.to_owned())]);
        }
        let files = gather::in_folder(path, false, &mut Vec::new())?;
        Ok(files.into_iter().map(Self::File).collect())
    }

    /// The name of the file without its ending, or of what is no file.
    pub fn stem(&self) -> String {
        match self {
            Self::File(path) => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            Self::Stdin => "stdin".into(),
            Self::Demo(name) => name.clone(),
        }
    }

    /// The name for messages.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Stdin => "standard input".into(),
            Self::Demo(name) => format!("demo:{name}"),
        }
    }

    /// Reads the scene, and what its reader warns of.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn load(&self) -> Result<(Scene, Vec<String>), Failure> {
        let failed = |error: &dyn std::fmt::Display, hint: &str| {
            Failure::new(Kind::Failed, format!("{}: {error}", self.name()), hint)
        };
        // What the reader of glTF says names its file already.
        let unread = |error: &LoadError| Failure::new(Kind::Failed, error, hint(error));
        let loaded = match self {
            Self::File(path) if std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() == 0) => {
                return Err(failed(&"the file is empty", "export the model again, or name another file"));
            }
            Self::File(path) => gltf_file::load_path(path).map_err(|error| unread(&error))?,
            Self::Stdin => {
                let mut bytes = Vec::new();
                let _waiting = atomic::Waiting::begin();
                let mut stdin = std::io::stdin().lock().take(gltf_file::MAX_FILE_BYTES + 1);
                stdin.read_to_end(&mut bytes).map_err(|error| failed(&error, "pipe a .glb file in"))?;
                if bytes.len() as u64 > gltf_file::MAX_FILE_BYTES {
                    return Err(failed(&"it is larger than 1 GiB", "pipe a smaller .glb file in"));
                }
                if bytes.is_empty() {
                    return Err(failed(&"it is empty", "pipe a .glb file in"));
                }
                let mut refuse = |uri: &str| Err(format!("standard input has no folder to find `{uri}` in"));
                gltf_file::load_bytes(&bytes, &mut refuse, "standard input").map_err(|error| unread(&error))?
            }
            Self::Demo(name) => {
                let mut scene = demo::scene(name).ok_or_else(|| failed(&"unknown demo", "see `manypass --help`"))?;
                scene.update_transforms();
                return Ok((scene, Vec::new()));
            }
        };
        let mut scene = loaded.scene;
        scene.update_transforms();
        Ok((scene, loaded.warnings))
    }
}
