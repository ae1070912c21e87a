//! The elements of a PLY file of text, one a line.

use super::faults;
use super::number::number;
use crate::formats::readers::text::{at_line, words};
use crate::gltf_file::LoadError;
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};

/// The lines that are left of a file.
pub(super) struct Lines<'a> {
    pub(super) rest: &'a [u8],
    /// The number of the next one, from 1.
    pub(super) next: u32,
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u32, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(|byte| *byte == b'\n');
            let (line, rest) = self.rest.split_at_checked(end.unwrap_or(self.rest.len()))?;
            self.rest = rest.get(1..).unwrap_or_default();
            self.next += 1;
            if !line.trim_ascii().is_empty() {
                return Some((self.next - 1, line));
            }
        }
        None
    }
}

/// Every one of an element.
///
/// # Errors
/// The lines end early, or one does not hold what the header says.
pub(super) fn read<E: PropertyAccess>(lines: &mut Lines, element: &ElementDef) -> Result<Vec<E>, LoadError> {
    // The count was checked against the length of the file.
    let mut all = Vec::with_capacity(element.count);
    while all.len() < element.count {
        let Some((number, line)) = lines.next() else {
            return Err(at_line(lines.next.saturating_sub(1), faults::ends_early(element)));
        };
        all.push(read_line(line, element).map_err(|fault| match fault {
            Fault::Line => at_line(number, faults::of_line(&faults::shown_line(line), element)),
            Fault::Length => at_line(number, faults::negative_length(element)),
            Fault::Type => at_line(number, faults::no_indices(element)),
        })?);
    }
    Ok(all)
}

/// What is wrong with a line.
enum Fault {
    Line,
    Length,
    Type,
}

fn read_line<E: PropertyAccess>(line: &[u8], element: &ElementDef) -> Result<E, Fault> {
    let (mut found, mut words) = (E::new(), words(line));
    for property in element.properties.values() {
        let value = match &property.data_type {
            PropertyType::Scalar(kind) => scalar(kind, words.next().and_then(number).ok_or(Fault::Line)?),
            PropertyType::List(_, kind) => {
                let count = words.next().and_then(number).ok_or(Fault::Line)?;
                if count < 0.0 {
                    return Err(Fault::Length);
                }
                // As many as there are words: a count alone takes no memory.
                let values: Vec<f64> = words.by_ref().take(count as usize).map_while(number).collect();
                if values.len() as f64 != count {
                    return Err(Fault::Line);
                }
                list(kind, values)
            }
        };
        if found.set_property(&property.name, value) == PropertyAccessResult::UnsupportedType {
            return Err(Fault::Type);
        }
    }
    Ok(found)
}

fn scalar(kind: &ScalarType, value: f64) -> Property {
    match kind {
        ScalarType::Char => Property::Char(value as i8),
        ScalarType::UChar => Property::UChar(value as u8),
        ScalarType::Short => Property::Short(value as i16),
        ScalarType::UShort => Property::UShort(value as u16),
        ScalarType::Int => Property::Int(value as i32),
        ScalarType::UInt => Property::UInt(value as u32),
        // Text has the digits that it has, whatever type the header gives it.
        ScalarType::Float | ScalarType::Double => Property::Double(value),
    }
}

fn list(kind: &ScalarType, values: Vec<f64>) -> Property {
    let values = values.into_iter();
    match kind {
        ScalarType::Char => Property::ListChar(values.map(|value| value as i8).collect()),
        ScalarType::UChar => Property::ListUChar(values.map(|value| value as u8).collect()),
        ScalarType::Short => Property::ListShort(values.map(|value| value as i16).collect()),
        ScalarType::UShort => Property::ListUShort(values.map(|value| value as u16).collect()),
        ScalarType::Int => Property::ListInt(values.map(|value| value as i32).collect()),
        ScalarType::UInt => Property::ListUInt(values.map(|value| value as u32).collect()),
        ScalarType::Float => Property::ListFloat(values.map(|value| value as f32).collect()),
        ScalarType::Double => Property::ListDouble(values.collect()),
    }
}
