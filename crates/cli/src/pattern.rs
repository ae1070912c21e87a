//! Where pictures go: the pattern of `--output`, and the file of one picture.

use crate::args::RenderArgs;
use crate::failure::Failure;
use manypass_offline::Format;
use std::path::{Path, PathBuf};

/// Where pictures go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// Standard output.
    Stdout,
    /// A pattern with `{stem}`, `{frame}` and `{aov}`.
    Pattern(String),
}

/// The format and the place of pictures; `several` inputs, or several frames, make patterns.
///
/// # Errors
/// Wrong usage.
pub fn output(args: &RenderArgs, several: bool, sequence: bool) -> Result<(Format, Output), Failure> {
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
