//! `diff`: how different two pictures look, or what of two models is different.

mod linear;
mod models;
mod report;
mod sheet;
mod source;
mod swatch;
mod variables;

use crate::args::diff::DiffArgs;
use crate::failure::{Failure, Kind};
use crate::inspect::one;
use crate::output;
use crate::pattern::is_stdout;
use crate::places::Places;
use crate::request::effect_files;
use crate::session::print;
use linear::Linear;
use manypass_flip::{ErrorMap, Exposures, FlipError, hdr, ldr};
use manypass_offline::decode::Light;
use manypass_offline::{AovLayer, CameraData, atomic};
use manypass_scene::formats::is_model;
use models::{Models, Placement};
use source::Source;
use std::path::Path;
use variables::Variables;

/// Two pictures and how they differ.
#[derive(Debug)]
struct Comparison {
    a: Source,
    b: Source,
    map: ErrorMap,
    /// Of radiance alone.
    exposures: Option<Exposures>,
    pixels_per_degree: f32,
    /// Of radiance alone.
    linear: Option<Linear>,
    /// Of models alone.
    models: Option<Compared>,
}

/// How two models differ.
#[derive(Debug)]
struct Compared {
    layers: [Vec<AovLayer>; 2],
    camera: CameraData,
    placement: Placement,
    variables: Variables,
}

/// Runs `diff`.
///
/// # Errors
/// Wrong usage, an input that cannot be read or an output that cannot be written, or a difference above the threshold.
pub fn diff(args: &DiffArgs) -> Result<(), Failure> {
    let are_models = are_models(args)?;
    if let Some(path) = &args.output {
        check_output(path)?;
        places(args, are_models)?.write(path)?;
    }
    let comparison = if are_models {
        compare_models(models::draw(args)?, args.pixels_per_degree)?
    } else {
        let (a, b) = (Path::new(&args.a), Path::new(&args.b));
        compare(Source::read(a)?, Source::read(b)?, args.pixels_per_degree)?
    };
    if let Some(path) = &args.output {
        output::write_file(path, &sheet::png(&comparison)?)?;
    }
    print(&if args.json { report::json(&comparison, args) } else { report::text(&comparison) })?;
    match args.threshold.filter(|threshold| comparison.map.mean() > *threshold) {
        None => Ok(()),
        Some(threshold) => {
            let message = format!("the mean FLIP {:.6} is above --threshold {threshold}", comparison.map.mean());
            let hint = match &args.output {
                Some(path) => format!("{} shows where", path.display()),
                None => "write -o diff.png to see where".into(),
            };
            Err(Failure::new(Kind::Different, message, hint))
        }
    }
}

fn compare(a: Source, b: Source, pixels_per_degree: f32) -> Result<Comparison, Failure> {
    if a.light != b.light {
        let is = |light| if light == Light::Scene { "holds radiance" } else { "is for a display" };
        let message = format!("{} {}, but {} {}", a.name, is(a.light), b.name, is(b.light));
        return Err(Failure::usage(message, "compare EXR with EXR, or write both as PNG"));
    }
    let (size_a, size_b) = (a.picture.size(), b.picture.size());
    if size_a != size_b {
        let sized = |name: &str, (width, height): (usize, usize)| format!("{name} has {width}x{height} pixels");
        let message = format!("{}, but {}", sized(&a.name, size_a), sized(&b.name, size_b));
        return Err(Failure::usage(message, "render or scale both to one size; nothing is scaled here"));
    }
    let failed = |error: FlipError| Failure::usage(error, "see `manypass diff --help`");
    let linear = (a.light == Light::Scene).then(|| Linear::of(&a, &b));
    let (map, exposures) = match a.light {
        Light::Display => (ldr(&a.picture, &b.picture, pixels_per_degree).map_err(failed)?, None),
        Light::Scene => {
            let (map, exposures) = hdr(&a.picture, &b.picture, pixels_per_degree).map_err(failed)?;
            (map, Some(exposures))
        }
    };
    Ok(Comparison { a, b, map, exposures, pixels_per_degree, linear, models: None })
}

fn compare_models(models: Models, pixels_per_degree: f32) -> Result<Comparison, Failure> {
    let variables = variables::compare(&models);
    let Models { a, b, layers, camera, placement, .. } = models;
    let compared = Compared { layers, camera, placement, variables };
    Ok(Comparison { models: Some(compared), ..compare(a, b, pixels_per_degree)? })
}

/// Whether two models are compared, and not two pictures.
///
/// # Errors
/// One of each, or flags of models with pictures.
fn are_models(args: &DiffArgs) -> Result<bool, Failure> {
    if [&args.a, &args.b].into_iter().any(String::is_empty) {
        return Err(Failure::usage("the name of a picture is empty", "name two pictures, or two models"));
    }
    let are_models = [&args.a, &args.b].map(|name| is_model_name(name));
    match are_models {
        [true, true] => Ok(true),
        [false, false] if args.describes_models() => {
            let message = format!("{} and {} are pictures, and some flags are for models", args.a, args.b);
            Err(Failure::usage(message, "leave flags of the camera, the light and the frame out"))
        }
        [false, false] => Ok(false),
        [a_is_model, _] => {
            let (model, picture) = if a_is_model { (&args.a, &args.b) } else { (&args.b, &args.a) };
            let message = format!("{model} is a model, but {picture} is a picture");
            Err(Failure::usage(message, format!("render it first: `manypass render {model} -o model.png`")))
        }
    }
}

fn is_model_name(name: &str) -> bool {
    name.starts_with("demo:")
        || is_model(Path::new(name))
        || Path::new(name).extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"))
}

/// What is read.
fn places(args: &DiffArgs, are_models: bool) -> Result<Places, Failure> {
    if !are_models {
        return Ok(Places::of_pictures(&[Path::new(&args.a), Path::new(&args.b)]));
    }
    let effects = effect_files(&args.frame.change.effects)?;
    Ok(Places::of_models(&[one(&args.a)?, one(&args.b)?], &args.frame, &effects))
}

fn check_output(path: &Path) -> Result<(), Failure> {
    if is_stdout(path) {
        let hint = "standard output takes the numbers; write -o FILE.png";
        return Err(Failure::usage("the sheet cannot go to standard output", hint));
    }
    let is_png = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("png")) || atomic::is_in_place(path);
    if is_png {
        return Ok(());
    }
    Err(Failure::usage(format!("-o {} does not end in .png", path.display()), "write -o FILE.png"))
}
