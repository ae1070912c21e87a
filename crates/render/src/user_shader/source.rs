//! The text of a shader of the user's.

use super::scan::Scan;
use crate::diagnostic::Diagnostic;
use std::ops::Range;

/// The longest name that a header gives.
const NAME_CHARACTERS: usize = 64;

/// Whether a word can name something in a shader, but for the language's own words.
pub(crate) fn is_identifier(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && word != "_"
        && !word.starts_with("__")
}

/// A text of the user's, and how a fault in it is told.
#[derive(Clone, Copy)]
pub(crate) struct Source<'t> {
    /// The file's name, for errors.
    pub file: &'t str,
    /// The file's text.
    pub text: &'t str,
}

impl<'t> Source<'t> {
    /// A fault at a place.
    pub fn fault(&self, range: Range<usize>, message: impl std::fmt::Display) -> Box<Diagnostic> {
        Box::new(Diagnostic::new(self.file, self.text, range, message))
    }

    /// The lines of the header without their `//!`, each with the byte at which it begins.
    ///
    /// # Errors
    /// One that is not at the top.
    pub fn header_lines(&self, scan: &Scan) -> Result<Vec<(usize, &'t str)>, Box<Diagnostic>> {
        let mut lines = Vec::new();
        for comment in &scan.comments {
            let Some(line) = self.text[comment.range.clone()].strip_prefix("//!") else { continue };
            if comment.range.start > scan.first_token {
                let message = "a line of the header stands below the first declaration";
                let fault = self.fault(comment.range.clone(), message);
                return Err(Box::new(
                    fault.note("header lines (`//!`) are the first lines; other remarks begin with `//`"),
                ));
            }
            lines.push((comment.range.end - line.trim_start().len(), line.trim()));
        }
        Ok(lines)
    }
}

pub(crate) fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.len() <= NAME_CHARACTERS
        && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'))
}

/// The entries of a list with commas, each with its bytes; the list begins at the byte `start`.
pub(crate) fn entries(list: &str, start: usize) -> impl Iterator<Item = (&str, Range<usize>)> {
    let mut at = start;
    list.split(',').map(move |part| {
        let begin = at + part.len() - part.trim_start().len();
        at += part.len() + 1;
        let name = part.trim();
        (name, begin..begin + name.len().max(1))
    })
}
