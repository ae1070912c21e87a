//! Inputs: files, folders, standard input and the built-in demos.

use crate::failure::{Failure, Kind};
use crate::{model_files, stage};
use manypass_offline::atomic;
use manypass_scene::renamed::{NameKind, current};
use manypass_scene::stage::is_stage;
use manypass_scene::{LoadError, Scene, Stage, demo, gltf_file, load_bytes, load_path};
use std::ffi::OsStr;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// A file.
    File(PathBuf),
    /// A model in one file on standard input.
    Stdin,
    /// A built-in scene.
    Demo(String),
}

/// What an input holds.
#[derive(Debug)]
pub struct InputScene {
    /// The scene, its transforms up to date.
    pub scene: Scene,
    /// What its reader warns of.
    pub warnings: Vec<String>,
    /// The stage that it was read from, or that a demo has, whose settings come before the user's.
    pub stage: Option<Stage>,
}

impl Input {
    /// Whether it brings settings of its own: a stage, or a demo that has some.
    pub fn has_settings(&self) -> bool {
        match self {
            Self::File(path) => is_stage(path),
            Self::Demo(name) => demo::stage(name).is_some(),
            Self::Stdin => false,
        }
    }

    /// The inputs that an argument names: a folder is every model and stage in it that is not hidden, by name.
    ///
    /// # Errors
    /// If a folder cannot be read or holds no model.
    pub fn parse(argument: impl AsRef<OsStr>) -> Result<Vec<Self>, Failure> {
        let argument = argument.as_ref();
        if argument.is_empty() {
            return Err(Failure::usage(
                "the name of an input is empty",
                "name a model (.glb, .gltf, .obj, .stl, .ply, .3mf), a .stage.toml file, or a folder",
            ));
        }
        if argument == "-" {
            return Ok(vec![Self::Stdin]);
        }
        if let Some(name) = argument.to_str().and_then(|text| text.strip_prefix("demo:")) {
            if !demo::NAMES.contains(&current(NameKind::Demo, name)) {
                let hint = format!("demos: {}", demo::NAMES.join(", "));
                return Err(Failure::usage(format!("unknown demo `{name}`"), hint));
            }
            return Ok(vec![Self::Demo(name.to_owned())]);
        }
        let path = Path::new(argument);
        if !path.is_dir() {
            return Ok(vec![Self::File(path.to_owned())]);
        }
        let files = model_files::in_folder(path, false, &mut Vec::new())?;
        Ok(files.into_iter().map(Self::File).collect())
    }

    /// The name of the file without its ending, or of what is no file.
    pub fn stem(&self) -> String {
        match self {
            Self::File(path) => {
                let stem = path.file_stem().unwrap_or_default();
                // A stage ends in two words.
                let stem = if is_stage(path) { Path::new(stem).file_stem().unwrap_or_default() } else { stem };
                stem.to_string_lossy().into_owned()
            }
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

    /// Reads the scene, what its reader warns of, and the stage that it comes from.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn load(&self) -> Result<InputScene, Failure> {
        let failed = |error: &dyn std::fmt::Display, hint: &str| {
            Failure::new(Kind::Failed, format!("{}: {error}", self.name()), hint)
        };
        // What the readers of models say names its file already.
        let unread = |error: &LoadError| Failure::new(Kind::Failed, error, stage::model_hint(error));
        let loaded = match self {
            Self::File(path) if is_stage(path) => {
                let loaded = stage::load(path)?;
                return Ok(InputScene { scene: loaded.scene, warnings: loaded.warnings, stage: Some(loaded.stage) });
            }
            Self::File(path) if std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() == 0) => {
                return Err(failed(&"the file is empty", "export the model again, or name another file"));
            }
            Self::File(path) if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml")) => {
                let hint = "a stage is called NAME.stage.toml; settings are given by --settings";
                return Err(failed(&"it is neither a model nor a stage", hint));
            }
            Self::File(path) => load_path(path).map_err(|error| unread(&error))?,
            Self::Stdin => {
                let mut bytes = Vec::new();
                let _waiting = atomic::WaitGuard::begin();
                let mut stdin = std::io::stdin().lock().take(gltf_file::MAX_FILE_BYTES + 1);
                stdin
                    .read_to_end(&mut bytes)
                    .map_err(|error| failed(&error, "pipe a model in, such as a .glb or .stl file"))?;
                if bytes.len() as u64 > gltf_file::MAX_FILE_BYTES {
                    return Err(failed(&"it is larger than 1 GiB", "pipe a smaller model in"));
                }
                if bytes.is_empty() {
                    return Err(failed(&"it is empty", "pipe a model in, such as a .glb or .stl file"));
                }
                let mut refuse = |uri: &str| Err(format!("standard input has no folder to find `{uri}` in"));
                load_bytes(&bytes, &mut refuse, "standard input").map_err(|error| unread(&error))?
            }
            Self::Demo(name) => {
                let mut scene = demo::named(name).ok_or_else(|| failed(&"unknown demo", "see `manypass --help`"))?;
                scene.update_transforms();
                return Ok(InputScene { scene, warnings: Vec::new(), stage: demo::stage(name) });
            }
        };
        let mut scene = loaded.scene;
        scene.update_transforms();
        Ok(InputScene { scene, warnings: loaded.warnings, stage: None })
    }
}
