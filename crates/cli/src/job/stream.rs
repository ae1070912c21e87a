//! `-o -` and `-o FILE.y4m`, `.npz`, `.tar`: where one stream of all pictures of a call goes.

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::looks::{PictureAxes, Subject};
use crate::pattern::{self, Pattern};
use manypass_offline::{Container, Format, atomic};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The stream that a call writes.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamPlace {
    /// Its kind.
    pub container: Container,
    /// Its file, device or pipe; none is standard output.
    pub path: Option<PathBuf>,
    /// The names of the files in a tar.
    names: Pattern,
    /// What pictures are encoded as; those that a stream holds as pixels are as PNG would be.
    pub format: Format,
    /// Of video.
    pub frames_per_second: f32,
}

impl StreamPlace {
    /// The stream that `args` ask for, by `--format` or by the ending of `--output`; none, if they ask for a file a
    /// picture. `several` says what one input has several pictures by.
    ///
    /// # Errors
    /// Wrong usage.
    pub fn asked(args: &RenderArgs, several: PictureAxes) -> Result<Option<Self>, Failure> {
        let Some(out) = args.output.as_deref() else { return without_place(args) };
        let path = Path::new(out);
        let (is_stdout, is_in_place) = (pattern::is_stdout(path), atomic::is_in_place(path));
        let ending = path.extension().and_then(OsStr::to_str);
        let ending = ending.filter(|_| !out.ends_with('/') && !path.is_dir());
        let of_format = args.format.as_deref().and_then(Container::from_extension);
        let of_ending = ending.and_then(Container::from_extension);
        let Some(container) = of_format.or(of_ending) else { return Ok(None) };
        let name = container.extension();
        if let Some(format) = args.format.as_deref().filter(|_| !is_in_place) {
            let says_another = of_format.map_or(Format::from_extension(format).is_some(), |asked| {
                of_ending.is_some_and(|named| named != asked) || ending.and_then(Format::from_extension).is_some()
            });
            if says_another {
                let message = format!("--format {format} and `{out}` disagree");
                return Err(Failure::usage(message, "leave --format out, or give the file another ending"));
            }
        }
        if of_format.is_none() && args.format.is_some() {
            // A format that there is not, or pictures to a device with such a name.
            return Ok(None);
        }
        if !is_stdout && !is_in_place {
            check_file(args, out, (ending, name))?;
        }
        if is_stdout && args.report.as_deref().is_some_and(pattern::is_stdout) {
            return Err(Failure::usage("standard output takes the pictures or the report", "write one to a file"));
        }
        let format = if container == Container::Tar && args.frame.aov.is_some() { Format::Exr } else { Format::Png };
        let names = Pattern::new(&format!("{}.{}", pattern::default_name(several), format.extension()))?;
        let path = (!is_stdout).then(|| path.to_owned());
        Ok(Some(Self { container, path, names, format, frames_per_second: args.fps }))
    }

    /// Its name in reports.
    pub fn shown(&self) -> String {
        self.path.as_ref().map_or("-".into(), |path| path.display().to_string())
    }

    /// The name of a picture in a tar.
    pub fn name(&self, subject: Subject<'_>) -> String {
        self.names.expand(subject, "rgba").to_string_lossy().into_owned()
    }
}

/// Nothing, unless a stream is asked for that has no place.
fn without_place(args: &RenderArgs) -> Result<Option<StreamPlace>, Failure> {
    let Some(container) = args.format.as_deref().and_then(Container::from_extension) else { return Ok(None) };
    let name = container.extension();
    let message = format!("--format {name} is one stream of all pictures, and has no place");
    Err(Failure::usage(message, format!("add -o - for standard output, or name a file: -o pictures.{name}")))
}

/// Refuses what is no name of one new file; `ending` is that of `out`, `name` that of the stream's kind.
fn check_file(args: &RenderArgs, out: &str, (ending, name): (Option<&str>, &str)) -> Result<(), Failure> {
    let path = Path::new(out);
    if ending.is_none() {
        let message = format!("`{out}` is a folder, and {name} is one file of all pictures");
        let folder = out.trim_end_matches('/');
        return Err(Failure::usage(message, format!("name the file: -o {folder}/pictures.{name}")));
    }
    if pattern::has_placeholders(path) {
        let message = format!("`{out}` has a placeholder, but is one file of all pictures");
        return Err(Failure::usage(message, format!("name one file, for example -o pictures.{name}")));
    }
    if args.skip_existing {
        let message = format!("--skip-existing does not know which pictures are in `{out}`");
        return Err(Failure::usage(message, "leave it out, or write a file a picture: -o DIR/"));
    }
    pattern::refuse_input_ending(out, ending.unwrap_or_default())
}
