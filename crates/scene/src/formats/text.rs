//! Files of lines of words, in whatever encoding: only names need to be text.

use crate::gltf_file::LoadError;
use std::borrow::Cow;

/// How many bytes of a file are looked at to tell its format.
pub(super) const START_BYTES: usize = 64 << 10;

/// Without the mark that some programs write before UTF-8.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The lines with their numbers, from 1. They end in LF, CR LF or, in files of old, CR. One that ends in a backslash
/// goes on in the next.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (u32, Cow<'_, [u8]>)> {
    let mut physical = physical_lines(without_mark(bytes)).zip(1_u32..);
    std::iter::from_fn(move || {
        let (line, number) = physical.next()?;
        let Some(mut start) = without_continuation(line) else { return Some((number, Cow::Borrowed(line))) };
        let mut joined = Vec::new();
        loop {
            joined.extend(start);
            joined.push(b' ');
            let Some((next, _)) = physical.next() else { break };
            match without_continuation(next) {
                Some(goes_on) => start = goes_on,
                None => {
                    joined.extend(next);
                    break;
                }
            }
        }
        Some((number, Cow::Owned(joined)))
    })
}

/// The lines as they stand.
fn physical_lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = Some(bytes);
    std::iter::from_fn(move || {
        let bytes = rest?;
        let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let Some((line, after)) = end.and_then(|end| bytes.split_at_checked(end)) else {
            rest = None;
            return Some(bytes);
        };
        rest = after.strip_prefix(b"\r\n").or(after.get(1..));
        Some(line)
    })
}

/// A line that goes on in the next, without its backslash.
fn without_continuation(line: &[u8]) -> Option<&[u8]> {
    line.trim_ascii_end().strip_suffix(b"\\")
}

/// The words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The words before a comment, which begins with `#`.
pub(super) fn words_before_comment(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    words(line.split(|byte| *byte == b'#').next().unwrap_or_default())
}

/// The first word, and all after it.
pub(super) fn first_word(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    let (word, rest) = line.split_at_checked(end).unwrap_or((line, &[]));
    (word, rest.trim_ascii())
}

/// A finite number.
pub(super) fn number(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok().filter(|number: &f32| number.is_finite())
}

/// A finite number with all digits that doubles have, for places far from the origin.
pub(super) fn exact_number(word: &[u8]) -> Option<f64> {
    let number: f64 = std::str::from_utf8(word).ok()?.parse().ok()?;
    (number as f32).is_finite().then_some(number)
}

/// Text for messages and names: UTF-8, or else one letter a byte, as Latin-1 has it.
pub(super) fn name(bytes: &[u8]) -> String {
    let as_latin_1 = || bytes.iter().map(|byte| char::from(*byte)).collect();
    std::str::from_utf8(bytes).map_or_else(|_| as_latin_1(), str::to_owned)
}

/// A word for messages, not longer than they can take.
pub(super) fn shown(word: &[u8]) -> String {
    let text: String = name(word).chars().take(40).collect();
    text.escape_debug().to_string()
}

/// The place of a warning.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line(pub(super) u32);

impl std::fmt::Display for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}", self.0)
    }
}

/// An error in a line.
pub(super) fn at_line(line: u32, message: impl Into<String>) -> LoadError {
    LoadError::malformed(&format!("line {line}"), message)
}

/// Three finite numbers, of as many words as there are.
///
/// # Errors
/// There are fewer words, or one is no finite number.
pub(super) fn vector<'w, const N: usize>(
    words: &mut impl Iterator<Item = &'w [u8]>,
    line: u32,
) -> Result<[f32; N], LoadError> {
    values(words, line, number)
}

/// As [`vector`], a place.
///
/// # Errors
/// As [`vector`].
pub(super) fn place<'w>(words: &mut impl Iterator<Item = &'w [u8]>, line: u32) -> Result<[f64; 3], LoadError> {
    values(words, line, exact_number)
}

fn values<'w, T: Copy + Default, const N: usize>(
    words: &mut impl Iterator<Item = &'w [u8]>,
    line: u32,
    number: fn(&[u8]) -> Option<T>,
) -> Result<[T; N], LoadError> {
    let mut vector = [T::default(); N];
    for value in &mut vector {
        let word = words.next().ok_or_else(|| at_line(line, format!("expected {N} numbers, found fewer")))?;
        *value = number(word)
            .ok_or_else(|| at_line(line, format!("expected a finite number, found \"{}\"", shown(word))))?;
    }
    Ok(vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_joined_and_keep_their_numbers() {
        let found: Vec<_> = lines(b"\xef\xbb\xbfa\\\r\nb\nc \\\n\\\nd\n\\").map(|(n, l)| (n, name(&l))).collect();
        assert_eq!(found, [(1, "a b".into()), (3, "c   d".into()), (6, " ".into())]);
        let of_old: Vec<_> = lines(b"a\rb\r\nc\n\rd").map(|(n, l)| (n, name(&l))).collect();
        assert_eq!(of_old, [(1, "a".into()), (2, "b".into()), (3, "c".into()), (4, "".into()), (5, "d".into())]);
    }

    #[test]
    fn many_lines_that_go_on_take_no_longer_than_as_many_that_do_not() {
        let bytes = b"1 2 3 \\\n".repeat(300_000);
        assert_eq!(lines(&bytes).map(|(_, line)| line.len()).collect::<Vec<_>>(), [7 * 300_000]);
    }

    #[test]
    fn names_are_utf_8_or_latin_1() {
        assert_eq!((name("é".as_bytes()), name(b"\xe9")), ("é".into(), "é".into()));
    }
}
