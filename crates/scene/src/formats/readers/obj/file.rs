//! An OBJ as it is read: attributes, and elements that name them.

use crate::formats::readers::mtl;
use crate::formats::readers::smooth::Smoothing;
use crate::formats::readers::text::at_line;
use crate::gltf_file::LoadError;
use crate::tally::Tally;
use crate::{Primitive, Topology};
use glam::Vec3;
use std::collections::HashMap;

/// What stands where a corner has no texture coordinate or no normal.
pub(super) const NONE: u32 = u32::MAX;

/// A corner: indices of its position, texture coordinate and normal.
pub(super) type Corner = [u32; 3];

/// A polygon, a line or points, up to the corner at `end`.
pub(super) struct Element {
    pub(super) end: u32,
    pub(super) line: u32,
    pub(super) topology: Topology,
    pub(super) smoothing: Smoothing,
    pub(super) material: usize,
}

#[derive(Default)]
pub(super) struct SurfacePart {
    pub(super) name: String,
    pub(super) corners: Vec<Corner>,
    pub(super) elements: Vec<Element>,
}

#[derive(Default)]
pub(super) struct File {
    /// Positions as they are read.
    pub(super) places: Vec<[f64; 3]>,
    /// Positions from `origin` on, once all are read.
    pub(super) positions: Vec<[f32; 3]>,
    /// The middle of what lies away from the origin of the file.
    pub(super) origin: Vec3,
    /// As many as positions, if any has one.
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) parts: Vec<SurfacePart>,
    pub(super) part_of: HashMap<String, usize>,
    /// Names of materials, and their indices here; the first is that of what has none.
    pub(super) materials: Vec<String>,
    pub(super) material_of: HashMap<String, usize>,
    pub(super) libraries: Vec<mtl::NamedFile>,
    pub(super) warnings: Tally,
}

/// The elements of a part with their corners.
pub(super) fn elements(part: &SurfacePart) -> impl Iterator<Item = (&Element, &[Corner])> {
    let mut start = 0;
    part.elements.iter().map(move |element| {
        let corners = part.corners.get(start..element.end as usize).unwrap_or_default();
        start = element.end as usize;
        (element, corners)
    })
}

/// What no element may name: an attribute that the file does not have.
pub(super) fn check(file: &File, corners: &[Corner], line: u32) -> Result<(), LoadError> {
    let counts = [file.positions.len(), file.uvs.len(), file.normals.len()];
    for corner in corners {
        for ((index, count), what) in corner.iter().zip(counts).zip(["v", "vt", "vn"]) {
            if *index != NONE && *index as usize >= count {
                return Err(at_line(
                    line,
                    format!("{what} {} is named, and the file has {count}", u64::from(*index) + 1),
                ));
            }
        }
    }
    Ok(())
}

/// Adds a vertex but for its normal.
pub(super) fn push_vertex(file: &File, primitive: &mut Primitive, [position, uv, _]: Corner, has_uvs: bool) {
    primitive.positions.push(file.positions.get(position as usize).copied().unwrap_or_default());
    if has_uvs {
        primitive.uv0.push(file.uvs.get(uv as usize).copied().unwrap_or_default());
    }
    if !file.colors.is_empty() {
        primitive.colors.push(file.colors.get(position as usize).copied().unwrap_or([1.0; 4]));
    }
}
