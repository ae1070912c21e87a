//! The header of an effect's file: its first lines, which begin with `//!`.

use super::declarations::{BorrowedTexture, IDS};
use super::steps::{self, Step};
use crate::diagnostic::Diagnostic;
use crate::user_shader::Source;
use crate::user_shader::scan::Scan;
use crate::user_shader::source::{entries, is_identifier, is_name};
use std::ops::Range;

/// The words that a header may hold.
const WORDS: [&str; 5] = ["effect", "reads", "passes", "pixel", "fallback"];
/// What an effect names that is left out where time is short.
pub(super) const NO_FALLBACK: &str = "none";
/// What an effect may say that it reads of the frame, and the name of each in the shader.
pub(super) const READS: [(&str, &str); 10] = [
    ("depth", "linear_depth"),
    ("normal", "normal"),
    ("base_color", "base_color"),
    ("material", "material"),
    ("radiance", "radiance"),
    ("previous", "previous"),
    (DISPLAY, DISPLAY),
    ("occlusion", "occlusion"),
    ("motion", "motion"),
    (IDS, IDS),
];
/// Those of them that the header alone declares, because files had these names before.
const BORROWED: [&str; 3] = ["occlusion", "motion", IDS];
/// What stands between such a texture and the settings that it is for, and between these.
const IF: &str = " if ";
const OR: &str = " or ";
/// What an effect reads that stands after the tone curve.
pub(super) const DISPLAY: &str = "display";

/// A word of a header, and its place.
type PlacedWord = (String, Range<usize>);

/// What a header says.
#[derive(Debug, Default)]
pub(super) struct Header {
    /// The name of the effect.
    pub name: Option<String>,
    /// What it reads, with the place of the list.
    reads: Option<(Vec<String>, Range<usize>)>,
    /// What of it is for some settings alone: the texture, and the settings with their places.
    conditions: Vec<(String, Vec<PlacedWord>)>,
    /// Its passes; none where it says nothing of them.
    pub steps: Vec<Step>,
    /// The function that changes a pixel and knows that one alone, with its place.
    pub pixel: Option<(String, Range<usize>)>,
    /// What is drawn in its place where time is short, with its place: a built-in effect, or [`NO_FALLBACK`].
    pub fallback: Option<(String, Range<usize>)>,
}

fn version() -> &'static str {
    concat!("manypass ", env!("CARGO_PKG_VERSION"))
}

impl Header {
    /// Reads the header of `source`.
    ///
    /// # Errors
    /// A line that is not of the form, or not at the top.
    pub fn parse(source: Source<'_>, scan: &Scan) -> Result<Self, Box<Diagnostic>> {
        let mut header = Self::default();
        for (start, line) in source.header_lines(scan)? {
            header.line(source, start, line)?;
        }
        Ok(header)
    }

    /// One line, which begins at the byte `start`.
    fn line(&mut self, source: Source<'_>, start: usize, line: &str) -> Result<(), Box<Diagnostic>> {
        let word_start = start + line.len() - line.trim_start().len();
        let line = line.trim();
        let length = line.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(line.len());
        let (word, rest) = line.split_at(length);
        let here = word_start..word_start + length.max(1);
        let again = |is_there: bool| {
            let message = format!("`{word}` stands twice in the header");
            if is_there { Err(source.fault(here.clone(), message)) } else { Ok(()) }
        };
        let list = |form: &str| {
            let rest = rest.strip_prefix(':').filter(|rest| !rest.trim().is_empty());
            rest.ok_or_else(|| source.fault(here.clone(), format!("write `//! {form}`")))
        };
        match word {
            "effect" => {
                again(self.name.is_some())?;
                let name = rest.trim();
                let place = word_start + length + (rest.len() - rest.trim_start().len());
                if !is_name(name) || !rest.starts_with(char::is_whitespace) {
                    let fault =
                        source.fault(place..place + name.len(), "this is not the name of an effect: `//! effect NAME`");
                    return Err(Box::new(
                        fault.note("a name begins with a letter and consists of letters, digits, `_` and `-`"),
                    ));
                }
                self.name = Some(name.into());
            }
            "reads" => {
                again(self.reads.is_some())?;
                let rest = list("reads: NAME, NAME, …")?;
                let mut reads = Vec::new();
                for (entry, place) in entries(rest, word_start + line.len() - rest.len()) {
                    let (name, list) = entry.split_once(IF).map_or((entry, None), |(name, list)| (name, Some(list)));
                    let here = place.start..place.start + name.len().max(1);
                    let read = read(source, name.trim_end(), here.clone())?;
                    if let Some(list) = list {
                        let settings = settings(source, &read, here, (list, place.end - list.len()))?;
                        self.conditions.push((read.clone(), settings));
                    }
                    reads.push(read);
                }
                self.reads = Some((reads, word_start..word_start + line.len()));
            }
            "passes" => {
                again(!self.steps.is_empty())?;
                let rest = list("passes: FUNCTION -> TEXTURE, …, FUNCTION")?;
                let passes = entries(rest, word_start + line.len() - rest.len());
                self.steps = steps::parse(source, passes)?;
            }
            "pixel" => {
                again(self.pixel.is_some())?;
                let rest = list("pixel: FUNCTION")?;
                let name = rest.trim();
                let start = word_start + line.len() - rest.trim_start().len();
                let place = start..start + name.len();
                if !is_identifier(name) {
                    let note = "it is `fn NAME(color: vec4f, position: vec2f) -> vec4f`: what a pixel was, where it is, and \
                                what it becomes";
                    return Err(Box::new(source.fault(place, "this is not the name of a function").note(note)));
                }
                self.pixel = Some((name.into(), place));
            }
            "fallback" => {
                again(self.fallback.is_some())?;
                let name = list("fallback: NAME")?.trim();
                let start = word_start + line.len() - name.len();
                self.fallback = Some((name.into(), start..start + name.len()));
            }
            _ => {
                let known = WORDS.join(", ");
                let message =
                    format!("`{line}` begins with no word that a header has in {}; those are: {known}", version());
                let note = "a later version may know it; a remark begins with `//` alone";
                return Err(Box::new(source.fault(here, message).note(note)));
            }
        }
        Ok(())
    }

    /// Whether it says that the effect reads display colours.
    pub fn reads_display(&self) -> bool {
        self.reads.iter().any(|(reads, _)| reads.iter().any(|read| read == DISPLAY))
    }

    /// The textures that only it declares, beside those that the effect's own passes write; each once.
    pub fn borrowed(&self) -> Vec<BorrowedTexture> {
        let reads = self.reads.iter().flat_map(|(reads, _)| reads);
        let mut keys: Vec<&String> =
            reads.filter(|read| read.contains('.') || BORROWED.contains(&read.as_str())).collect();
        keys.sort_unstable();
        keys.dedup();
        keys.into_iter()
            .map(|key| BorrowedTexture { settings: self.settings_of(key), ..BorrowedTexture::new(key) })
            .collect()
    }

    /// The settings that a texture is for.
    fn settings_of(&self, key: &str) -> Vec<String> {
        let settings = self.conditions.iter().filter(|(texture, _)| texture == key).flat_map(|(_, settings)| settings);
        settings.map(|(setting, _)| setting.clone()).collect()
    }

    /// Whether the settings that textures are for are there, by what `is_setting` says.
    ///
    /// # Errors
    /// One is not.
    pub fn check_conditions(
        &self,
        source: Source<'_>,
        is_setting: impl Fn(&str) -> bool,
    ) -> Result<(), Box<Diagnostic>> {
        let settings = self.conditions.iter().flat_map(|(_, settings)| settings);
        match settings.into_iter().find(|(setting, _)| !is_setting(setting)) {
            Some((setting, place)) => {
                let message = format!("`{setting}` is not a setting of the effect with one number");
                let note = "it is a member of a uniform, or `UNIFORM.MEMBER` where two have a member of that name";
                Err(Box::new(source.fault(place.clone(), message).note(note)))
            }
            None => Ok(()),
        }
    }

    /// The place of the line that says what it reads.
    pub fn place_of_reads(&self) -> Range<usize> {
        self.reads.as_ref().map_or(0..0, |(_, place)| place.clone())
    }

    /// Whether the header says of the shader what is true: `used` are the frame's textures that it uses. Gives the
    /// warning of words that name what the shader does not read.
    ///
    /// # Errors
    /// The shader reads what the header leaves out, or beside `display` what is not there; nothing reads `display`.
    pub fn check(&self, source: Source<'_>, used: &[&str]) -> Result<Option<String>, Box<Diagnostic>> {
        let Some((reads, place)) = &self.reads else { return Ok(None) };
        let of_frame = READS.iter().map(|(name, texture)| (*name, *texture));
        let borrowed = self.borrowed();
        let of_others = borrowed.iter().filter(|borrowed| borrowed.of_effect().is_some());
        let all = of_frame.chain(of_others.map(|borrowed| (borrowed.key.as_str(), borrowed.variable.as_str())));
        let used: Vec<&str> = all.filter(|(_, texture)| used.contains(texture)).map(|(name, _)| name).collect();
        let reads: Vec<&str> = reads.iter().map(String::as_str).collect();
        let is_of_frame = |read: &&&str| !matches!(**read, DISPLAY | "previous") && !read.contains('.');
        if let Some(other) = reads.iter().chain(&used).find(is_of_frame).filter(|_| self.reads_display()) {
            let message =
                format!("an effect that reads `display` stands after the tone curve, and cannot read `{other}`");
            let note = "of the frame it reads `display` and `previous`; make what needs more an effect of its own";
            return Err(Box::new(source.fault(place.clone(), message).note(note)));
        }
        let missing: Vec<_> = used.iter().copied().filter(|name| !reads.contains(name)).collect();
        let needless: Vec<_> = reads.iter().copied().filter(|name| !used.contains(name)).collect();
        if missing.is_empty() && needless.is_empty() {
            return Ok(None);
        }
        let mut parts = Vec::new();
        if !missing.is_empty() {
            parts.push(format!("the shader also reads {}", missing.join(", ")));
        }
        if !needless.is_empty() {
            parts.push(format!("the shader does not read {}", needless.join(", ")));
        }
        let fault = source.fault(place.clone(), parts.join("; "));
        let with_settings = |name: &&str| match self.settings_of(name).join(OR) {
            settings if settings.is_empty() => (*name).to_owned(),
            settings => format!("{name}{IF}{settings}"),
        };
        let right: Vec<String> = used.iter().map(with_settings).collect();
        let right = match (right.join(", "), self.reads_display()) {
            (list, false) if list.is_empty() => "no such line is right".into(),
            (list, true) if list.is_empty() => {
                "an effect on display colours reads `display` in one of its passes".into()
            }
            (list, false) => format!("`//! reads: {list}` is right, and the line may be left out"),
            (list, true) => format!("`//! reads: {list}` is right"),
        };
        // `display` puts the effect behind the tone curve, so that it is never a word too many.
        if missing.is_empty() && !needless.contains(&DISPLAY) {
            let Diagnostic { file, line, column, message, .. } = &*fault;
            return Ok(Some(format!("{file}:{line}:{column}: {message}; {right}")));
        }
        let note =
            "`surface_at` reads normal, base_color and material; `distance_at` reads depth; `radiance_at` radiance";
        Err(Box::new(fault.note(right).note(note)))
    }
}

/// The settings that a texture is for, each with its place: those of a `list` with `or` between, which begins at a byte.
fn settings(
    source: Source<'_>,
    texture: &str,
    place: Range<usize>,
    (list, start): (&str, usize),
) -> Result<Vec<PlacedWord>, Box<Diagnostic>> {
    if !BORROWED.contains(&texture) {
        let message = format!("`{texture}` is there whether it is read or not, so that an `if` spares nothing");
        let note = format!("the frame has these only if an effect reads them: {}", BORROWED.join(", "));
        return Err(Box::new(source.fault(place, message).note(note)));
    }
    let mut at = start;
    let settings = list.split(OR).map(|part| {
        let begin = at + part.len() - part.trim_start().len();
        at += part.len() + OR.len();
        let setting = part.trim();
        (setting.to_owned(), begin..begin + setting.len().max(1))
    });
    Ok(settings.collect())
}

fn read(source: Source<'_>, name: &str, place: Range<usize>) -> Result<String, Box<Diagnostic>> {
    let of_effect = name.split_once('.');
    let is_known = READS.iter().any(|(known, _)| *known == name)
        || of_effect.is_some_and(|(effect, texture)| is_name(effect) && is_identifier(texture));
    if is_known {
        return Ok(name.into());
    }
    let known: Vec<_> = READS.iter().map(|(known, _)| *known).collect();
    let message = format!("there is no `{name}` to read; there is: {}", known.join(", "));
    Err(Box::new(source.fault(place, message).note("a texture that another effect's pass writes is `EFFECT.TEXTURE`")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::user_shader::scan::scan;
    use std::collections::BTreeSet;

    fn parse(text: &str) -> Result<Header, String> {
        Header::parse(Source { file: "a.wgsl", text }, &scan(text)).map_err(|error| error.to_string())
    }

    #[test]
    fn what_effects_read_is_of_a_pass() {
        let of_passes: BTreeSet<&str> =
            crate::passes::PASSES.iter().flat_map(|pass| pass.info.effect_inputs).copied().collect();
        // What an effect made itself in the last frame.
        let inputs: BTreeSet<&str> = READS.iter().map(|(name, _)| *name).filter(|name| *name != "previous").collect();
        assert_eq!(of_passes, inputs);
    }

    #[test]
    fn a_header_is_read_to_its_last_word() {
        let text =
            "// A remark.\n\n//! effect soft-lines_2\r\n//!reads: depth,  normal\n//! passes: fs_lines\nstruct S {}";
        let header = parse(text).expect("a good header");
        assert_eq!(header.name.as_deref(), Some("soft-lines_2"));
        let source = Source { file: "a.wgsl", text };
        assert_eq!(header.check(source, &["normal", "linear_depth"]).expect("true"), None);
        let reads = header.check(source, &["normal", "radiance"]).expect_err("false").to_string();
        assert!(
            reads.starts_with("a.wgsl:4:4: error: the shader also reads radiance; the shader does not read depth"),
            "{reads}"
        );
        assert!(reads.contains("`//! reads: normal, radiance` is right"), "{reads}");
        let text = "//! reads: ids if a or b.c";
        let reads = parse(text).expect("good words").check(Source { file: "a.wgsl", text }, &["normal", "ids"]);
        let reads = reads.expect_err("false").to_string();
        assert!(reads.contains("`//! reads: normal, ids if a or b.c` is right"), "{reads}");
        let nothing = parse("fn f() {}").expect("no header").check(source, &["normal"]);
        assert_eq!(nothing.expect("nothing said"), None);
        let text = "//! reads: display, depth";
        let both = parse(text).expect("good words").check(Source { file: "a.wgsl", text }, &[]);
        assert!(both.expect_err("two places").to_string().contains("cannot read `depth`"));
    }

    #[test]
    fn a_word_too_many_is_a_warning_where_it_changes_nothing() {
        let check = |text: &str, used: &[&str]| {
            let header = parse(text).expect("good words");
            header.check(Source { file: "a.wgsl", text }, used).map_err(|error| error.to_string())
        };
        let said = check("// A remark.\n//! reads: depth, ids if a, normal", &["normal"]).expect("a warning");
        let expected = "a.wgsl:2:5: the shader does not read depth, ids; `//! reads: normal` is right, and the line may be left out";
        assert_eq!(said.as_deref(), Some(expected));
        let said = check("//! reads: display, previous", &["display"]).expect("a warning").unwrap_or_default();
        assert!(said.ends_with("does not read previous; `//! reads: display` is right"), "{said}");
        let said = check("//! reads: glow.wide", &[]).expect("a warning").unwrap_or_default();
        assert!(said.ends_with("does not read glow.wide; no such line is right"), "{said}");
        let error = check("//! reads: display, previous", &["previous"]).expect_err("not after the tone curve");
        assert!(
            error.contains("reads `display` in one of its passes") || error.contains("does not read display"),
            "{error}"
        );
    }

    #[test]
    fn nothing_in_a_header_is_passed_over() {
        for (text, expected) in [
            ("//! author: me", "a.wgsl:1:5: error: `author: me` begins with no word"),
            ("//! author: me", "those are: effect, reads, passes, pixel, fallback"),
            ("//!", "begins with no word"),
            ("//! Effect lines", "begins with no word"),
            ("//! effect", "a.wgsl:1:11: error: this is not the name"),
            ("//! effect: lines", "not the name of an effect"),
            ("//! effect two words", "a.wgsl:1:12: error: this is not the name"),
            ("//! effect 2d", "not the name of an effect"),
            ("//! effect a\n//! effect b", "a.wgsl:2:5: error: `effect` stands twice"),
            ("//! reads depth", "write `//! reads: NAME"),
            ("//! reads:", "write `//! reads: NAME"),
            ("//! reads: depth, colour", "a.wgsl:1:19: error: there is no `colour` to read; there is: depth, normal"),
            ("//! reads: depth,", "there is no `` to read"),
            ("//! reads: depth if lines", "a.wgsl:1:12: error: `depth` is there whether it is read or not"),
            ("//! reads: colours if lines", "a.wgsl:1:12: error: there is no `colours` to read"),
            ("//! reads: ids if", "there is no `ids if` to read"),
            ("//! passes:", "write `//! passes: FUNCTION"),
            ("//! fallback", "write `//! fallback: NAME`"),
            ("//! fallback: fxaa\n//! fallback: none", "a.wgsl:2:5: error: `fallback` stands twice"),
            ("struct S {}\n//! effect a", "a.wgsl:2:1: error: a line of the header stands below"),
            ("struct S {} //! effect a", "stands below"),
        ] {
            let error = parse(text).expect_err(text);
            assert!(error.contains(expected), "{text}\n{error}\nshould say {expected}");
        }
    }
}
