//! From a stage file to a scene: the model that it names, with what it changes.

use super::entries::Stage;
use super::keys::{DECALS, MATERIALS, OVERLAY, PARTICLES, SIMULATIONS, WATER};
use super::light_files::{InFolder, Light, LightFiles, ResolvedFiles};
use super::older::{list_of, value};
use super::table::{Source, document};
use super::{decals, materials::MAPS, overlay::FILES, simulations, water};
use crate::formats;
use crate::gltf_file::{LoadError, LoadedScene, read_file};
use crate::{Diagnostic, Scene, demo, input_file};
use std::path::{Path, PathBuf};
use toml::de::DeValue;

/// The largest stage that is read: 16 MiB, which is more than the most lights take.
pub const MAX_STAGE_BYTES: u64 = 16 << 20;

/// The word before the name of a built-in scene.
const DEMO: &str = "demo:";

/// A scene as a stage makes it.
#[derive(Clone, Debug)]
pub struct LoadedStage {
    /// The model's scene with the stage's changes, its transforms up to date.
    pub scene: Scene,
    /// What is wrong with the model but does not hinder drawing; one line each.
    pub warnings: Vec<String>,
    /// The stage, whose text holds settings.
    pub stage: Stage,
}

/// Why there is no scene of a stage.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StageError {
    /// The stage cannot be read.
    #[error("{file}: {message}")]
    Io {
        /// The stage's file.
        file: String,
        /// What went wrong.
        message: String,
    },
    /// The stage is wrong, or names what is not there.
    #[error(transparent)]
    Text(#[from] Box<Diagnostic>),
    /// The model cannot be read.
    #[error(transparent)]
    Model(#[from] LoadError),
}

/// Reads the stage at `path`, its model and the files that the model names.
///
/// # Errors
/// The stage or its model cannot be read, or one of them is wrong; with file, line and column of what is wrong in a
/// stage.
pub fn load_path(path: &Path) -> Result<LoadedStage, StageError> {
    let file = path.display().to_string();
    let text = read_text(path).map_err(|message| StageError::Io { file: file.clone(), message })?;
    let stage = Stage::parse(&file, &text)?;
    let model = model_path(path, stage.model());
    // A file that is not there is a fault of the stage, not of the model.
    if let Some(model) = &model {
        std::fs::metadata(model)
            .map_err(|error| stage.model_fault(format!("cannot read the model {}: {error}", model.display())))?;
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let light = stage.light_files.read(&stage.source, &mut InFolder(folder))?;
    let mut read = |name: &str| read_file(&folder.join(name));
    with_model(stage, light, |_, _| model.map(|model| formats::load_path(&model)), &mut read)
}

/// Reads a stage from memory. `resolve` fetches the model and images, by the names that the stage gives them, and the
/// files that the model names; `name` appears in errors.
///
/// # Errors
/// As [`load_path`].
pub fn load_bytes(
    bytes: &[u8],
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    name: &str,
) -> Result<LoadedStage, StageError> {
    let io = |message: String| StageError::Io { file: name.into(), message };
    if bytes.len() as u64 > MAX_STAGE_BYTES {
        return Err(io(TOO_LARGE.into()));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| io(NO_TEXT.into()))?;
    let stage = Stage::parse(name, text)?;
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    let light = stage.light_files.read(&stage.source, &mut ResolvedFiles { folder, resolve: &mut *resolve })?;
    if stage.model().starts_with(DEMO) {
        return with_model(stage, light, |_, _| None, resolve);
    }
    let model = resolve(stage.model()).map_err(|message| stage.model_fault(message))?;
    let load = |stage: &Stage, resolve: &mut Resolve<'_>| Some(formats::load_bytes(&model, resolve, stage.model()));
    with_model(stage, light, load, resolve)
}

/// The model of a stage, as far as its text says one, whatever else is wrong with it: for whoever must not draw it
/// twice, nor write to it. None of a built-in scene.
pub fn named_model(path: &Path) -> Option<PathBuf> {
    let source = Source { file: String::new(), text: read_text(path).ok()? };
    let document = document(&source).ok()?;
    match value(document.get_ref(), "model")?.get_ref() {
        DeValue::String(model) => model_path(path, model),
        _ => None,
    }
}

/// The picture of the environment that a stage names, and what else it names of its light, as [`named_model`].
pub fn named_environments(path: &Path) -> Vec<PathBuf> {
    let Ok(text) = read_text(path) else { return Vec::new() };
    let folder = path.parent().unwrap_or(Path::new(""));
    let source = Source { file: String::new(), text };
    let Ok(document) = document(&source) else { return Vec::new() };
    LightFiles::of(document.get_ref()).names().map(|name| folder.join(name)).collect()
}

/// The images that the materials and the water of a stage name, and the sprites and fonts of its overlay, and the files of its simulations, as [`named_model`].
pub fn named_images(path: &Path) -> Vec<PathBuf> {
    let Ok(text) = read_text(path) else { return Vec::new() };
    let folder = path.parent().unwrap_or(Path::new(""));
    let source = Source { file: String::new(), text };
    let Ok(document) = document(&source) else { return Vec::new() };
    let named = [
        (MATERIALS.name, &MAPS[..]),
        (WATER.name, &water::IMAGES[..]),
        (DECALS.name, &decals::IMAGES[..]),
        (OVERLAY.name, &FILES[..]),
        (SIMULATIONS.name, &["program"][..]),
        (PARTICLES.name, &["program"][..]),
    ];
    let named = named.into_iter().flat_map(|(list, keys)| {
        let entries = list_of(document.get_ref(), list).and_then(|list| list.get_ref().as_array());
        let tables = entries.into_iter().flatten().filter_map(|entry| entry.get_ref().as_table());
        let names = tables.flat_map(|table| keys.iter().filter_map(|key| value(table, key)?.get_ref().as_str()));
        // Programs of simulations that are no files are built in, and images of decals may be the model's.
        names.filter(move |name| match list {
            _ if [SIMULATIONS.name, PARTICLES.name].contains(&list) => simulations::is_file(name),
            _ if list == DECALS.name => decals::is_file(name),
            _ => true,
        })
    });
    let is_file = |name: &&str| !name.is_empty();
    named.filter(is_file).map(|name| folder.join(name)).collect()
}

/// The effects that the chain of a stage names by their files, as [`named_model`].
pub fn named_effects(path: &Path) -> Vec<PathBuf> {
    let Ok(text) = read_text(path) else { return Vec::new() };
    let folder = path.parent().unwrap_or(Path::new(""));
    let source = Source { file: String::new(), text };
    let Ok(document) = document(&source) else { return Vec::new() };
    let table = |name| value(document.get_ref(), name).and_then(|value| value.get_ref().as_table());
    let settings = table("settings");
    let within = settings.and_then(|table| value(table, "effects")?.get_ref().as_table());
    let chains = [table("effects"), within, settings].into_iter().flatten();
    let entries = chains.filter_map(|table| value(table, "chain")?.get_ref().as_array()).flatten();
    let named = entries.filter_map(|entry| entry.get_ref().as_str());
    let is_file = |name: &&str| [".wgsl", ".cube"].iter().any(|end| name.to_ascii_lowercase().ends_with(end));
    named.filter(is_file).map(|name| folder.join(name)).collect()
}

const TOO_LARGE: &str = "it is larger than 16 MiB";
const NO_TEXT: &str = "it is not UTF-8 text";

/// The text.
fn read_text(path: &Path) -> Result<String, String> {
    input_file::read_text(path, MAX_STAGE_BYTES).map_err(|error| error.to_string())
}

/// Where a model lies; none of a built-in scene.
fn model_path(stage: &Path, model: &str) -> Option<PathBuf> {
    (!model.starts_with(DEMO)).then(|| stage.parent().unwrap_or(Path::new("")).join(model))
}

/// What fetches files by their names.
type Resolve<'r> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'r;

/// The scene of the model that `load` gives, or of a built-in one, with the changes of the stage.
fn with_model(
    stage: Stage,
    light: Light,
    load: impl FnOnce(&Stage, &mut Resolve<'_>) -> Option<Result<LoadedScene, LoadError>>,
    resolve: &mut Resolve<'_>,
) -> Result<LoadedStage, StageError> {
    let (mut scene, mut warnings) = match load(&stage, resolve) {
        Some(loaded) => loaded.map(|loaded| (loaded.scene, loaded.warnings))?,
        None => match stage.model().strip_prefix(DEMO).and_then(demo::named) {
            Some(scene) => (scene, Vec::new()),
            None => {
                let known = demo::NAMES.map(|name| format!("{DEMO}{name}")).join(", ");
                Err(stage.model_fault(format!("there is no `{}`; the built-in scenes are {known}", stage.model())))?
            }
        },
    };
    warnings.extend(stage.apply_with(&mut scene, resolve)?);
    if let Some(map) = light.environment {
        warnings.extend(map.notes.iter().cloned());
        scene.environment = Some(map.into());
    }
    if let Some(table) = light.brdf {
        scene.brdf = Some(table.into());
    }
    Ok(LoadedStage { scene, warnings, stage })
}
