//! `bake`: light that is computed beforehand, as a glTF file.

mod bakers;
mod journal;
mod outputs;
mod progress;
mod report;

use crate::args::bake::BakeArgs;
use crate::args::{ChangeArgs, FrameArgs};
use crate::chosen::SettingsChoice;
use crate::failure::{Failure, Kind, say};
use crate::input::{Input, InputScene};
use crate::inspect::one;
use crate::older::{self, ToldNames};
use crate::output;
use crate::session::{ms_since, print};
use crate::stage::model_hint;
use crate::surroundings::Surroundings;
use crate::{interrupt, scenes};
use bakers::{BakeRequest, BakeResults, Bakers};
use glam::Vec3;
use journal::Journal;
use manypass::{Environment, EnvironmentRadiance, Settings};
use manypass_bake::{BakeError, DistantLight, Encoding, Surfaces, picture_file};
use manypass_scene::gltf_file::{Parts, put_extra};
use manypass_scene::stage::is_stage;
use manypass_scene::{EnvironmentLight, LightMode, Scene, Stage};
use outputs::{Outputs, check_folder};
use progress::Bar;
use report::Report;
use serde_json::{Value, json};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The environment as a bake asks for it.
struct Surround(EnvironmentRadiance);

impl DistantLight for Surround {
    fn key(&self) -> u64 {
        self.0.key()
    }

    fn radiance(&self, direction: Vec3) -> Vec3 {
        self.0.at(direction)
    }

    fn light(&self) -> Option<EnvironmentLight> {
        self.0.light()
    }
}

/// Runs `bake`; `started` is when the process started.
///
/// # Errors
/// Wrong usage, an input that cannot be read, nothing to bake, or an output that cannot be written.
pub fn bake(args: &BakeArgs, started: Instant) -> Result<(), Failure> {
    let input = one(&args.input)?;
    let outputs = Outputs::new(args, &input)?;
    outputs.check(&input)?;
    let wanted = BakeRequest::new(args)?;
    if let Some(pair) = args.set.iter().find(|pair| !pair.trim_start().starts_with("environment.")) {
        let message = format!("`--set {pair}` does not affect the bake");
        return Err(Failure::usage(message, "`bake` takes settings of the environment alone: environment.KEY=VALUE"));
    }
    interrupt::heed(args.quiet);
    // The folder is made, and what cannot be written is known, before anything is computed.
    drop(output::begin(&outputs.model)?);
    let (mut scene, mut warnings, stage, mut parts) = open(&input)?;
    let frame = FrameArgs {
        around: args.around.clone(),
        change: ChangeArgs { set: args.set.clone(), ..ChangeArgs::default() },
        ..FrameArgs::default()
    };
    let chosen = SettingsChoice::of_frame(&frame)?.meeting_stages(stage.is_some());
    let (settings, _) = chosen.settings(Settings::default(), stage.as_ref())?;
    warnings.extend(Surroundings::new(None).prepare(&mut scene, &settings)?);
    scenes::show(&mut scene, args.scene.as_deref(), &mut warnings)?;
    wanted.bring_near(&mut scene);
    let mode = if wanted.as_emission() { Some("baked") } else { args.lights.as_deref() };
    if let Some(mode) = mode.and_then(LightMode::named) {
        set_modes(&mut scene, &mut parts, mode);
    }
    if let (Input::File(path), Some(stage)) = (&input, &stage) {
        check_folder(path, stage, &outputs.model)?;
    }
    let stage_text = outputs.stage_text(stage.as_ref(), &settings, args)?;
    let source = environment_name(&settings, &scene);
    say_what_is_baked(args, (&input, stage.as_ref()), &settings, source);
    let around = EnvironmentRadiance::new(&settings.environment, &scene).map(Surround);
    let around = around.as_ref().map(|around| around as &dyn DistantLight);
    let bar = Bar::new(args.quiet, &wanted);
    let surfaces = Surfaces::new(&scene);
    let in_input = |error: BakeError| {
        bar.finish();
        failed(&input, &error)
    };
    let grids = wanted.grids(&scene, stage.as_ref(), args)?;
    let places = wanted.places(&scene);
    let baker = Bakers::new(&scene, &surfaces, around, (&wanted, grids, places), &bar).map_err(in_input)?;
    let encoding = Encoding::named(&args.encoding).unwrap_or_default();
    let key = key(&baker, &parts, encoding);
    if outputs.are_of(&key, stage_text.as_deref()) {
        bar.finish();
        return say_up_to_date(args, &outputs);
    }
    let journal = Journal::open(&outputs.model, baker.key(), args.quiet);
    let found = match baker.run(&bar, &journal) {
        Ok(found) => found,
        Err(BakeError::Interrupted) if journal.remove_if_empty() => return Err(interrupted(&bar, false)),
        Err(BakeError::Interrupted) => return Err(interrupted(&bar, true)),
        Err(error) => return Err(in_input(error)),
    };
    bar.finish();
    warnings.extend(found.maps.iter().flat_map(|maps| maps.notes.iter().cloned()));
    let before = parts.json["asset"]["extras"]["bake"].clone();
    let provenance = provenance((&wanted, &before), (&key, &args.encoding, source), &found);
    put_extra(&mut parts.json["asset"], "bake", provenance);
    put(&mut parts, &scene, (&wanted, &found), encoding).map_err(|error| failed(&input, &error))?;
    let bytes = parts.to_glb().ok_or_else(|| {
        let message = format!("{} would be larger than 4 GiB", outputs.model.display());
        Failure::new(Kind::Failed, message, "lower --density")
    })?;
    if let Err(failure) = outputs.write(&bytes, stage_text.as_deref()) {
        journal.leave();
        return Err(failure);
    }
    journal.remove();
    if !args.quiet {
        warnings.iter().for_each(|warning| say(format_args!("warning: {}: {warning}", input.name())));
    }
    let report =
        Report { found: &found, outputs: &outputs, warnings: &warnings, ms: ms_since(started), bytes: bytes.len() };
    match (args.json, args.quiet) {
        (true, _) => print(&format!("{:#}\n", report.json())),
        (false, true) => Ok(()),
        (false, false) => {
            say(format_args!("{}", report.text()));
            Ok(())
        }
    }
}

/// Puts what was found into the file.
///
/// # Errors
/// A picture cannot be encoded.
fn put(
    parts: &mut Parts,
    scene: &Scene,
    (wanted, found): (&BakeRequest, &BakeResults),
    encoding: Encoding,
) -> Result<(), BakeError> {
    if let Some(maps) = &found.maps {
        maps.write(parts, scene, encoding)?;
    }
    // What those of a bake before leave behind.
    let kept = parts.unreferenced();
    if wanted.probes.is_some() {
        parts.put_probes(&found.grids);
    }
    if wanted.surroundings.is_some() {
        parts.put_surroundings(&found.places, picture_file)?;
    }
    parts.prune(&kept);
    Ok(())
}

/// Says that there is nothing to do.
fn say_up_to_date(args: &BakeArgs, outputs: &Outputs) -> Result<(), Failure> {
    if args.json {
        let report = json!({ "output": outputs.model, "stage": outputs.stage, "up_to_date": true });
        print(&format!("{report:#}\n"))?;
    } else if !args.quiet {
        say(format_args!("{} is up to date: it is of the same scene and flags", outputs.model.display()));
    }
    Ok(())
}

/// What an output is of: the light, and the file that it is put into.
fn key(baker: &Bakers, parts: &Parts, encoding: Encoding) -> String {
    let mut hasher = DefaultHasher::new();
    hasher.write_u64(baker.key());
    encoding.hash(&mut hasher);
    parts.hash_into(&mut hasher);
    format!("{:016x}", hasher.finish())
}

/// What the file says of its maps and probes.
fn provenance(
    (wanted, before): (&BakeRequest, &Value),
    (key, encoding, source): (&str, &str, &str),
    found: &BakeResults,
) -> Value {
    let mut extras = json!({ "key": key, "environment": source });
    // What stays in the file of a bake before.
    let of_maps = ["texelsPerMetre", "samples", "emission", "lightMap", "occlusionDistance"];
    let stays = |key: &str| match key {
        "probes" => wanted.probes.is_none(),
        "surroundings" => wanted.surroundings.is_none(),
        _ => wanted.maps.is_none() && of_maps.contains(&key),
    };
    for (key, value) in before.as_object().into_iter().flatten().filter(|(key, _)| stays(key)) {
        extras[key] = value.clone();
    }
    if let (Some(settings), Some(maps)) = (&wanted.maps, &found.maps) {
        extras["texelsPerMetre"] = maps.layout.texels_per_m.into();
        extras["samples"] = settings.samples.into();
        if settings.as_emission {
            extras["emission"] = json!({ "bounces": settings.bounces });
        } else if settings.light {
            extras["lightMap"] = json!({
                "encoding": encoding,
                "color": "linear Rec. 709",
                "unit": "irradiance / pi: the radiance that a white surface reflects, in the units of the lights",
                "bounces": settings.bounces,
            });
            if settings.directional {
                extras["lightMap"]["directions"] =
                    "the mean of unit directions in world space, weighted by irradiance".into();
            }
        }
        if settings.occlusion && settings.occlusion_distance_m.is_finite() {
            extras["occlusionDistance"] = settings.occlusion_distance_m.into();
        }
    }
    if let Some((settings, _)) = &wanted.probes {
        extras["probes"] = json!({ "samples": settings.samples, "bounces": settings.bounces });
    }
    if let (Some((settings, _)), false) = (&wanted.surroundings, found.places.is_empty()) {
        extras["surroundings"] = json!({ "samples": settings.samples, "bounces": settings.bounces });
    }
    extras
}

fn failed(input: &Input, error: &BakeError) -> Failure {
    let hint = match error {
        BakeError::Interrupted => {
            return Failure::new(
                Kind::Interrupted,
                "interrupted",
                "nothing was found yet; the same command begins anew",
            );
        }
        BakeError::Setting(_) => return Failure::usage(error, "see `manypass bake --help`"),
        BakeError::Nothing => "name a model with triangles that are opaque and stand still",
        BakeError::TooLarge { .. } => "lower --density",
        BakeError::Layout(_) | BakeError::Encode(_) => "lower --density, or raise --side-max",
    };
    Failure::new(Kind::Failed, format!("{}: {error}", input.name()), hint)
}

fn interrupted(bar: &Bar, is_kept: bool) -> Failure {
    bar.finish();
    let hint = match is_kept {
        true => "the same command goes on from where it was",
        false => "nothing was found yet; the same command begins anew",
    };
    Failure::new(Kind::Interrupted, "interrupted", hint)
}

/// Tells of older names, and that a file without lights has the light of the studio baked, which nobody asked for.
fn say_what_is_baked(args: &BakeArgs, (input, stage): (&Input, Option<&Stage>), settings: &Settings, source: &str) {
    if !args.quiet {
        ToldNames::default().say(&input.name(), &older::of_input(input, stage));
    }
    if source == "studio" && settings.environment.source == Environment::Auto && !args.quiet {
        let what = "it has no lights, so the light of the studio is baked; --environment none leaves it out";
        say(format_args!("hint: {}: {what}", input.name()));
    }
}

/// What lay around the scene: the word of the setting, or `color`.
fn environment_name(settings: &Settings, scene: &Scene) -> &'static str {
    match settings.environment.source.resolved(scene) {
        Environment::Auto | Environment::Studio => "studio",
        Environment::None | Environment::Fill => "none",
        Environment::Sky => "sky",
        Environment::File => "file",
        Environment::Color(_) => "color",
    }
}

/// The scene of an input, what its reader warns of, its stage, and its model as a file that can be written.
fn open(input: &Input) -> Result<(Scene, Vec<String>, Option<Stage>, Parts), Failure> {
    let InputScene { scene, mut warnings, stage } = input.load()?;
    let model = match (input, &stage) {
        (Input::File(path), Some(stage)) if is_stage(path) => {
            let folder = path.parent().unwrap_or(Path::new(""));
            (!stage.model().starts_with("demo:")).then(|| folder.join(stage.model()))
        }
        (Input::File(path), _) => Some(path.clone()),
        (Input::Stdin | Input::Demo(_), _) => None,
    };
    let is_gltf = |path: &PathBuf| {
        path.extension().is_some_and(|end| end.eq_ignore_ascii_case("glb") || end.eq_ignore_ascii_case("gltf"))
    };
    let parts = match model.filter(is_gltf) {
        Some(path) => {
            Parts::read_path(&path).map_err(|error| Failure::new(Kind::Failed, &error, model_hint(&error)))?
        }
        None => {
            // What a stage adds is in its copy.
            let unstaged = stage.as_ref().map(|stage| unstaged(input, stage)).transpose()?;
            let (parts, notes) = Parts::of_scene(unstaged.as_ref().unwrap_or(&scene));
            warnings.extend(notes.into_iter().map(|note| format!("in the file that is written, {note}")));
            parts
        }
    };
    Ok((scene, warnings, stage, parts))
}

/// The model of a stage, without what the stage adds to it.
fn unstaged(input: &Input, stage: &Stage) -> Result<Scene, Failure> {
    let model = match (stage.model().strip_prefix("demo:"), input) {
        (Some(name), _) => Input::Demo(name.to_owned()),
        (None, Input::File(path)) => Input::File(path.with_file_name(stage.model())),
        (None, Input::Stdin | Input::Demo(_)) => return Err(Failure::usage("the stage has no model", "name one")),
    };
    Ok(model.load()?.scene)
}

/// Gives the lights of the file a mode. Those of a stage have theirs there.
fn set_modes(scene: &mut Scene, parts: &mut Parts, mode: LightMode) {
    let lights = parts.json.pointer_mut("/extensions/KHR_lights_punctual/lights").and_then(Value::as_array_mut);
    for (light, json) in scene.lights.iter_mut().zip(lights.into_iter().flatten()) {
        light.mode = mode;
        put_extra(json, "mode", mode.name().into());
    }
}
