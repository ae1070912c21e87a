//! What is wrong with a PLY file, in words: the parser speaks of its grammar.

use super::number::number;
use crate::gltf_file::LoadError;
use ply_rs_bw::parser::ParseError;
use ply_rs_bw::ply::{ElementDef, PropertyType};
use std::io::ErrorKind;

/// So much of a line or a word of the file is shown.
const SHOWN_CHARACTERS: usize = 60;
/// So many properties of an element are named.
const NAMED_MAX: usize = 12;

/// What is wrong with the header of the file `bytes`.
pub(super) fn of_header(error: &ParseError, bytes: &[u8]) -> LoadError {
    let said = error.to_string();
    let place = error.line().map_or_else(String::new, |line| format!("line {line}"));
    let text = error.line().map(|line| line_of(bytes, line)).unwrap_or_default();
    let message = if error.kind() == ErrorKind::UnexpectedEof {
        "the header ends early, is the file cut off? expected a line \"end_header\"".to_owned()
    } else if error.kind() == ErrorKind::InvalidData {
        "the header is not text".to_owned()
    } else if said.contains("without preceding element") {
        format!("\"{text}\" belongs to no element; expected a line \"element NAME COUNT\" before it")
    } else if said.contains("contradicting") {
        format!("\"{text}\" is a second format; expected one")
    } else if text.is_empty() {
        format!("the header names no format; expected {FORMATS}")
    } else {
        let expected = match (error.line(), text.split_whitespace().next()) {
            (Some(1), _) => "a line \"ply\"",
            (_, Some("format")) => FORMATS,
            (_, Some("element")) => "\"element NAME COUNT\", where COUNT is a number from 0",
            (_, Some("property")) => {
                "\"property TYPE NAME\" or \"property list TYPE TYPE NAME\", \
                 where TYPE is char, uchar, short, ushort, int, uint, float or double"
            }
            _ => "format, comment, obj_info, element, property or end_header",
        };
        format!("cannot read \"{text}\"; expected {expected}")
    };
    LoadError::malformed(&place, message)
}

const FORMATS: &str = "\"format ascii 1.0\", \"format binary_little_endian 1.0\" or \"format binary_big_endian 1.0\"";

/// What is wrong with an element of a file of bytes that begins at the byte `start`.
pub(super) fn of_element(error: &ParseError, element: &ElementDef, start: usize) -> LoadError {
    let said = error.to_string();
    let message = if error.kind() == ErrorKind::UnexpectedEof {
        ends_early(element)
    } else if said.contains("unsupported by the destination") {
        no_indices(element)
    } else if said.contains("negative") {
        negative_length(element)
    } else {
        format!("the element \"{}\" cannot be read; expected {}", element.name, expected(element))
    };
    LoadError::malformed(&format!("after byte {start}"), message)
}

pub(super) fn ends_early(element: &ElementDef) -> String {
    let (name, count) = (&element.name, element.count);
    format!("the file ends early, is it cut off? The header counts {count} of the element \"{name}\"")
}

pub(super) fn no_indices(element: &ElementDef) -> String {
    format!("an index of the element \"{}\" is not a list of whole numbers", element.name)
}

pub(super) fn negative_length(element: &ElementDef) -> String {
    format!("a list of the element \"{}\" has a length below 0", element.name)
}

/// What is wrong with the line of an element in a file of text.
pub(super) fn of_line(text: &str, element: &ElementDef) -> String {
    let expected = expected(element);
    match text.split_whitespace().find(|word| number(word.as_bytes()).is_none()) {
        Some(word) => format!("\"{}\" is not a number; expected {expected}", shown(word)),
        None => format!("cannot read \"{text}\"; expected {expected}"),
    }
}

/// The properties of an element and their types.
fn expected(element: &ElementDef) -> String {
    let named = element.properties.values().take(NAMED_MAX).map(|property| match &property.data_type {
        PropertyType::Scalar(kind) => format!("{} ({})", property.name, format!("{kind:?}").to_lowercase()),
        PropertyType::List(_, kind) => {
            format!("{} (how many, then each {})", property.name, format!("{kind:?}").to_lowercase())
        }
    });
    let more = if element.properties.len() > NAMED_MAX { ", …" } else { "" };
    format!("{}{more}", named.collect::<Vec<_>>().join(", "))
}

/// A line of the file, from 1, as much as is shown of it.
fn line_of(bytes: &[u8], line: usize) -> String {
    shown_line(bytes.split(|byte| *byte == b'\n').nth(line.saturating_sub(1)).unwrap_or_default())
}

/// What is shown of a line.
pub(super) fn shown_line(line: &[u8]) -> String {
    let text = line.get(..4 * SHOWN_CHARACTERS).unwrap_or(line);
    shown(String::from_utf8_lossy(text).trim())
}

/// What is shown of a text.
fn shown(text: &str) -> String {
    let mut shown: String = text.chars().take(SHOWN_CHARACTERS).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(SHOWN_CHARACTERS).is_some() {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::super::load;

    /// What is said of a file with these lines, of which those after the header are bytes.
    fn said(lines: &str, bytes: &[u8]) -> String {
        let error = load(&[lines.as_bytes(), bytes].concat(), &mut |_| Err(String::new())).err();
        error.map_or_else(String::new, |error| error.to_string())
    }

    #[test]
    fn the_line_and_what_is_expected_are_named_in_words() {
        let vertex = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
        let text = format!("ply\nformat ascii 1.0\n{vertex}end_header\n");
        let binary = format!(
            "ply\nformat binary_little_endian 1.0\n{vertex}element face 2\n\
             property list uchar int vertex_indices\nend_header\n"
        );
        let of_floats =
            text.replace("end_header", "element face 1\nproperty list uchar float vertex_indices\nend_header");
        let place: [u8; 12] = [0; 12];
        let faces = [&place[..], &[3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0]].concat();
        let cases = [
            ("plx\n".into(), &[][..], "line 1", "expected a line \"ply\""),
            (text.replace("ascii", "binary_middle_endian"), &[], "line 2", "cannot read \"format binary_middle_endian"),
            (text.replace("format ascii 1.0\n", ""), &[], "", "names no format; expected \"format ascii 1.0\""),
            (text.replace("vertex 1", "vertex -8"), &[], "line 3", "where COUNT is a number from 0"),
            (text.replace("float y", "half y"), &[], "line 5", "where TYPE is char, uchar"),
            (text.replace("element vertex 1\n", ""), &[], "line 3", "belongs to no element"),
            (text.replace("end_header\n", ""), &[], "", "expected a line \"end_header\""),
            (text.replace("end_header", "ende"), &[], "line 7", "element, property or end_header"),
            (text.clone(), b"0 one 0\n", "line 8", "\"one\" is not a number; expected x (float), y (float), z (float)"),
            (text.clone(), b"0 1  \n     ", "line 8", "cannot read \"0 1\"; expected x (float)"),
            (text.clone(), b"\n\n0 1..2\n", "line 10", "\"1..2\" is not a number"),
            (of_floats, b"0 0 0\n3 0 0 0\n", "line 11", "\"face\" is not a list of whole numbers"),
            (binary, &faces, "after byte", "The header counts 2 of the element \"face\""),
        ];
        for (lines, bytes, place, part) in cases {
            let said = said(&lines, bytes);
            assert!(said.contains(place) && said.contains(part), "{lines}: {said}");
            assert!(!said.contains("Error") && !said.contains("ExpectedSet") && !said.contains('\\'), "{said}");
        }
    }

    #[test]
    fn long_lines_and_control_characters_are_cut() {
        let said = said(&format!("ply\n\u{1b}[31m{}\n", "a".repeat(5000)), &[]);
        assert!(said.len() < 300 && !said.contains('\u{1b}'), "{said}");
    }
}
