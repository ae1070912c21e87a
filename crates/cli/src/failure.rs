//! What can go wrong, and the exit code of each.

use manypass::Diagnostic;
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
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
