//! How often a pass of the user's is drawn.

use super::source::Source;
use super::source::is_identifier;
use super::uniforms::Uniforms;
use crate::diagnostic::Diagnostic;
use std::ops::Range;

/// There are at most so many passes, each drawn at most so often.
pub(crate) const STEPS_MAX: usize = 64;

/// How often a pass is drawn, each time with what it left the time before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Rounds {
    /// So often.
    Count(u32),
    /// As often as this setting says.
    Setting(String),
}

impl Rounds {
    /// What follows `x`: a number, or the name of a setting.
    pub fn parse(word: &str) -> Option<Self> {
        match number(word) {
            Some(count) => (1..=STEPS_MAX as u32).contains(&count).then_some(Self::Count(count)),
            None => word.split('.').all(is_identifier).then(|| Self::Setting(word.into())),
        }
    }

    /// What is said where it is neither.
    pub fn expected() -> String {
        format!("`x` is followed by a number of rounds from 1 to {STEPS_MAX}, or by a setting")
    }

    /// How often that is, by the settings of `name`.
    pub fn count(&self, name: &str, uniforms: &Uniforms) -> u32 {
        let count = match self {
            Self::Count(count) => Some(*count),
            Self::Setting(setting) => uniforms.count(name, &format!("{name}.{setting}")),
        };
        // A whole uniform that was set by its bytes has passed no range.
        count.unwrap_or(1).clamp(1, STEPS_MAX as u32)
    }
}

/// A number as it is written for good: digits, of which the first is not 0.
pub(crate) fn number(word: &str) -> Option<u32> {
    let is_plain = word.bytes().all(|byte| byte.is_ascii_digit()) && !word.starts_with('0');
    word.parse().ok().filter(|_| is_plain)
}

/// Whether the setting is there that says how often a pass is drawn, and bounds that.
pub(crate) fn check_rounds(
    source: Source<'_>,
    (rounds, place): (&Rounds, &Range<usize>),
    effect: &str,
    uniforms: &Uniforms,
) -> Result<(), Box<Diagnostic>> {
    let Rounds::Setting(setting) = rounds else { return Ok(()) };
    let range = uniforms.range_of_count(effect, &format!("{effect}.{setting}"));
    if range.is_some_and(|(least, most)| least >= 1.0 && most <= STEPS_MAX as f64) {
        return Ok(());
    }
    let message =
        format!("`{setting}` is not a number of rounds: a setting that is a `u32` and stays within 1..{STEPS_MAX}");
    let note = format!("it is a member of a uniform, `u32`, with a line such as `// = 4 in 1..{STEPS_MAX}` above it");
    let several = "where two uniforms have a member of that name, it is called `UNIFORM.MEMBER`";
    Err(Box::new(source.fault(place.clone(), message).note(note).note(several)))
}
