//! The command line, checked and typed: everything that can be refused without reading a file or a GPU is refused here.

use crate::args::{PathArg, RenderArgs};
use crate::camera::{CameraSpec, DEFAULT_ORBIT, Place};
use crate::failure::Failure;
use glam::Vec3;
use manypass_offline::Format;
use std::path::{Path, PathBuf};

/// The longest side of a picture in pixels: the largest texture that common adapters offer.
const LARGEST_SIDE_PX: u32 = 16384;

/// Where pictures go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// Standard output.
    Stdout,
    /// A pattern with `{stem}`, `{frame}` and `{aov}`.
    Pattern(String),
}

/// A checked `render`.
#[derive(Debug)]
pub struct Job {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The camera.
    pub camera: CameraSpec,
    /// The environment as sRGB bytes; `studio`, `none` or a colour.
    pub environment: Option<Backdrop>,
    /// The background.
    pub background: Backdrop,
    /// The kind of file.
    pub format: Format,
    /// Where it goes.
    pub output: Output,
    /// Names of AOVs.
    pub aovs: Vec<String>,
    /// The frames, both ends included; none is a still.
    pub frames: Option<(u32, u32)>,
    /// Keys and values of `--set`.
    pub set: Vec<(String, String)>,
}

/// An environment or background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backdrop {
    /// The studio, or for a background the environment.
    Named,
    /// Nothing, or transparent.
    Nothing,
    /// A linear colour.
    Color([f32; 3]),
}

impl Job {
    /// Checks `args`; `several` says that there is more than one input.
    ///
    /// # Errors
    /// Wrong usage.
    pub fn new(args: &RenderArgs, several: bool, aov_names: &[&str]) -> Result<Self, Failure> {
        let (width, height) = size(&args.size)?;
        let frames = match (&args.frames, args.turntable) {
            (Some(text), _) => Some(frame_range(text)?),
            (None, Some(count)) => Some((0, count.saturating_sub(1))),
            (None, None) => None,
        };
        let (format, output) = output(args, several, frames.is_some_and(|(a, b)| a != b))?;
        let background = backdrop(&args.background, "environment", "transparent", "--background")?;
        if format == Format::Jpg && background == Backdrop::Nothing {
            return Err(Failure::usage(
                "jpg has no transparency",
                "write .png, .webp or .exr, or choose another --background",
            ));
        }
        check_numbers(args)?;
        let aovs = aovs(args.aov.as_deref(), aov_names)?;
        if !aovs.is_empty() && args.path != PathArg::Deferred {
            return Err(Failure::usage("only --path deferred has AOVs", "leave --path or --aov out"));
        }
        if !aovs.is_empty() && !matches!(format, Format::Png | Format::Exr) {
            return Err(Failure::usage("--aov needs .png or .exr", "use -o OUT.exr for all AOVs in one file"));
        }
        if !aovs.is_empty() && output == Output::Stdout && format != Format::Exr {
            return Err(Failure::usage("only .exr holds AOVs on standard output", "add --format exr"));
        }
        let environment = args.environment.as_deref().map(|text| backdrop(text, "studio", "none", "--environment"));
        let set = args.set.iter().map(|pair| key_value(pair)).collect::<Result<_, _>>()?;
        let camera = camera(args)?;
        Ok(Self {
            width,
            height,
            camera,
            environment: environment.transpose()?,
            background,
            format,
            output,
            aovs,
            frames,
            set,
        })
    }
}

fn check_numbers(args: &RenderArgs) -> Result<(), Failure> {
    let checks = [
        ("--fps", args.fps, args.fps.is_finite() && args.fps > 0.0, "a number above 0"),
        ("--exposure", args.exposure, args.exposure.is_finite() && args.exposure.abs() <= 64.0, "stops from -64 to 64"),
        (
            "--environment-intensity",
            args.environment_intensity,
            args.environment_intensity.is_finite() && args.environment_intensity >= 0.0,
            "a number of at least 0",
        ),
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

fn key_value(pair: &str) -> Result<(String, String), Failure> {
    let (key, value) = pair
        .split_once('=')
        .ok_or_else(|| Failure::usage(format!("`--set {pair}` has no `=`"), "write --set KEY=VALUE"))?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// `WxH`.
pub fn size(text: &str) -> Result<(u32, u32), Failure> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match parsed {
        Some((w, h)) if (1..=LARGEST_SIDE_PX).contains(&w) && (1..=LARGEST_SIDE_PX).contains(&h) => Ok((w, h)),
        _ => Err(Failure::usage(
            format!("`{text}` is no size"),
            format!("write --size WIDTHxHEIGHT, each from 1 to {LARGEST_SIDE_PX}"),
        )),
    }
}

fn frame_range(text: &str) -> Result<(u32, u32), Failure> {
    let parsed = text.split_once("..").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    parsed.filter(|(a, b)| a <= b).ok_or_else(|| {
        Failure::usage(
            format!("`{text}` is no range of frames"),
            "write --frames A..B with A not above B; both are rendered",
        )
    })
}

fn vector(text: &str, flag: &str) -> Result<Vec3, Failure> {
    let numbers: Option<Vec<f32>> =
        text.split(',').map(|n| n.trim().parse().ok().filter(|n: &f32| n.is_finite())).collect();
    match numbers.as_deref() {
        Some([x, y, z]) => Ok(Vec3::new(*x, *y, *z)),
        _ => Err(Failure::usage(format!("`{text}` is not three numbers"), format!("write {flag} X,Y,Z"))),
    }
}

fn camera(args: &RenderArgs) -> Result<CameraSpec, Failure> {
    let mut spec = CameraSpec::default();
    let positive = |value: Option<f32>, flag: &str| match value {
        Some(value) if !(value.is_finite() && value > 0.0) => {
            Err(Failure::usage(format!("{flag} {value} is out of range"), "give a number above 0"))
        }
        value => Ok(value),
    };
    let shaped = args.target.is_some() || args.up.is_some() || args.fov_y.is_some() || args.ortho_height.is_some();
    spec.place = match (&args.camera, &args.eye, &args.orbit) {
        (Some(name), _, _) => Place::Named(name.clone()),
        (_, Some(eye), _) => Place::Eye(vector(eye, "--eye")?),
        (_, _, Some(orbit)) => orbit_place(orbit)?,
        _ if shaped || args.near.is_some() || args.far.is_some() || args.turntable.is_some() => DEFAULT_ORBIT,
        _ => Place::Default,
    };
    spec.target = args.target.as_deref().map(|text| vector(text, "--target")).transpose()?;
    if let Some(up) = &args.up {
        spec.up = vector(up, "--up")?;
        if spec.up == Vec3::ZERO {
            return Err(Failure::usage("--up has no length", "write --up 0,1,0"));
        }
    }
    if let Some(degrees) = positive(args.fov_y, "--fov-y")? {
        if degrees >= 180.0 {
            return Err(Failure::usage(format!("--fov-y {degrees} is out of range"), "give degrees between 0 and 180"));
        }
        spec.fov_y_rad = degrees.to_radians();
    }
    spec.ortho_height_m = positive(args.ortho_height, "--ortho-height")?;
    spec.near_m = positive(args.near, "--near")?;
    spec.far_m = positive(args.far, "--far")?;
    spec.turns = args.turntable.is_some();
    if spec.near_m.zip(spec.far_m).is_some_and(|(near, far)| near >= far) {
        return Err(Failure::usage("--near is not below --far", "give a nearer --near"));
    }
    Ok(spec)
}

fn orbit_place(text: &str) -> Result<Place, Failure> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let number = |text: &str| text.parse::<f32>().ok().filter(|n| n.is_finite());
    let parsed = match parts[..] {
        [yaw, pitch, "auto"] => number(yaw).zip(number(pitch)).map(|(yaw, pitch)| (yaw, pitch, None)),
        [yaw, pitch, radius] => number(yaw)
            .zip(number(pitch))
            .zip(number(radius).filter(|r| *r > 0.0))
            .map(|((yaw, pitch), radius)| (yaw, pitch, Some(radius))),
        _ => None,
    };
    let (yaw_deg, pitch_deg, radius_m) = parsed.ok_or_else(|| {
        Failure::usage(format!("`{text}` is no orbit"), "write --orbit YAW,PITCH,RADIUS; RADIUS may be auto")
    })?;
    Ok(Place::Orbit { yaw_deg, pitch_deg, radius_m })
}

fn backdrop(text: &str, named: &str, nothing: &str, flag: &str) -> Result<Backdrop, Failure> {
    if text == named {
        return Ok(Backdrop::Named);
    }
    if text == nothing {
        return Ok(Backdrop::Nothing);
    }
    let hex = text.strip_prefix('#').unwrap_or(text);
    let value = if hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit()) {
        u32::from_str_radix(hex, 16).ok()
    } else {
        None
    };
    let value = value.ok_or_else(|| {
        Failure::usage(
            format!("`{text}` is no value of {flag}"),
            format!("write {named}, {nothing} or a colour such as ff8800"),
        )
    })?;
    let linear = |byte: u32| {
        let c = (byte & 255) as f32 / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    Ok(Backdrop::Color([linear(value >> 16), linear(value >> 8), linear(value)]))
}

fn aovs(text: Option<&str>, names: &[&str]) -> Result<Vec<String>, Failure> {
    let Some(text) = text else { return Ok(Vec::new()) };
    if text == "all" {
        return Ok(names.iter().map(|name| (*name).to_owned()).collect());
    }
    let mut found: Vec<String> = Vec::new();
    for name in text.split(',').map(str::trim) {
        if !names.contains(&name) {
            return Err(Failure::usage(format!("unknown AOV `{name}`"), format!("AOVs: all, {}", names.join(", "))));
        }
        if !found.iter().any(|other| other == name) {
            found.push(name.to_owned());
        }
    }
    Ok(found)
}

fn output(args: &RenderArgs, several: bool, sequence: bool) -> Result<(Format, Output), Failure> {
    let unknown = |text: &str| Failure::usage(format!("unknown format `{text}`"), "formats: png, jpg, webp, exr");
    let asked =
        args.format.as_deref().map(|text| Format::from_extension(text).ok_or_else(|| unknown(text))).transpose()?;
    let default_name = if sequence { "{stem}_{frame:04}" } else { "{stem}" };
    let format = asked.unwrap_or(Format::Png);
    let Some(out) = args.output.as_deref() else {
        return Ok((format, Output::Pattern(format!("{default_name}.{}", format.extension()))));
    };
    if out == "-" {
        let format = asked.ok_or_else(|| Failure::usage("standard output has no format", "add --format png"))?;
        if several || sequence {
            return Err(Failure::usage("standard output takes one picture", "write to a folder: -o DIR/"));
        }
        return Ok((format, Output::Stdout));
    }
    let path = Path::new(out);
    match path.extension().and_then(|e| e.to_str()).filter(|_| !out.ends_with('/') && !path.is_dir()) {
        None => Ok((
            format,
            Output::Pattern(format!("{}/{default_name}.{}", out.trim_end_matches('/'), format.extension())),
        )),
        Some(extension) => {
            let named = Format::from_extension(extension).ok_or_else(|| unknown(extension))?;
            if asked.is_some_and(|asked| asked != named) {
                return Err(Failure::usage(format!("--format and `{out}` disagree"), "leave --format out"));
            }
            Ok((named, Output::Pattern(out.to_owned())))
        }
    }
}

/// The file of a pattern for one picture. `{frame:04}` is the frame with at least four digits.
pub fn expand(pattern: &str, stem: &str, frame: u32, aov: &str) -> PathBuf {
    PathBuf::from(expand_with(pattern, stem, aov, |width| format!("{frame:0width$}")))
}

/// As [`expand`]; `frame` writes the frame with at least so many digits.
pub fn expand_with(pattern: &str, stem: &str, aov: &str, frame: impl Fn(usize) -> String) -> String {
    let mut text = pattern.replace("{aov}", aov).replace("{frame}", &frame(0));
    while let Some(start) = text.find("{frame:0") {
        let Some(end) = text[start..].find('}').map(|end| start + end) else { break };
        let width = text[start + 8..end].parse::<usize>().unwrap_or(0).min(32);
        text.replace_range(start..=end, &frame(width));
    }
    text.replace("{stem}", stem)
}

#[cfg(test)]
mod tests;
