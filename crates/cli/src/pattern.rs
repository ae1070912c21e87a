//! Paths with placeholders: the pattern of `--output`, and the file of one picture.

use crate::args::FrameArgs;
use crate::failure::Failure;
use crate::looks::{PictureAxes, Subject};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// What a pattern may hold, for messages.
const PLACEHOLDERS: &str = "{parent}, {stem}, {variant}, {camera}, {frame}, {frame:04} and {aov}";

/// How those begin.
const NAMES: [&str; 6] = ["parent", "stem", "variant", "camera", "frame", "aov"];

/// The most digits of `{frame:0N}`.
const MOST_DIGITS: usize = 32;

/// A path with placeholders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    text: String,
    parts: Vec<PatternPart>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum PatternPart {
    Text(String),
    Parent,
    Stem,
    Variant,
    Camera,
    Frame { digits: usize },
    Aov,
}

impl PatternPart {
    fn placeholder(name: &str) -> Option<Self> {
        match name {
            "parent" => Some(Self::Parent),
            "stem" => Some(Self::Stem),
            "variant" => Some(Self::Variant),
            "camera" => Some(Self::Camera),
            "frame" => Some(Self::Frame { digits: 0 }),
            "aov" => Some(Self::Aov),
            _ => {
                let digits = name.strip_prefix("frame:0")?;
                let is_number = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit());
                let digits = digits.parse().ok().filter(|digits| is_number && *digits <= MOST_DIGITS)?;
                Some(Self::Frame { digits })
            }
        }
    }
}

impl Pattern {
    /// The pattern that `text` is.
    ///
    /// # Errors
    /// Wrong usage, if something else stands in braces, or a placeholder lacks its second one.
    pub fn new(text: &str) -> Result<Self, Failure> {
        let (mut parts, mut rest) = (Vec::new(), text);
        while let Some((before, after)) = rest.split_once('{') {
            let Some((name, after)) = after.split_once('}') else {
                if NAMES.iter().any(|name| after.starts_with(name)) {
                    let message = format!("the `{{` before `{after}` has no `}}` in `{text}`");
                    return Err(Failure::usage(message, format!("known: {PLACEHOLDERS}")));
                }
                break;
            };
            let part = PatternPart::placeholder(name).ok_or_else(|| {
                Failure::usage(
                    format!("unknown placeholder `{{{name}}}` in `{text}`"),
                    format!("known: {PLACEHOLDERS}"),
                )
            })?;
            parts.extend([PatternPart::Text(before.to_owned()), part]);
            rest = after;
        }
        parts.push(PatternPart::Text(rest.to_owned()));
        Ok(Self { text: text.to_owned(), parts })
    }

    /// The pattern of files called `name` in a folder, each a pattern of its own.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn in_folder(folder: &str, name: &str) -> Result<Self, Failure> {
        let (folder, name) = (Self::new(folder.trim_end_matches('/'))?, Self::new(&format!("/{name}"))?);
        Ok(Self { text: folder.text + &name.text, parts: [folder.parts, name.parts].concat() })
    }

    /// The path that `text` is, whatever it holds.
    pub fn literal(text: &str) -> Self {
        Self { text: text.to_owned(), parts: vec![PatternPart::Text(text.to_owned())] }
    }

    /// The pattern of a flag that makes one file or folder a picture.
    ///
    /// # Errors
    /// As [`Self::new`], and wrong usage if the pattern does not tell the pictures of one input apart: not even one
    /// frame, because another call may render the next one; or if it names a variant or a camera and no flag does.
    pub fn of_flag(flag: &str, path: &Path, several: PictureAxes, frame: &FrameArgs) -> Result<Self, Failure> {
        let text = path.to_string_lossy();
        let pattern = Self::new(&text)?;
        let holds = |kind: fn(&PatternPart) -> bool| pattern.parts.iter().any(kind);
        let of_frame = holds(|part| matches!(part, PatternPart::Frame { .. }));
        let of_variant = holds(|part| *part == PatternPart::Variant);
        let of_camera = holds(|part| *part == PatternPart::Camera);
        let missing = [
            (several.variants && !of_variant, "variants", "{variant}"),
            (several.cameras && !of_camera, "cameras", "{camera}"),
            (several.frames && !of_frame, "frames", "{frame:04}"),
        ];
        if let Some((_, what, placeholder)) = missing.into_iter().find(|(is_missing, ..)| *is_missing) {
            let or_folder = if flag == "-o" { ", or name a folder: DIR/" } else { "" };
            let hint = format!("write {placeholder} into the name{or_folder}");
            return Err(Failure::usage(format!("{flag} {text} is one place for all {what}"), hint));
        }
        let has_camera = several.cameras || frame.camera.is_some();
        let unnamed = [(of_variant && frame.variant.is_none(), "variant"), (of_camera && !has_camera, "camera")];
        if let Some((_, what)) = unnamed.into_iter().find(|(is_unnamed, _)| *is_unnamed) {
            let message = format!("{flag} {text} names a {what}, and none is asked for");
            return Err(Failure::usage(
                message,
                format!("add --{what} all, or --{what} NAME, or leave {{{what}}} out"),
            ));
        }
        Ok(pattern)
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The path of one picture. `{frame:04}` is the frame with at least four digits.
    pub fn expand(&self, subject: Subject<'_>, aov: &str) -> PathBuf {
        let Subject { names, look, frame } = subject;
        let mut text = String::new();
        for part in &self.parts {
            match part {
                PatternPart::Text(literal) => text.push_str(literal),
                PatternPart::Parent => text.push_str(&names.parent),
                PatternPart::Stem => text.push_str(&names.stem),
                PatternPart::Variant => text.push_str(&shortened(&look.variant_name)),
                PatternPart::Camera => text.push_str(&shortened(&look.camera_name)),
                PatternPart::Frame { digits } => text.push_str(&format!("{frame:0digits$}")),
                PatternPart::Aov => text.push_str(aov),
            }
        }
        PathBuf::from(text)
    }
}

/// File systems take names of 255 bytes; a name that is longer than this leaves no room for the others beside it.
const NAME_BYTES_MAX: usize = 80;

/// A name of a model as a part of a file's name. Of a long one its beginning stays, and a number of the whole of it, so that
/// two of one beginning have two files.
fn shortened(name: &str) -> Cow<'_, str> {
    if name.len() <= NAME_BYTES_MAX {
        return Cow::Borrowed(name);
    }
    let mut end = NAME_BYTES_MAX - 9;
    while !name.is_char_boundary(end) {
        end -= 1;
    }
    // FNV-1a: names of files are the same with every version of the program.
    let hash = name.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    Cow::Owned(format!("{}-{hash:08x}", &name[..end]))
}

/// What is read has these endings; one mistyped letter shall not cost a model.
const INPUT_ENDINGS: [&str; 12] =
    ["3mf", "bin", "glb", "gltf", "hdr", "ktx2", "mtl", "obj", "ply", "stl", "toml", "wgsl"];

/// Whether any placeholder stands in `path`, beside what may.
pub fn has_placeholders(path: &Path) -> bool {
    let text = path.to_string_lossy();
    let mut names = text.split('{').skip(1).filter_map(|rest| rest.split_once('}'));
    names.any(|(name, _)| PatternPart::placeholder(name).is_some())
}

/// Whether a path is another name of standard output.
pub fn is_stdout(path: &Path) -> bool {
    [Path::new("-"), Path::new("/dev/stdout"), Path::new("/dev/fd/1"), Path::new("/proc/self/fd/1")].contains(&path)
}

/// The names of pictures where none are given, without an ending.
pub fn default_name(several: PictureAxes) -> String {
    let of_variants = if several.variants { "_{variant}" } else { "" };
    let of_cameras = if several.cameras { "_{camera}" } else { "" };
    let of_frames = if several.frames { "_{frame:04}" } else { "" };
    format!("{{stem}}{of_variants}{of_cameras}{of_frames}")
}

/// Refuses an output that ends as an input does.
///
/// # Errors
/// Wrong usage.
pub fn refuse_input_ending(out: &str, extension: &str) -> Result<(), Failure> {
    if INPUT_ENDINGS.iter().any(|ending| extension.eq_ignore_ascii_case(ending)) {
        let message = format!("`{out}` ends as an input does, and a picture could take the place of one");
        return Err(Failure::usage(message, "give the picture another ending, such as .png"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::Names;
    use crate::looks::Look;

    #[test]
    fn placeholders_are_filled_in_and_others_refused() {
        let names = Names { parent: "p".into(), stem: "{aov}".into() };
        let look = Look { variant_name: "v".into(), camera_name: "c".into(), ..Look::default() };
        let subject = Subject { names: &names, look: &look, frame: 7 };
        let expand = |text: &str| Pattern::new(text).expect(text).expand(subject, "depth");
        assert_eq!(expand("o/{parent}/{stem}.{frame:04}{frame}.{aov}.png"), Path::new("o/p/{aov}.00077.depth.png"));
        assert_eq!(expand("{variant}/{camera}.png"), Path::new("v/c.png"));
        assert_eq!(expand("a{.png"), Path::new("a{.png"));
        for (text, part) in [("{stem", "`{` before `stem` has no `}` in `{stem`"), ("{foo}/", "`{foo}` in `{foo}`")] {
            let failure = Pattern::in_folder(text, "{stem}.png").expect_err(text);
            assert!(failure.code() == 2 && failure.message.contains(part), "{failure:?}");
        }
        let failure = Pattern::new("{parent}/{frame:04.png").expect_err("no second brace");
        assert!(failure.message.contains("`{` before `frame:04.png` has no `}`"), "{failure:?}");
        let in_folder = Pattern::in_folder("a{//", "{stem}.png").expect("a folder");
        assert_eq!(in_folder.expand(subject, "depth"), Path::new("a{/{aov}.png"));
        for text in
            ["{foo}", "{}", "{frame:4}", "{frame:0}", "{frame:0x}", "{frame:099}", "{Stem}", "{{stem}}", "{ stem}"]
        {
            let failure = Pattern::new(text).expect_err(text);
            assert!(failure.code() == 2 && failure.hint.contains("{frame:04}"), "{failure:?}");
        }
    }
}
