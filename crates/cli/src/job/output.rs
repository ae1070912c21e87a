//! The format of pictures and where they go, as `--output` and `--format` say.

use super::stream::StreamPlace;
use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::looks::PictureAxes;
use crate::pattern::{Pattern, default_name, has_placeholders, is_stdout, refuse_input_ending};
use manypass_offline::{Container, Format, atomic};
use std::path::Path;

/// Where pictures go.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// Standard output, of one picture.
    Stdout,
    /// A file a picture; or one device or pipe for all.
    Pattern(Pattern),
    /// One stream of all pictures.
    Stream(StreamPlace),
}

impl Output {
    /// The stream, if it is one.
    pub fn stream(&self) -> Option<&StreamPlace> {
        if let Self::Stream(place) = self { Some(place) } else { None }
    }

    /// The kind of the stream, if it is one.
    pub fn container(&self) -> Option<Container> {
        self.stream().map(|place| place.container)
    }

    /// Whether it is standard output.
    pub fn is_stdout(&self) -> bool {
        match self {
            Self::Stdout => true,
            Self::Pattern(_) => false,
            Self::Stream(place) => place.path.is_none(),
        }
    }
}

/// Refuses what scripts write whose variable is empty: one would be a picture in the root, the other a hidden folder.
///
/// # Errors
/// Wrong usage.
fn refuse_no_name(out: &str) -> Result<(), Failure> {
    let is_known = |end: &str| Format::from_extension(end).is_some() || Container::from_extension(end).is_some();
    if out.is_empty() || out.strip_prefix('.').is_some_and(is_known) {
        let hint = "name a file, such as -o picture.png, or a folder: -o DIR/";
        return Err(Failure::usage(format!("`{out}` is not the name of an output"), hint));
    }
    Ok(())
}

/// What `--format` takes, for messages.
const FORMATS: &str = "formats: png, jpg, webp, exr; y4m, npz and tar for all pictures in one stream";

/// What standard output takes.
const FORMAT_HINT: &str = "add --format png; for several pictures --format y4m, npz or tar";

/// What takes several pictures.
const SEVERAL_HINT: &str =
    "for several add --format y4m (video), npz (arrays) or tar (files); or write to a folder: -o DIR/";

/// The format and the place of pictures. `are_several` says that there is, or may be, more than one, `several` by what
/// one input has several.
///
/// # Errors
/// Wrong usage.
pub fn of_args(args: &RenderArgs, are_several: bool, several: PictureAxes) -> Result<(Format, Output), Failure> {
    if let Some(report) = args.report.as_deref().filter(|path| has_placeholders(path)) {
        let message = format!("--report {} has a placeholder, but is one file for the whole call", report.display());
        return Err(Failure::usage(message, "name one file, for example report.jsonl; every picture is a line of it"));
    }
    args.output.as_deref().map_or(Ok(()), refuse_no_name)?;
    if let Some(place) = StreamPlace::asked(args, several)? {
        return Ok((place.format, Output::Stream(place)));
    }
    let unknown = |text: &str| Failure::usage(format!("unknown format `{text}`"), FORMATS);
    let asked =
        args.format.as_deref().map(|text| Format::from_extension(text).ok_or_else(|| unknown(text))).transpose()?;
    let default_name = default_name(several);
    let format = asked.unwrap_or(Format::Png);
    let Some(out) = args.output.as_deref() else {
        return Ok((format, Output::Pattern(Pattern::new(&format!("{default_name}.{}", format.extension()))?)));
    };
    let path = Path::new(out);
    if is_stdout(path) {
        let format = asked.ok_or_else(|| Failure::usage("standard output has no format", FORMAT_HINT))?;
        if are_several {
            return Err(Failure::usage(
                format!("standard output takes one picture as {}", format.extension()),
                SEVERAL_HINT,
            ));
        }
        if args.report.as_deref().is_some_and(is_stdout) {
            return Err(Failure::usage("standard output takes the picture or the report", "write one to a file"));
        }
        return Ok((format, Output::Stdout));
    }
    let extension = path.extension().and_then(|e| e.to_str());
    if atomic::is_in_place(path) {
        let named = extension.and_then(Format::from_extension);
        return Ok((asked.or(named).unwrap_or(format), Output::Pattern(Pattern::literal(out))));
    }
    match extension.filter(|_| !out.ends_with('/') && !path.is_dir()) {
        None => {
            let name = format!("{default_name}.{}", format.extension());
            Ok((format, Output::Pattern(Pattern::in_folder(out, &name)?)))
        }
        Some(extension) => {
            let named = Format::from_extension(extension);
            if let (Some(asked), Some(named)) = (asked, named)
                && asked != named
            {
                let message = format!("--format {} and `{out}` disagree", asked.extension());
                return Err(Failure::usage(message, "leave --format out, or give the file another ending"));
            }
            refuse_input_ending(out, extension)?;
            // An ending that says nothing is a name like any other where the format is given.
            let format = asked.or(named).ok_or_else(|| {
                let hint = format!("{FORMATS}; add --format for another ending, or name a folder: {out}/");
                Failure::usage(format!("unknown format `{extension}`"), hint)
            })?;
            Ok((format, Output::Pattern(Pattern::of_flag("-o", path, several, &args.frame)?)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::Parser as _;

    #[test]
    fn a_format_that_is_given_takes_any_ending_that_is_no_other_format() {
        let output = |words: &[&str]| {
            let words = [&["manypass", "render", "a.glb"], words].concat();
            let Command::Render(args) = Cli::try_parse_from(words).expect("arguments").command else { panic!() };
            of_args(&args, false, PictureAxes::default())
        };
        for format in ["png", "jpg", "webp", "exr"] {
            let (found, place) = output(&["-o", "x.foo", "--format", format]).expect(format);
            assert_eq!((found.extension(), place), (format, Output::Pattern(Pattern::literal("x.foo"))));
            let failure = output(&["-o", if format == "png" { "x.jpg" } else { "x.png" }, "--format", format]);
            assert!(failure.expect_err(format).message.contains("disagree"), "{format}");
        }
        for name in ["other.glb", "a/Other.GLTF", "own_pass.wgsl", "settings.toml", "buffer.bin", "part.STL"] {
            let failure = output(&["-o", name, "--format", "png"]).expect_err(name);
            assert!(failure.code() == 2 && failure.message.contains("as an input"), "{failure:?}");
        }
        let (found, _) = output(&["-o", "x.JPEG", "--format", "jpg"]).expect("the same format");
        assert_eq!(found, Format::Jpg);
        let failure = output(&["-o", "x.foo"]).expect_err("no format");
        assert!(failure.hint.contains("--format") && failure.hint.contains("x.foo/"), "{failure:?}");
    }
}
