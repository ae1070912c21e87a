//! The command line, checked and typed: everything that can be refused without reading a file or a GPU is refused here.

use crate::args::{FrameArgs, RenderArgs};
use crate::camera::CameraSpec;
use crate::failure::Failure;
use crate::looks::{self, Look, PictureAxes};
use crate::pattern::Pattern;
use crate::size;
use crate::views::{self, Views};
use manypass::{Background, Fisheye, Settings, SettingsError};
use manypass_offline::{Container, ExrCompression, Format, atomic};
use std::path::{Path, PathBuf};

mod camera;
mod output;
mod stream;

pub use output::Output;
pub use stream::StreamPlace;

/// A checked `render`.
#[derive(Debug)]
pub struct Job {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The camera and the variant, as far as they are known without the file.
    pub look: Look,
    /// What one input has several pictures by.
    pub several: PictureAxes,
    /// The kind of file.
    pub format: Format,
    /// How the pixels of .exr are packed.
    pub compression: ExrCompression,
    /// Where it goes.
    pub output: Output,
    /// Whether it is standard output, a device, a pipe or a stream, in which nothing can go back.
    pub is_one_stream: bool,
    /// The folder of the pictures of all passes.
    pub dump_passes: Option<Pattern>,
    /// The file of the pictures of all passes.
    pub contact_sheet: Option<Pattern>,
    /// Names of AOVs.
    pub aovs: Vec<String>,
    /// The frames, both ends included; none is a still.
    pub frames: Option<(u32, u32)>,
    /// The views of `--cameras`; none without it, and until they are read.
    pub views: Views,
}

impl Job {
    /// Checks `args`; `several` says that there is more than one input.
    ///
    /// # Errors
    /// Wrong usage.
    pub fn new(args: &RenderArgs, several: bool, aov_names: &[&str]) -> Result<Self, Failure> {
        let (width, height) = size::parse(&args.frame.size)?;
        let frames = match (&args.frames, args.turntable) {
            (Some(text), _) => Some(frame_range(text)?),
            (None, Some(count)) => Some((0, count.saturating_sub(1))),
            (None, None) => None,
        };
        let looks = PictureAxes::looks(&args.frame);
        let cameras = looks.cameras || args.cameras.is_some();
        let of_one = PictureAxes { cameras, frames: frames.is_some(), ..looks };
        let frame_count = frames.map_or(1, |(a, b)| u64::from(b - a) + 1);
        let (format, output) = output::of_args(args, several || of_one.has_looks() || frame_count > 1, of_one)?;
        let pattern = |flag: &str, path: &Option<PathBuf>| {
            path.as_ref().map(|path| Pattern::of_flag(flag, path, of_one, &args.frame)).transpose()
        };
        let dump_passes = pattern("--dump-passes", &args.dump_passes)?;
        let contact_sheet = pattern("--contact-sheet", &args.contact_sheet)?;
        check_numbers(args)?;
        let compression = compression(args, format)?;
        let aovs = aovs(args.frame.aov.as_deref(), aov_names)?;
        if !aovs.is_empty() && output.container() == Some(Container::Y4m) {
            return Err(Failure::usage("y4m holds no AOVs", "write npz or tar, or -o OUT.exr"));
        }
        if !aovs.is_empty() && !matches!(format, Format::Png | Format::Exr) {
            return Err(Failure::usage("--aov needs .png or .exr", "use -o OUT.exr for all AOVs in one file"));
        }
        let is_one_stream = match &output {
            Output::Stdout | Output::Stream(_) => true,
            Output::Pattern(pattern) => atomic::is_in_place(pattern.text().as_ref()),
        };
        if !aovs.is_empty() && is_one_stream && format != Format::Exr && output.container().is_none() {
            let hint = "add --format exr, npz or tar";
            return Err(Failure::usage("only .exr holds AOVs on standard output or in a device", hint));
        }
        let look = looks::typed(&args.frame, &camera::spec(&args.frame, args.turntable.is_some())?);
        Ok(Self {
            width,
            height,
            look,
            several: of_one,
            format,
            compression,
            output,
            is_one_stream,
            dump_passes,
            contact_sheet,
            aovs,
            frames,
            views: Views::default(),
        })
    }

    /// Reads the views of `--cameras`, if it names any.
    ///
    /// # Errors
    /// They cannot be read, or have a fault.
    pub fn read_views(&mut self, path: Option<&Path>) -> Result<(), Failure> {
        let Some(path) = path else { return Ok(()) };
        self.views = views::read(path, (self.width, self.height), &self.look.camera)?;
        // No view is an automatic one, about which there would be hints.
        if let Some((camera, _)) = self.views.cameras.first() {
            self.look.camera = camera.clone();
        }
        Ok(())
    }

    /// Checks what settings decide, wherever they come from.
    ///
    /// # Errors
    /// Wrong usage.
    pub fn check(&self, settings: &Settings) -> Result<(), Failure> {
        let is_transparent = settings.background.source == Background::Transparent;
        if self.output.container() == Some(Container::Y4m) && is_transparent {
            let hint = "write npz or tar, or choose another --background, such as 000000";
            return Err(Failure::usage("y4m has no transparency", hint));
        }
        if self.format == Format::Jpg && is_transparent {
            let hint = "write .png, .webp or .exr, or choose another --background";
            return Err(Failure::usage("jpg has no transparency", hint));
        }
        check_aovs(!self.aovs.is_empty(), settings)
    }
}

/// Checks that settings go together and are those of stills, once those of a stage are among them.
///
/// # Errors
/// Wrong usage.
pub fn check_settings(settings: &Settings) -> Result<(), Failure> {
    if settings.quality.budget_ms > 0.0 {
        let message = format!("quality.budget_ms={} is for live drawing", settings.quality.budget_ms);
        let hint = "the page and `manypass bench --live` take it; here leave it out, or --set quality.budget_ms=0";
        return Err(Failure::usage(message, hint));
    }
    check_live_settings(settings)
}

/// Checks whether settings go together, where frames are drawn live.
///
/// # Errors
/// Wrong usage.
pub fn check_live_settings(settings: &Settings) -> Result<(), Failure> {
    settings.check().map_err(|error| match error {
        SettingsError::BadValue { .. } => Failure::usage(error, "correct it, or leave it out"),
        error => Failure::usage(error, "set both, or leave the first one out"),
    })
}

/// Checks that there are AOVs where any are wanted.
///
/// # Errors
/// Wrong usage.
pub fn check_aovs(are_wanted: bool, settings: &Settings) -> Result<(), Failure> {
    if are_wanted && settings.render.path != manypass::Path::Deferred {
        return Err(Failure::usage("only --path deferred has AOVs", "leave --path, render.path or --aov out"));
    }
    if are_wanted && settings.camera.fisheye != Fisheye::None {
        return Err(Failure::usage("a fisheye picture has no AOVs", "leave camera.fisheye or --aov out"));
    }
    Ok(())
}

/// How the pixels of .exr are packed.
fn compression(args: &RenderArgs, format: Format) -> Result<ExrCompression, Failure> {
    let Some(name) = &args.exr_compression else { return Ok(ExrCompression::default()) };
    if format != Format::Exr {
        return Err(Failure::usage("--exr-compression is of .exr", "write -o OUT.exr, or leave it out"));
    }
    ExrCompression::named(name).ok_or_else(|| {
        let names = ExrCompression::NAMES.join(", ");
        Failure::usage(format!("unknown compression `{name}`"), format!("known: {names}"))
    })
}

fn check_numbers(args: &RenderArgs) -> Result<(), Failure> {
    let checks = [
        ("--fps", args.fps, args.fps.is_finite() && args.fps > 0.0, "a number above 0"),
        ("--time", args.time.unwrap_or(0.0), args.time.is_none_or(f32::is_finite), "finite seconds"),
    ];
    if let Some((flag, value, _, expected)) = checks.into_iter().find(|check| !check.2) {
        return Err(Failure::usage(format!("{flag} {value} is out of range"), format!("give {expected}")));
    }
    let sheet_is_png = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if !args.contact_sheet.as_ref().is_none_or(sheet_is_png) {
        return Err(Failure::usage("a contact sheet is a .png file", "write --contact-sheet FILE.png"));
    }
    Ok(())
}

fn frame_range(text: &str) -> Result<(u32, u32), Failure> {
    let parsed = text.split_once("..").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    parsed.filter(|(a, b)| a <= b).ok_or_else(|| {
        Failure::usage(
            format!("`{text}` is not a range of frames"),
            "write --frames A..B with A from 0 to B; both are rendered",
        )
    })
}

/// The camera that the flags describe, of a command that shows one look, without a turntable.
///
/// # Errors
/// Numbers out of range, flags that contradict each other, or all cameras or variants at once.
pub fn camera(args: &FrameArgs) -> Result<CameraSpec, Failure> {
    looks::refuse_all(args)?;
    camera::spec(args, false)
}

/// The names of AOVs, each once; `all`, wherever it stands, is every one.
///
/// # Errors
/// A name that is none.
pub fn aovs(text: Option<&str>, names: &[&str]) -> Result<Vec<String>, Failure> {
    let Some(text) = text else { return Ok(Vec::new()) };
    let asked: Vec<&str> = text.split(',').map(str::trim).collect();
    if let Some(name) = asked.iter().find(|name| **name != "all" && !names.contains(name)) {
        return Err(Failure::usage(format!("unknown AOV `{name}`"), format!("AOVs: all, {}", names.join(", "))));
    }
    let asked = if asked.contains(&"all") { names.to_vec() } else { asked };
    let mut found: Vec<String> = Vec::new();
    for name in asked {
        if !found.iter().any(|other| other == name) {
            found.push(name.to_owned());
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
