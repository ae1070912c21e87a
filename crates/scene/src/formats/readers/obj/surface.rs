//! The triangles of an OBJ's polygons, with normals where the file has none.

use super::file::{Corner, Element, File, NONE, SurfacePart, check, elements, push_vertex};
use crate::formats::readers::parts::{Parts, by_material};
use crate::formats::readers::polygon;
use crate::formats::readers::smooth::{Smoothing, smooth, weld};
use crate::formats::readers::text::Line;
use crate::formats::readers::two_sided::{LEFT_OUT, aligned, backs};
use crate::gltf_file::LoadError;
use crate::tally::Tally;
use crate::{Primitive, Topology};
use glam::Vec3;
use std::collections::HashMap;

struct Polygon<'p> {
    element: &'p Element,
    corners: &'p [Corner],
    /// How many corners of other polygons come before its own.
    first: usize,
}

/// The sides of a polygon that are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Sides {
    #[default]
    Both,
    /// Its front alone: its back is another polygon, which looks otherwise.
    Front,
    /// Its front alone, which is the back of another polygon.
    Back,
    /// None: it is the back of one that looks the same.
    Neither,
}

/// What the polygons of a part are cut into.
#[derive(Default)]
struct Triangles {
    corners: Vec<Corner>,
    /// The welded vertex of each corner; empty where all corners have a normal.
    indices: Vec<u32>,
    /// Of each triangle.
    smoothing: Vec<Smoothing>,
    /// Of each triangle its index in the scene.
    materials: Vec<usize>,
}

/// The primitives of a part's polygons.
pub(super) fn primitives(
    file: &File,
    part: &SurfacePart,
    materials: &[usize],
    parts: &mut Parts,
) -> Result<Vec<Primitive>, LoadError> {
    let polygons = polygons(file, part)?;
    let all_corners = || polygons.iter().flat_map(|polygon| polygon.corners).copied();
    let has_normals = all_corners().all(|corner| with_direction(file, corner)[2] != NONE);
    let (mut positions, mut vertices, mut sides) = (Vec::new(), Vec::new(), Vec::new());
    if !has_normals {
        // Some exporters write a vertex for every face.
        (positions, vertices) = weld(all_corners().map(|corner| position(file, corner)));
        sides = drawn_sides(file, &polygons, &vertices, &mut parts.warnings);
    }
    let triangles = cut(file, &polygons, (&vertices[..], &sides[..]), materials, parts);
    let corners = &triangles.corners;
    let smoothed = (!has_normals).then(|| {
        smooth(&positions, &triangles.indices, |face| triangles.smoothing.get(face).copied().unwrap_or_default())
    });
    let of_corner = |i: usize| corners.get(i).copied().unwrap_or_default();
    // Normals of the file, and those that were made, are told apart by the last number.
    let key = |i: usize| {
        let corner = of_corner(i);
        let made = || smoothed.as_ref().and_then(|smoothed| smoothed.indices.get(i).copied()).unwrap_or_default();
        if corner[2] == NONE { (corner[0], corner[1], made(), true) } else { (corner[0], corner[1], corner[2], false) }
    };
    let has_uvs = corners.iter().any(|corner| corner[1] != NONE);
    Ok(by_material(&triangles.materials, key, |primitive, i| {
        let (_, _, normal, is_made) = key(i);
        let made = smoothed.as_ref().filter(|_| is_made).map(|smoothed| &smoothed.normals);
        let normals = made.unwrap_or(&file.normals);
        primitive.normals.push(normals.get(normal as usize).copied().unwrap_or([0.0, 1.0, 0.0]));
        push_vertex(file, primitive, of_corner(i), has_uvs);
    }))
}

/// The polygons of a part, which name nothing that the file does not have.
fn polygons<'p>(file: &File, part: &'p SurfacePart) -> Result<Vec<Polygon<'p>>, LoadError> {
    let (mut polygons, mut first) = (Vec::new(), 0);
    for (element, corners) in elements(part).filter(|(element, _)| element.topology == Topology::Triangles) {
        check(file, corners, element.line)?;
        polygons.push(Polygon { element, corners, first });
        first += corners.len();
    }
    Ok(polygons)
}

fn position(file: &File, [position, ..]: Corner) -> [f32; 3] {
    file.positions.get(position as usize).copied().unwrap_or_default()
}

/// A corner whose normal has a direction, or that has none.
fn with_direction(file: &File, [position, uv, normal]: Corner) -> Corner {
    let has_direction = file.normals.get(normal as usize).is_some_and(|normal| *normal != [0.0; 3]);
    [position, uv, if has_direction { normal } else { NONE }]
}

/// Which sides of polygons are drawn whose corners are the welded `vertices`; empty where both sides of all are. All
/// materials have two sides, so that a back that looks as its front does is left out.
fn drawn_sides(file: &File, polygons: &[Polygon], vertices: &[u32], warnings: &mut Tally) -> Vec<Sides> {
    let face = |place: usize| {
        let range = polygons.get(place).map(|polygon| polygon.first..polygon.first + polygon.corners.len());
        range.and_then(|range| vertices.get(range)).unwrap_or_default()
    };
    let look = |place: usize, corner: usize| {
        let polygon = polygons.get(place)?;
        let [position, uv, _] = polygon.corners.get(corner).copied()?;
        Some((polygon.element.material, file.uvs.get(uv as usize), file.colors.get(position as usize)))
    };
    let mut sides = Vec::new();
    for (back, front) in backs(polygons.len(), face) {
        sides.resize(polygons.len(), Sides::Both);
        let looks_same = aligned(face(back), face(front)).all(|(a, b)| look(back, a) == look(front, b));
        let mut set = |place: usize, drawn: Sides| {
            if let Some(slot) = sides.get_mut(place) {
                *slot = drawn;
            }
        };
        if looks_same {
            set(back, Sides::Neither);
            let line = polygons.get(back).map_or(0, |polygon| polygon.element.line);
            warnings.add(Line(line), LEFT_OUT);
        } else {
            set(front, Sides::Front);
            set(back, Sides::Back);
        }
    }
    sides
}

/// Cuts polygons into triangles.
fn cut(
    file: &File,
    polygons: &[Polygon],
    (vertices, sides): (&[u32], &[Sides]),
    materials: &[usize],
    parts: &mut Parts,
) -> Triangles {
    let mut triangles = Triangles::default();
    let mut one_sided = HashMap::new();
    for (place, Polygon { element, corners, first }) in polygons.iter().enumerate() {
        let sides = sides.get(place).copied().unwrap_or_default();
        if sides == Sides::Neither {
            continue;
        }
        let points: Vec<Vec3> = corners.iter().map(|corner| position(file, *corner).into()).collect();
        let cut = polygon::triangles(&points);
        if cut.is_guessed {
            parts.warnings.add(Line(element.line), polygon::GUESSED);
        }
        let mut material = materials.get(element.material).copied().unwrap_or_default();
        if sides != Sides::Both {
            material = *one_sided.entry(material).or_insert_with(|| parts.one_sided(material));
        }
        let smoothing = match (sides, element.smoothing) {
            (Sides::Back, Smoothing::Group(group)) => Smoothing::BackOfGroup(group),
            (_, smoothing) => smoothing,
        };
        for triangle in cut.triangles {
            let of_triangle = triangle.iter().filter_map(|&i| corners.get(i));
            triangles.corners.extend(of_triangle.map(|corner| with_direction(file, *corner)));
            triangles.indices.extend(triangle.iter().filter_map(|&i| vertices.get(first + i)));
            triangles.smoothing.push(smoothing);
            triangles.materials.push(material);
        }
    }
    triangles
}
