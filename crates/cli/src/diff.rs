//! `diff`: how different two pictures look, or what of two models is different.

mod comparison;
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
use manypass_offline::atomic;
use manypass_scene::formats::is_model;
use source::Source;
use std::path::Path;

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
        comparison::drawn(models::draw(args)?, args.pixels_per_degree)?
    } else {
        let (a, b) = (Path::new(&args.a), Path::new(&args.b));
        comparison::pictures(Source::read(a)?, Source::read(b)?, args.pixels_per_degree)?
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
