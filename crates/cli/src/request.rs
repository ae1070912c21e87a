//! What the renderer is asked for: flags as settings, effects and a request.

use crate::args::RenderArgs;
use crate::failure::{Failure, Kind};
use crate::job::Job;
use crate::shot::time_secs;
use manypass::shader::ProgramError;
use manypass::{Averaging, Effect, EffectFile, EffectStage, FrameRequest, Renderer, Settings, View, WgslEffect};
use manypass_offline::still::aov_named;
use manypass_offline::{CameraData, Format, PictureInfo, manifest};
use manypass_scene::{Scene, input_file};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The largest file of settings, and the largest effect: 4 MiB.
const MOST_TEXT_BYTES: u64 = 4 << 20;

/// The largest table of colours: of 128 along each side, a line has 30 bytes.
const MOST_TABLE_BYTES: u64 = 64 << 20;

/// The effects in files, checked without a device.
///
/// # Errors
/// A file that cannot be read or is no effect, with its place; two effects of one name, whose settings and passes
/// nobody could tell apart.
pub fn effect_files(paths: &[PathBuf]) -> Result<Vec<EffectFile>, Failure> {
    let mut effects: Vec<EffectFile> = Vec::new();
    for path in paths {
        let file = path.display().to_string();
        let effect = match EffectFile::built_in(&file) {
            Some(built_in) => built_in.map_err(|error| program_failure(&error, "report this"))?,
            None if path.extension().is_none() && path.components().count() == 1 && !path.exists() => {
                return Err(Failure::usage(EffectFile::unknown_name(&file, std::iter::empty()), effect_names()));
            }
            None => read_effect(path)?,
        };
        if let Some(other) = effects.iter().find(|other| other.name() == effect.name()) {
            if other.file() == file {
                return Err(Failure::usage(
                    format!("the effect `{file}` is there twice"),
                    "leave one out; to run a file twice, copy it and give the copy another name, in its first line: \
                     `//! effect NAME`",
                ));
            }
            return Err(Failure::usage(
                format!("two effects are called `{}`: {} and {file}", effect.name(), other.file()),
                "give one another name, in its first line: `//! effect NAME`",
            ));
        }
        effects.push(effect);
    }
    Ok(effects)
}

/// The effect of a file.
///
/// # Errors
/// It cannot be read, or is no effect, with the place.
pub fn read_effect(path: &Path) -> Result<EffectFile, Failure> {
    let text = read_text(path, &effect_names())?;
    let is_table = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("cube"));
    let hint = if is_table { "correct the table of colours" } else { "correct the WGSL file" };
    EffectFile::parse(&path.display().to_string(), &text).map_err(|error| program_failure(&error, hint))
}

/// What names an effect.
pub fn effect_names() -> String {
    let names: Vec<_> = EffectFile::built_in_names().collect();
    format!("name a WGSL file, or a built-in effect: {}", names.join(", "))
}

/// The effects, compiled for the renderer's device.
///
/// # Errors
/// What the device refuses.
pub fn effects(renderer: &Renderer, files: Vec<EffectFile>) -> Result<Vec<Arc<dyn Effect>>, Failure> {
    let compile = |file| WgslEffect::compile(renderer.gpu(), file).map(|effect| Arc::new(effect) as Arc<dyn Effect>);
    let effects: Result<_, _> = files.into_iter().map(compile).collect();
    effects.map_err(|error| program_failure(&error, "correct the WGSL file"))
}

/// Warnings of effects: words too many in their headers, names that hide settings of the frame or built-in effects, and
/// what pictures of `format` do not show.
pub fn effect_warnings(files: &[EffectFile], format: Format) -> Vec<String> {
    let of_headers: Vec<String> = files.iter().flat_map(|file| file.warnings().iter().cloned()).collect();
    [of_headers, hidden_settings(files), hidden_effects(files), unseen_effects(files, format)].concat()
}

/// Warnings of effects that are called like settings of the frame: those cannot be reached beside them.
fn hidden_settings(files: &[EffectFile]) -> Vec<String> {
    let is_group = |name: &str| Settings::declared().iter().any(|info| info.key.split('.').next() == Some(name));
    let hidden = files.iter().map(EffectFile::name).filter(|name| is_group(name));
    hidden
        .map(|name| format!("the effect `{name}` is called like settings of the frame and hides `{name}.*`; rename it"))
        .collect()
}

/// Warnings of effects that are called like built-in ones, in whose place they are drawn.
fn hidden_effects(files: &[EffectFile]) -> Vec<String> {
    let hides = |file: &&EffectFile| EffectFile::is_built_in(file.name()) && file.file() != file.name();
    let warning = |file: &EffectFile| {
        let (name, path) = (file.name(), file.file());
        format!(
            "{path} is drawn in place of the built-in effect `{name}`; for both give it another name: `//! effect NAME`"
        )
    };
    files.iter().filter(hides).map(warning).collect()
}

/// What the report says of an effect.
pub fn effect_values(file: &EffectFile) -> serde_json::Value {
    let settings: std::collections::BTreeMap<_, _> = file.values().into_iter().collect();
    let path = Some(file.file()).filter(|path| !EffectFile::is_built_in(path));
    serde_json::json!({ "path": path, "name": file.name(), "settings": settings })
}

/// The text of a file that somebody wrote.
///
/// # Errors
/// It cannot be read, is too large or no text.
pub fn read_text(path: &Path, hint: &str) -> Result<String, Failure> {
    let failed =
        |error: &dyn std::fmt::Display| Failure::new(Kind::Failed, format!("{}: {error}", path.display()), hint);
    let is_table = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("cube"));
    let most_bytes = if is_table { MOST_TABLE_BYTES } else { MOST_TEXT_BYTES };
    input_file::read_text(path, most_bytes).map_err(|error| failed(&error))
}

/// What a wrong shader means to the user.
pub fn program_failure(error: &ProgramError, hint: &str) -> Failure {
    match error {
        ProgramError::Text(diagnostic) => Failure::located(Kind::Failed, diagnostic, hint),
        error => Failure::new(Kind::Failed, error, hint),
    }
}

/// Warnings of effects that nobody will see in pictures of a format.
fn unseen_effects(files: &[EffectFile], format: Format) -> Vec<String> {
    let of_display = files.iter().filter(|file| format == Format::Exr && file.stage() == EffectStage::Display);
    let warning = |file: &EffectFile| {
        format!("the effect `{}` changes display colours; an EXR file holds radiance, and is without it", file.name())
    };
    of_display.map(warning).collect()
}

/// The request of one picture.
pub fn request(args: &RenderArgs, job: &Job, settings: &Settings, camera: View, scene: &Scene) -> FrameRequest {
    FrameRequest {
        sample_count: args.frame.samples,
        settings: settings.clone(),
        averaging: if job.format == Format::Exr { Averaging::Radiance } else { Averaging::Display },
        want_aovs: job.aovs.iter().filter_map(|name| aov_named(name)).collect(),
        overlay: scene.overlay.clone(),
        origin_m: scene.origin_m,
        // `exposure::expose` puts in what is metered once for all pictures of an input.
        ..FrameRequest::new(job.width, job.height, camera)
    }
    .resolved(scene)
}

/// What headers and reports say of a picture; `frame` is its number in a sequence.
pub fn picture_info(
    args: &RenderArgs,
    job: &Job,
    request: &FrameRequest,
    scene: &Scene,
    frame: Option<u32>,
) -> PictureInfo {
    // An animation that is asked for without a time stands at its beginning.
    let stands = args.animation.as_ref().filter(|_| !scene.animations.is_empty()).map(|_| 0.0);
    let time_secs = time_secs(args, frame.unwrap_or(0)).or(stands);
    let wants = |name: &str| job.format == Format::Exr && job.aovs.iter().any(|aov| aov == name);
    PictureInfo {
        compression: job.compression,
        camera: Some(CameraData::of(request)),
        frame,
        time_secs,
        frames_per_second: time_secs.map(|_| args.fps),
        exposure_stops: Some(request.exposure_stops()),
        object_ids: wants("object_id").then(|| manifest::object_ids(scene)),
        material_ids: wants("material_id").then(|| manifest::material_ids(scene)),
    }
}
