//! STL (3D Systems 1989): triangles without order, as text or as bytes. It has no units and no materials.
//!
//! Corners at one place are joined, so that normals can be smooth; those in the file are not used, since they are flat
//! and often wrong. Z points up, as on the machines that print such files.

use super::parts::{Extent, NO_COLOR_LINEAR, Parts, from_origin, linear, plain_material, y_up};
use super::smooth::{Smoothing, smooth};
use super::text::{self, Line, at_line};
use crate::Primitive;
use crate::formats::detect::{START_BYTES, STL_HEADER_BYTES, STL_TRIANGLE_BYTES, is_stl_text, stl_bytes};
use crate::gltf_file::{LoadError, LoadedScene};
use crate::tally::Tally;
use glam::Vec3;
use std::collections::HashMap;

/// A body of the file.
#[derive(Default)]
struct Solid {
    name: String,
    positions: Vec<[f32; 3]>,
    vertices: HashMap<[u32; 3], u32>,
    indices: Vec<u32>,
    /// The colour of each triangle as light, if any has one.
    colors: Vec<[f32; 4]>,
}

/// How the two bytes behind each triangle are read.
#[derive(Clone, Copy, Debug)]
enum Colors {
    /// VisCAM and SolidView: red in the highest five bits, and a triangle has a colour where bit 15 is set.
    OfBit15,
    /// Materialise Magics: red in the lowest five bits, and a triangle has a colour where bit 15 is not set; the others
    /// have that of the header.
    Header([u8; 4]),
}

impl Colors {
    fn of_header(header: &[u8]) -> Self {
        let at = header.windows(6).position(|bytes| bytes == b"COLOR=");
        match at.and_then(|at| header.get(at + 6..at + 10)) {
            Some(&[r, g, b, a]) => Self::Header([r, g, b, a]),
            _ => Self::OfBit15,
        }
    }

    /// The sRGB colour of a triangle; none where it says none.
    fn of_triangle(self, word: u16) -> Option<[f32; 4]> {
        let [low, middle, high] = [0, 5, 10].map(|shift| f32::from(word >> shift & 31) / 31.0);
        match self {
            Self::OfBit15 => (word & 0x8000 != 0).then_some([high, middle, low, 1.0]),
            Self::Header(of_object) if word & 0x8000 != 0 => {
                let [r, g, b, _] = of_object.map(|byte| f32::from(byte) / 255.0);
                Some([r, g, b, 1.0])
            }
            Self::Header(_) => Some([low, middle, high, 1.0]),
        }
    }
}

impl Solid {
    /// Adds a corner, whose Y points up.
    fn corner(&mut self, position: [f32; 3]) {
        // Both zeros are one place.
        let position = position.map(|value| value + 0.0);
        let vertex = *self.vertices.entry(position.map(f32::to_bits)).or_insert_with(|| {
            self.positions.push(position);
            self.positions.len() as u32 - 1
        });
        self.indices.push(vertex);
    }
}

pub(super) fn load(bytes: &[u8]) -> Result<LoadedScene, LoadError> {
    let start = bytes.get(..START_BYTES).unwrap_or(bytes);
    let mut parts = Parts::default();
    let is_binary = stl_bytes(start) == Some(bytes.len() as u64) || !is_stl_text(text::without_mark(start));
    let (solids, origin) = match is_binary {
        true => (vec![read_binary(bytes, &mut parts)?], Vec3::ZERO),
        false => read_near(bytes, &mut parts.warnings)?,
    };
    let has_colors = solids.iter().any(|solid| !solid.colors.is_empty());
    let material = parts.material(plain_material(has_colors));
    for solid in solids {
        if solid.indices.is_empty() {
            continue;
        }
        let Solid { name, positions, indices, vertices, colors } = solid;
        drop(vertices);
        let smoothed = smooth(&positions, &indices, |_| Smoothing::ByAngle);
        let corners = smoothed.source.iter();
        let mut primitive = Primitive {
            positions: corners.filter_map(|&vertex| positions.get(vertex as usize).copied()).collect(),
            normals: smoothed.normals,
            indices: smoothed.indices,
            material: Some(material),
            ..Primitive::default()
        };
        if has_colors {
            color_triangles(&mut primitive, &colors);
        }
        let node = parts.add(&name, vec![primitive]);
        parts.scene.node_mut(node).translation = origin;
    }
    parts.finish()
}

/// Gives triangles their colours; vertices between different colours are split.
fn color_triangles(primitive: &mut Primitive, colors: &[[f32; 4]]) {
    let (mut source, mut known) = (Vec::new(), HashMap::new());
    for (corner, index) in primitive.indices.iter_mut().enumerate() {
        let color = colors.get(corner / 3).copied().unwrap_or(NO_COLOR_LINEAR);
        *index = *known.entry((*index, color.map(f32::to_bits))).or_insert_with(|| {
            source.push(*index as usize);
            primitive.colors.push(color);
            source.len() as u32 - 1
        });
    }
    for attribute in [&mut primitive.positions, &mut primitive.normals] {
        *attribute = source.iter().filter_map(|index| attribute.get(*index).copied()).collect();
    }
}

fn read_binary(bytes: &[u8], parts: &mut Parts) -> Result<Solid, LoadError> {
    let Some(expected) = stl_bytes(bytes) else {
        let message = format!(
            "not an STL file: it has {} bytes, and the header of one takes {STL_HEADER_BYTES}; is it cut off?",
            bytes.len()
        );
        return Err(LoadError::malformed("", message));
    };
    let count = (expected - STL_HEADER_BYTES as u64) / STL_TRIANGLE_BYTES as u64;
    if expected > bytes.len() as u64 {
        let message = format!(
            "the header counts {count} triangles, which take {expected} bytes, and the file has {}; is it cut off?",
            bytes.len()
        );
        return Err(LoadError::malformed("byte 80", message));
    }
    if expected < bytes.len() as u64 {
        parts.warn(format!("byte {expected}: what follows the last of {count} triangles is passed over"));
    }
    let colors = Colors::of_header(bytes.get(..80).unwrap_or_default());
    let mut solid = Solid::default();
    let records = bytes.get(STL_HEADER_BYTES..expected as usize).unwrap_or_default().chunks_exact(STL_TRIANGLE_BYTES);
    for (i, record) in records.enumerate() {
        // The normal comes first.
        for (corner, words) in record.get(12..48).unwrap_or_default().chunks_exact(12).enumerate() {
            let mut position = [0.0; 3];
            for (value, word) in position.iter_mut().zip(words.chunks_exact(4)) {
                *value = word.try_into().map_or(f32::NAN, f32::from_le_bytes);
            }
            if position.iter().any(|value| !value.is_finite()) {
                let place = format!("byte {}", STL_HEADER_BYTES + i * STL_TRIANGLE_BYTES + 12 + 12 * corner);
                let message = format!("a corner of triangle {i} is at {position:?}, which is not a position");
                return Err(LoadError::malformed(&place, message));
            }
            solid.corner(y_up(position));
        }
        let word = record.get(48..50).and_then(|bytes| bytes.try_into().ok()).map_or(0, u16::from_le_bytes);
        if let Some(color) = colors.of_triangle(word) {
            solid.colors.resize(i, NO_COLOR_LINEAR);
            solid.colors.push(linear(color));
        }
    }
    if !solid.colors.is_empty() {
        solid.colors.resize(solid.indices.len() / 3, NO_COLOR_LINEAR);
    }
    Ok(solid)
}

/// What ended files before their lengths were known (CP/M, DOS), and what fills a last block.
fn without_end_marks(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|byte| !matches!(byte, 0 | 0x1a) && !byte.is_ascii_whitespace());
    bytes.get(..end.map_or(0, |last| last + 1)).unwrap_or_default()
}

/// The solids of a text, and where their corners are told from: text has more digits than floats far away.
fn read_near(bytes: &[u8], warnings: &mut Tally) -> Result<(Vec<Solid>, Vec3), LoadError> {
    let mut extent = Extent::default();
    let solids = read_text(bytes, Vec3::ZERO, &mut extent, warnings)?;
    let origin = extent.origin();
    if origin == Vec3::ZERO {
        return Ok((solids, origin));
    }
    // Few files lie so far away: reading them twice takes less than doubles of all would take of all files.
    drop(solids);
    Ok((read_text(bytes, origin, &mut extent, &mut Tally::default())?, origin))
}

/// The solids of a text, their corners told from `origin`, whose Y points up.
fn read_text(bytes: &[u8], origin: Vec3, extent: &mut Extent, warnings: &mut Tally) -> Result<Vec<Solid>, LoadError> {
    let (mut solids, mut solid) = (Vec::new(), Solid::default());
    let (mut is_open, mut facet_line, mut last_line) = (false, None, 1);
    for (line, content) in text::lines(without_end_marks(bytes)) {
        last_line = line;
        let (keyword, rest) = text::first_word(&content);
        let mut keyword = keyword.to_ascii_lowercase();
        if keyword == b"end" {
            let (second, _) = text::first_word(rest);
            keyword.extend(second.to_ascii_lowercase());
            warnings.add(Line(line), "\"end\" and what ends are two words; they are read as one");
        }
        match keyword.as_slice() {
            b"solid" => {
                solids.push(std::mem::take(&mut solid));
                solid.name = text::name(rest);
                is_open = true;
            }
            b"facet" if facet_line.is_some() => return Err(at_line(line, "a facet begins before the last one ended")),
            b"facet" => facet_line = Some(line),
            b"vertex" => {
                if facet_line.is_none() {
                    return Err(at_line(line, "a vertex stands outside of a facet"));
                }
                let place = y_up(text::place(&mut text::words(rest), line)?);
                extent.add(place);
                solid.corner(from_origin(place, origin));
            }
            b"endfacet" => {
                if solid.indices.len() % 3 != 0 || facet_line.take().is_none() {
                    return Err(at_line(line, "a facet ends that does not have three vertices"));
                }
            }
            b"endsolid" => is_open = false,
            b"" | b"outer" | b"endloop" => {}
            _ => {
                let message = format!("\"{}\" is not a word of STL", text::shown(&keyword));
                return Err(at_line(line, message));
            }
        }
    }
    if facet_line.is_some() {
        return Err(at_line(last_line, "the file ends within a facet; is it cut off?"));
    }
    if is_open {
        warnings.add(Line(last_line), "the file ends before the solid does; all its facets are whole");
    }
    solids.push(solid);
    Ok(solids)
}
