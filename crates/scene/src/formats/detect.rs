//! What files of each format begin with. It is told without the readers, too, so that an error can say what is missing.

use super::format::Format;

/// How many bytes of a file are looked at to tell its format.
pub(super) const START_BYTES: usize = 64 << 10;

pub(super) const STL_HEADER_BYTES: usize = 84;
pub(super) const STL_TRIANGLE_BYTES: usize = 50;

/// The format of a file that begins so and has so many bytes; none where that does not tell.
pub(super) fn of_content(start: &[u8], file_bytes: u64) -> Option<Format> {
    if start.starts_with(b"ply\n") || start.starts_with(b"ply\r") {
        return Some(Format::Ply);
    }
    if start.starts_with(b"PK\x03\x04") {
        return Some(Format::ThreeMf);
    }
    if !start.starts_with(b"glTF") && stl_bytes(start) == Some(file_bytes) {
        return Some(Format::Stl);
    }
    let text = without_mark(start).trim_ascii_start();
    if start.starts_with(b"glTF") || text.starts_with(b"{") {
        return Some(Format::Gltf);
    }
    if is_stl_text(text) {
        return Some(Format::Stl);
    }
    is_obj(text).then_some(Format::Obj)
}

/// How long an STL of bytes is that begins so.
pub(super) fn stl_bytes(start: &[u8]) -> Option<u64> {
    let count = start.get(80..STL_HEADER_BYTES)?.try_into().ok()?;
    Some(STL_HEADER_BYTES as u64 + STL_TRIANGLE_BYTES as u64 * u64::from(u32::from_le_bytes(count)))
}

/// Whether a file that begins so is an STL of text. The word `solid` alone does not tell: headers of bytes begin with it,
/// too.
pub(super) fn is_stl_text(start: &[u8]) -> bool {
    let (first, rest) = first_word(start);
    let is_inside = |word: &[u8]| [&b"facet"[..], b"endsolid"].iter().any(|inside| word.eq_ignore_ascii_case(inside));
    first.eq_ignore_ascii_case(b"solid") && words(rest).any(is_inside)
}

/// Whether the first statement of a text is one of OBJ.
fn is_obj(start: &[u8]) -> bool {
    let lines = start.split(|byte| matches!(byte, b'\n' | b'\r'));
    let first = lines.map(first_word).find(|(word, _)| {
        let is_comment = word.first() == Some(&b'#');
        !word.is_empty() && !is_comment
    });
    let is_statement = |word: &[u8]| {
        [&b"v"[..], b"vt", b"vn", b"f", b"o", b"g", b"s", b"l", b"p", b"mtllib", b"usemtl"].contains(&word)
    };
    first.is_some_and(|(word, rest)| is_statement(word) && !rest.is_empty())
}

/// Without the mark that some programs write before UTF-8.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The first word, and all after it.
pub(super) fn first_word(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    let (word, rest) = line.split_at_checked(end).unwrap_or((line, &[]));
    (word, rest.trim_ascii())
}
