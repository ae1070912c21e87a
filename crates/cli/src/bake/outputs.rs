//! What a bake writes: the model, and its stage.

use crate::args::bake::BakeArgs;
use crate::failure::Failure;
use crate::input::Input;
use crate::output;
use crate::places::Places;
use manypass::Settings;
use manypass_scene::gltf_file::Parts;
use manypass_scene::stage::MAX_STAGE_BYTES;
use manypass_scene::{Stage, input_file};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// What is written.
pub(super) struct Outputs {
    pub(super) model: PathBuf,
    /// Of an input that is a stage, or has one, and where flags say what lies around the scene.
    pub(super) stage: Option<PathBuf>,
}

/// What begins a stage that this command wrote, so that it may be written again.
const WRITTEN: &str = "# Written by `manypass bake`.\n";

impl Outputs {
    pub(super) fn new(args: &BakeArgs, input: &Input) -> Result<Self, Failure> {
        let model = args.output.clone();
        if !model.extension().is_some_and(|end| end.eq_ignore_ascii_case("glb")) {
            let message = format!("{} does not end in .glb", model.display());
            return Err(Failure::usage(message, "write -o OUT.glb"));
        }
        let has_stage = input.has_settings() || args.says_environment();
        let stage = has_stage.then(|| model.with_extension("stage.toml"));
        if let Some(path) = stage.as_ref().filter(|path| path.is_file()) {
            let is_written =
                input_file::read(path, MAX_STAGE_BYTES).is_ok_and(|bytes| bytes.starts_with(WRITTEN.as_bytes()));
            if !is_written {
                let message = format!("{} is there, and was not written by a bake", path.display());
                return Err(Failure::usage(message, "write to another -o OUT.glb, or move that stage away"));
            }
        }
        Ok(Self { model, stage })
    }

    /// Writes them.
    pub(super) fn write(&self, model: &[u8], stage_text: Option<&str>) -> Result<(), Failure> {
        output::write_file(&self.model, model)?;
        match (&self.stage, stage_text) {
            (Some(path), Some(text)) => output::write_file(path, text.as_bytes()),
            _ => Ok(()),
        }
    }

    /// Whether they are there already, made of the same.
    pub(super) fn are_of(&self, key: &str, stage_text: Option<&str>) -> bool {
        let is_same = |path: &PathBuf| {
            input_file::read(path, MAX_STAGE_BYTES).is_ok_and(|bytes| Some(&*bytes) == stage_text.map(str::as_bytes))
        };
        self.stage.as_ref().is_none_or(is_same)
            && Parts::json_of(&self.model).is_some_and(|json| json["asset"]["extras"]["bake"]["key"] == key)
    }

    /// The text of the stage: that of the input with another model, and with what flags say of the environment, so that
    /// frames have what was baked.
    pub(super) fn stage_text(
        &self,
        stage: Option<&Stage>,
        settings: &Settings,
        args: &BakeArgs,
    ) -> Result<Option<String>, Failure> {
        if self.stage.is_none() {
            return Ok(None);
        }
        let model = self.model.file_name().unwrap_or_default().to_string_lossy();
        let text = match stage {
            Some(stage) => stage.text_with_model(&model),
            None => format!("model = {}\n", Value::from(&*model)),
        };
        let mut text = format!("{WRITTEN}{}", text.strip_prefix(WRITTEN).unwrap_or(&text));
        if !args.says_environment() {
            return Ok(Some(text));
        }
        text.push_str("\n[environment]\n");
        let table = |settings: &Settings| serde_json::to_value(settings).map(|all| all["environment"].clone());
        let (Ok(all), Ok(default)) = (table(settings), table(&Settings::default())) else { return Ok(Some(text)) };
        for (key, value) in all.as_object().into_iter().flatten() {
            if key.ends_with("file") && value.as_str().is_some_and(|file| !file.is_empty()) {
                let file = self.beside(Path::new(value.as_str().unwrap_or_default()))?;
                text.push_str(&format!("{key} = {}\n", Value::from(file)));
            } else if *value != default[key] {
                text.push_str(&format!("{key} = {value}\n"));
            }
        }
        // A second table of that name, however the first one is written, is none.
        if Stage::parse(&model, &text).is_err() {
            let message = "the stage already sets the environment";
            return Err(Failure::usage(message, "change its [environment], and leave flags of the environment out"));
        }
        Ok(Some(text))
    }

    /// The name of a file in the folder of the output.
    fn beside(&self, file: &Path) -> Result<String, Failure> {
        if folder_of(file) == folder_of(&self.model) {
            return Ok(file.file_name().unwrap_or_default().to_string_lossy().into_owned());
        }
        let message = format!("{} lies in another folder than {}", file.display(), self.model.display());
        Err(Failure::usage(message, "put both into one folder: the written stage names files in its own folder"))
    }

    pub(super) fn check(&self, input: &Input) -> Result<(), Failure> {
        let mut places = Places::of_input(input);
        places.write_as(&self.model, "the baked model")?;
        self.stage.as_ref().map_or(Ok(()), |path| places.write_as(path, "the stage of the baked model"))
    }
}

/// The folder in which a file is, if there is one.
fn folder_of(path: &Path) -> Option<PathBuf> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::canonicalize(parent).ok()
}

/// A stage names files from its own folder, so that its copy can be nowhere else.
pub(super) fn check_folder(path: &Path, stage: &Stage, output: &Path) -> Result<(), Failure> {
    let names_files = !stage.images().is_empty() || stage.names_light();
    if names_files && folder_of(path) != folder_of(output) {
        let message =
            format!("{} names files in its folder, which {} would not find", path.display(), output.display());
        let beside = path.with_file_name(output.file_name().unwrap_or_default());
        return Err(Failure::usage(message, format!("write -o {}", beside.display())));
    }
    Ok(())
}
