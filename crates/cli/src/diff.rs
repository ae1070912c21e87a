//! `diff`: how different two pictures look.

mod args;
mod report;
mod sheet;
mod source;

pub use args::{DiffArgs, EXAMPLES};

use crate::failure::{Failure, Kind};
use crate::output;
use crate::pattern::is_stdout;
use crate::places::Places;
use crate::session::print;
use manypass_flip::{ErrorMap, Exposures, FlipError, hdr, ldr};
use manypass_offline::atomic;
use manypass_offline::decode::Light;
use manypass_scene::formats::is_model;
use source::Source;
use std::path::Path;

/// Two pictures and how they differ.
#[derive(Debug)]
struct Comparison {
    a: Source,
    b: Source,
    map: ErrorMap,
    /// Of radiance alone.
    exposures: Option<Exposures>,
    pixels_per_degree: f32,
}

/// Runs `diff`.
///
/// # Errors
/// Wrong usage, an input that cannot be read or an output that cannot be written, or a difference above the threshold.
pub fn diff(args: &DiffArgs) -> Result<(), Failure> {
    for name in [&args.a, &args.b] {
        check_input(name)?;
    }
    let (a, b) = (Path::new(&args.a), Path::new(&args.b));
    if let Some(path) = &args.output {
        check_output(path)?;
        Places::of_pictures(&[a, b]).write(path)?;
    }
    let comparison = compare(Source::read(a)?, Source::read(b)?, args.pixels_per_degree)?;
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
    let (map, exposures) = match a.light {
        Light::Display => (ldr(&a.picture, &b.picture, pixels_per_degree).map_err(failed)?, None),
        Light::Scene => {
            let (map, exposures) = hdr(&a.picture, &b.picture, pixels_per_degree).map_err(failed)?;
            (map, Some(exposures))
        }
    };
    Ok(Comparison { a, b, map, exposures, pixels_per_degree })
}

fn check_input(name: &str) -> Result<(), Failure> {
    if name.is_empty() {
        return Err(Failure::usage("the name of a picture is empty", "name two files"));
    }
    let is_model = name.starts_with("demo:")
        || is_model(Path::new(name))
        || Path::new(name).extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    if is_model {
        let hint = "render both with the same flags, `manypass render A B -o '{stem}.exr'`, and compare those";
        return Err(Failure::usage(format!("diff compares pictures, and {name} is a model"), hint));
    }
    Ok(())
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
