//! What can go wrong, and the exit code of each.

use manypass::Diagnostic;
use std::borrow::Cow;
use std::fmt::Display;
use std::io::Write as _;

/// The kind of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An input or output failed.
    Failed,
    /// Wrong usage.
    Usage,
    /// No usable adapter.
    NoAdapter,
    /// The device was lost.
    DeviceLost,
    /// Two pictures differ by more than is allowed.
    Different,
    /// The user said stop.
    Interrupted,
}

/// A message for the user, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Its kind.
    pub kind: Kind,
    /// One line.
    pub message: String,
    /// One line.
    pub hint: String,
    /// The whole message where it keeps its lines: it begins with `file:line:column: error:`, as editors expect.
    pub located: Option<String>,
}

impl Failure {
    /// A failure of any kind.
    pub fn new(kind: Kind, message: impl Display, hint: impl Display) -> Self {
        let line = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
        Self { kind, message: line(message.to_string()), hint: line(hint.to_string()), located: None }
    }

    /// A failure at a place in a text file.
    pub fn located(kind: Kind, diagnostic: &Diagnostic, hint: impl Display) -> Self {
        let Diagnostic { file, line, column, message, .. } = diagnostic;
        let message = format!("{file}:{line}:{column}: {message}");
        Self { located: Some(diagnostic.to_string()), ..Self::new(kind, message, hint) }
    }

    /// Wrong usage.
    pub fn usage(message: impl Display, hint: impl Display) -> Self {
        Self::new(Kind::Usage, message, hint)
    }

    /// The exit code, by contract.
    pub fn code(&self) -> u8 {
        match self.kind {
            Kind::Failed => 1,
            Kind::Usage => 2,
            Kind::NoAdapter => 3,
            Kind::DeviceLost => 4,
            Kind::Different => 5,
            Kind::Interrupted => 130,
        }
    }

    /// Says it on standard error.
    pub fn print(&self) {
        match &self.located {
            Some(text) => say(format_args!("{text}\nhint: {}", self.hint)),
            None => say(format_args!("error: {}\nhint: {}", self.message, self.hint)),
        }
    }
}

/// Writes a line to standard error, if anybody reads it: a closed or full standard error is no reason to fail.
pub fn say(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{}", shown(&line.to_string()));
}

/// A text as terminals may have it: its control characters, which could be commands to them, are written as JSON writes them.
/// Ends of lines and tabs stay. Names in files are anybody's.
pub fn shown(text: &str) -> Cow<'_, str> {
    let is_command = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    // Of those that turn the direction of writing around, what follows would read as something else.
    let turns = |c: char| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    if !text.contains(|c: char| is_command(c) || turns(c)) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_command(c) || turns(c) {
            shown.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_get_no_commands_of_names() {
        assert_eq!(shown("a\u{1b}[2J\u{7}\0b\n\tc\u{9b}é"), "a\\u001b[2J\\u0007\\u0000b\n\tc\\u009bé");
        assert_eq!(shown("x\u{202e}y"), "x\\u202ey");
        assert!(matches!(shown("plain\n"), Cow::Borrowed(_)));
    }
}
