//! Stages as inputs: what they name, and what they stand for.

use crate::failure::{Failure, Kind};
use manypass_scene::gltf_file::LoadError;
use manypass_scene::stage::{self, LoadedStage, StageError, is_stage, named_model};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The scene of a stage.
///
/// # Errors
/// The stage or its model cannot be read, or one of them is wrong.
pub fn load(path: &Path) -> Result<LoadedStage, Failure> {
    stage::load_path(path).map_err(|error| match &error {
        StageError::Text(diagnostic) => {
            Failure::located(Kind::Failed, diagnostic, "correct the stage; see docs/stage.md")
        }
        StageError::Io { .. } => Failure::new(Kind::Failed, error, "name a readable .stage.toml file"),
        StageError::Model(error) => Failure::new(Kind::Failed, error, model_hint(error)),
    })
}

/// What to do about a model that cannot be read.
pub fn model_hint(error: &LoadError) -> &'static str {
    match error {
        LoadError::Io { .. } => "name a readable model: .glb, .gltf, .obj, .stl, .ply or .3mf",
        LoadError::Invalid { .. } | LoadError::Malformed { .. } => {
            "correct the file at that place, or export the model again"
        }
        LoadError::UnsupportedExtension { .. } => "export the model without it, or let a converter unpack it",
        _ => "name another model, or export it again",
    }
}

/// Leaves the models out that stages among `files` stand for.
pub fn leave_out_named_models(files: &mut Vec<PathBuf>) {
    let place = |path: &Path| fs::canonicalize(path).ok();
    let stages = files.iter().filter(|file| is_stage(file));
    let models: BTreeSet<PathBuf> = stages.filter_map(|stage| place(&named_model(stage)?)).collect();
    if !models.is_empty() {
        files.retain(|file| is_stage(file) || !place(file).is_some_and(|place| models.contains(&place)));
    }
}
