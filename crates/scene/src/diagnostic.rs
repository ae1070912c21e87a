//! What is wrong with a text that a user wrote, a shader, a stage or a file of settings: where, and what.

use std::fmt::{self, Display, Formatter, Write as _};
use std::ops::Range;

/// A fault in a text file.
///
/// It prints as `file:line:column: error: message`, which editors know as a place to jump to; below it are the line
/// with the place marked, and the notes, each on lines of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The file, as its reader was told.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1, in characters.
    pub column: usize,
    /// What is wrong, in one line.
    pub message: String,
    /// Remarks, each in one line.
    pub notes: Vec<String>,
    /// The characters before the line's first one that is shown.
    hidden: usize,
    /// What is shown of the line; without control characters.
    shown: String,
    /// How many characters are marked.
    marked: usize,
    label: String,
}

/// A longer line is shown in part.
const SHOWN_CHARACTERS: usize = 120;
/// So many characters before the place are shown of a longer line.
const SHOWN_BEFORE: usize = 60;

impl Diagnostic {
    /// A fault at `range`, in bytes of `text`, of which the first line is marked. A range after the end is the end of
    /// the last line that is not blank.
    pub fn new(file: &str, text: &str, range: Range<usize>, message: impl Display) -> Self {
        let end = text.trim_end().len();
        let mut start = range.start.min(text.len());
        if start >= end && range.end >= text.len() {
            start = end;
        }
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let (before, after) = text.split_at(start);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let column = before[line_start..].chars().count();
        let line_text = text[line_start..].lines().next().unwrap_or_default();
        let marked = after.char_indices().take_while(|(at, c)| start + at < range.end && !matches!(c, '\n' | '\r'));
        let marked = marked.count().max(1);
        let is_long = line_text.chars().count() > SHOWN_CHARACTERS;
        let hidden = if is_long { column.saturating_sub(SHOWN_BEFORE) } else { 0 };
        let shown = line_text.chars().skip(hidden).take(SHOWN_CHARACTERS);
        Self {
            file: file.chars().map(|c| if c.is_control() { '?' } else { c }).collect(),
            line: before.matches('\n').count() + 1,
            column: column + 1,
            message: one_line(message),
            notes: Vec::new(),
            hidden,
            shown: shown.map(|c| if c.is_control() { ' ' } else { c }).collect(),
            marked: marked.min(SHOWN_CHARACTERS - SHOWN_BEFORE),
            label: String::new(),
        }
    }

    /// With words beside the marked place.
    pub fn label(mut self, label: impl Display) -> Self {
        self.label = one_line(label);
        self
    }

    /// With a remark more.
    pub fn note(mut self, note: impl Display) -> Self {
        self.notes.push(one_line(note));
        self
    }
}

/// Without line breaks, and without other control characters that a terminal would obey.
fn one_line(text: impl Display) -> String {
    let text = text.to_string();
    let words = text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join(" ")
}

impl Display for Diagnostic {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: error: {}", self.file, self.line, self.column, self.message)?;
        let line = self.line.to_string();
        let margin = " ".repeat(line.len());
        let indent = " ".repeat(self.column - 1 - self.hidden);
        write!(f, "\n{margin} |\n{line} | {}\n{margin} | {indent}{}", self.shown.trim_end(), "^".repeat(self.marked))?;
        if !self.label.is_empty() {
            write!(f, " {}", self.label)?;
        }
        for note in &self.notes {
            f.write_char('\n')?;
            write!(f, "{margin} = note: {note}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostic {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_is_a_line_and_a_column_of_characters() {
        let text = "one\n\té two\nthree\n\n";
        let at = |range| Diagnostic::new("a.txt", text, range, "wrong").to_string();
        let two = text.find("two").unwrap_or(0);
        assert_eq!(at(two..two + 3), "a.txt:2:4: error: wrong\n  |\n2 |  é two\n  |    ^^^");
        assert!(at(0..100).starts_with("a.txt:1:1: error: wrong\n  |\n1 | one\n  | ^^^"), "marks end with the line");
        assert!(at(text.len()..text.len()).starts_with("a.txt:3:6: error:"), "the last line with anything on it");
        assert!(at(9999..10000).starts_with("a.txt:3:6: error:"));
        assert!(Diagnostic::new("a.txt", "", 0..0, "empty").to_string().starts_with("a.txt:1:1: error: empty"));
    }

    #[test]
    fn long_lines_and_control_characters_are_cut() {
        let text = format!("{}HERE{}", "a".repeat(5000), "b".repeat(5000));
        let printed = Diagnostic::new("a", &text, 5000..5004, "x\ny\u{1b}[31mz").label("no\nway").to_string();
        assert!(printed.starts_with("a:1:5001: error: x y [31mz\n"), "{printed}");
        let lines: Vec<&str> = printed.lines().collect();
        assert_eq!(lines[2].find("HERE"), lines[3].find("^^^^ no way"), "{printed}");
        assert!(lines.iter().all(|line| line.chars().count() < 140), "{printed}");
    }
}
