//! PLY (Turk 1994): meshes and clouds of points, as scanners write them; text, or bytes in either order. It has no
//! units, and is taken as it is: Y points up.

mod contents;
mod elements;
mod faults;
mod number;
mod surface;
mod text;

use super::mtl::NamedFile;
use super::parts::{Parts, plain_material};
use super::polygon;
use super::smooth::{Smoothing, smooth, weld};
use crate::gltf_file::{LoadError, LoadedScene};
use crate::tally::Tally;
use crate::{Primitive, Topology};
use contents::{Contents, Resolve, Triangles, VertexAttributes, WithNormals, is_placed};
use elements::Nothing;
use glam::Vec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyAccess, PropertyType, ScalarType};
use std::collections::HashMap;
use surface::{Surfaces, set_attributes};

/// The textures that a file names in the comments of its header, as MeshLab writes them.
fn textures(header: &Header) -> Vec<NamedFile> {
    let named = header.comments.iter().filter_map(|comment| {
        let (word, name) = comment.trim().split_once(char::is_whitespace)?;
        word.eq_ignore_ascii_case("TextureFile").then(|| NamedFile::new("", name))
    });
    named.filter(|named| !named.path.is_empty()).collect()
}

/// The files that a PLY names.
pub(super) fn names(start: &[u8]) -> Vec<String> {
    let header = Parser::<Nothing>::new().read_header(&mut Reader::new(start)).ok();
    header.iter().flat_map(textures).flat_map(|named| named.all().map(str::to_owned).collect::<Vec<_>>()).collect()
}

pub(super) fn load(bytes: &[u8], resolve: &mut Resolve) -> Result<LoadedScene, LoadError> {
    let mut reader = Reader::new(bytes);
    let parser = Parser::<Nothing>::new();
    let header = parser.read_header(&mut reader).map_err(|error| faults::of_header(&error, bytes))?;
    let vertex = header.elements.get("vertex");
    let vertex = vertex.ok_or_else(|| LoadError::malformed("", "the header has no element \"vertex\""))?;
    for name in ["x", "y", "z"] {
        if !matches!(vertex.properties.get(name).map(|found| &found.data_type), Some(PropertyType::Scalar(_))) {
            return Err(LoadError::malformed("", format!("the header gives vertices no number \"{name}\"")));
        }
    }
    let has = |names: &[&str]| names.iter().any(|name| vertex.properties.contains_key(*name));
    let has = VertexAttributes {
        normals: has(&["nx"]),
        colors: has(&["red", "r", "diffuse_red"]),
        uvs: has(&["s", "u", "texture_u"]),
    };
    let mut contents = read(&mut reader, &header, bytes)?;
    let origin = contents.bring_near();
    let mut parts = Parts::default();
    elements::unread(&header).iter().for_each(|warning| parts.warn(warning));
    let surfaces = Surfaces::of(&header, has);
    let primitives = if contents.has_faces {
        let triangles = triangles(&contents, surfaces.are_of_faces(), &mut parts.warnings)?;
        let source = normals(&contents, &triangles, has);
        let materials = surfaces.materials(&textures(&header), &mut parts, resolve);
        surfaces.primitives(&contents, &triangles, &source, &materials)
    } else {
        let count = contents.vertices.len();
        contents.vertices.retain(is_placed);
        let lost = count - contents.vertices.len();
        if lost > 0 {
            parts.warn(format!(
                "{lost} of {count} points have no position (their coordinates are not numbers); they are left out"
            ));
        }
        let material = parts.material(plain_material(has.colors));
        let mut points = Primitive { topology: Topology::Points, material: Some(material), ..Primitive::default() };
        contents.vertices.iter().for_each(|vertex| set_attributes(&mut points, vertex, has));
        if has.normals {
            points.normals = contents.vertices.iter().map(|vertex| unit(vertex.normal)).collect();
        }
        vec![points]
    };
    let primitives: Vec<Primitive> =
        primitives.into_iter().filter(|primitive| !primitive.positions.is_empty()).collect();
    if !primitives.is_empty() {
        let node = parts.add("", primitives);
        parts.scene.node_mut(node).translation = origin;
    }
    parts.finish()
}

fn unit(normal: [f32; 3]) -> [f32; 3] {
    Vec3::from(normal).try_normalize().unwrap_or(Vec3::Y).to_array()
}

/// The normals of the file, or those that are made.
fn normals(contents: &Contents, triangles: &Triangles, has: VertexAttributes) -> WithNormals {
    let vertices = &contents.vertices;
    if has.normals {
        let normals = vertices.iter().map(|vertex| unit(vertex.normal)).collect();
        let source = (0..vertices.len() as u32).collect();
        return WithNormals { of_corner: triangles.indices.clone(), source, normals };
    }
    let (positions, places) = weld(vertices.iter().map(|vertex| vertex.position));
    let indices: Vec<u32> = triangles.indices.iter().filter_map(|&index| places.get(index as usize).copied()).collect();
    let smoothed = smooth(&positions, &indices, |_| Smoothing::ByAngle);
    // A vertex for every pair of a vertex and a normal.
    let (mut source, mut normals, mut known) = (Vec::new(), Vec::new(), HashMap::new());
    let of_corner = triangles.indices.iter().zip(smoothed.indices).map(|(&index, normal)| {
        *known.entry((index, normal)).or_insert_with(|| {
            source.push(index);
            normals.push(smoothed.normals.get(normal as usize).copied().unwrap_or([0.0, 1.0, 0.0]));
            source.len() as u32 - 1
        })
    });
    let of_corner = of_corner.collect();
    WithNormals { of_corner, source, normals }
}

/// Reads the elements in their order.
fn read<'b>(reader: &mut Reader<&'b [u8]>, header: &Header, bytes: &'b [u8]) -> Result<Contents, LoadError> {
    let mut contents = Contents::default();
    let rest = *reader.get_ref();
    let in_header = bytes.get(..bytes.len() - rest.len()).unwrap_or_default();
    let lines = text::Lines { rest, next: in_header.iter().filter(|byte| **byte == b'\n').count() as u32 + 1 };
    let mut payload = Payload { reader, header, bytes, lines };
    for element in header.elements.values() {
        check_count(element, header, payload.left_bytes())?;
        match element.name.as_str() {
            "vertex" => {
                contents.vertices = payload.read(element)?;
                contents.has_vertices = true;
            }
            "face" => {
                contents.faces = payload.read(element)?;
                contents.has_faces |= element.count > 0;
            }
            "tristrips" => {
                contents.strips = payload.read(element)?;
                contents.has_faces |= element.count > 0;
            }
            _ if contents.has_vertices && element.count == 0 => {}
            _ => drop(payload.read::<Nothing>(element)?),
        }
    }
    Ok(contents)
}

/// What follows the header.
struct Payload<'a, 'b> {
    reader: &'a mut Reader<&'b [u8]>,
    header: &'a Header,
    bytes: &'b [u8],
    lines: text::Lines<'b>,
}

impl Payload<'_, '_> {
    fn left_bytes(&self) -> usize {
        match self.header.encoding {
            Encoding::Ascii => self.lines.rest.len(),
            _ => self.reader.get_ref().len(),
        }
    }

    fn read<E: PropertyAccess>(&mut self, element: &ElementDef) -> Result<Vec<E>, LoadError> {
        if self.header.encoding == Encoding::Ascii {
            return text::read(&mut self.lines, element);
        }
        let start = self.bytes.len() - self.left_bytes();
        let read = Parser::new().read_payload_for_element(self.reader, element, self.header);
        read.map_err(|error: ParseError| faults::of_element(&error, element, start))
    }
}

/// Refuses a count that the rest of the file cannot hold, before memory is taken for it.
fn check_count(element: &ElementDef, header: &Header, left_bytes: usize) -> Result<(), LoadError> {
    let scalar_bytes = |scalar: &ScalarType| match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let least_bytes = |kind: &PropertyType| match (kind, header.encoding) {
        // A digit, and what parts it from the next.
        (_, Encoding::Ascii) => 2,
        (PropertyType::Scalar(scalar) | PropertyType::List(scalar, _), _) => scalar_bytes(scalar),
    };
    let bytes: usize = element.properties.values().map(|property| least_bytes(&property.data_type)).sum();
    let name = &element.name;
    if bytes == 0 && element.count > 0 {
        return Err(LoadError::malformed("", format!("the header gives the element \"{name}\" no properties")));
    }
    // The last line may end without a break.
    if element.count.saturating_mul(bytes) > left_bytes.saturating_add(1) {
        let message = format!(
            "the header counts {} of the element \"{name}\", which take at least {} bytes, and {left_bytes} are left; \
             is the file cut off?",
            element.count,
            element.count.saturating_mul(bytes)
        );
        return Err(LoadError::malformed("", message));
    }
    Ok(())
}

/// The triangles of faces and strips.
fn triangles(contents: &Contents, has_corners: bool, warnings: &mut Tally) -> Result<Triangles, LoadError> {
    let vertices = &contents.vertices;
    let mut triangles = Triangles::default();
    let mut polygon = Vec::new();
    let checked = |place: usize, index: i64| {
        let found = u32::try_from(index).ok().filter(|index| (*index as usize) < vertices.len());
        found.ok_or_else(|| {
            let message = format!("vertex {index} is named, and the file has {}", vertices.len());
            LoadError::malformed(&format!("face {place}"), message)
        })
    };
    let position = |index: &u32| vertices.get(*index as usize).filter(|vertex| is_placed(vertex));
    let no_place = "a face with a corner without a position (its coordinates are not numbers) is left out";
    for (place, face) in contents.faces.iter().enumerate() {
        polygon.clear();
        for &index in &face.indices {
            polygon.push(checked(place, index)?);
        }
        let points: Vec<Vec3> = polygon.iter().filter_map(position).map(|vertex| vertex.position.into()).collect();
        if points.len() < polygon.len() || points.len() < 3 {
            let fewer = "a face of fewer than three corners is left out";
            warnings.add(Place(place), if points.len() < polygon.len() { no_place } else { fewer });
            continue;
        }
        let cut = polygon::triangles(&points);
        if cut.is_guessed {
            warnings.add(Place(place), polygon::GUESSED);
        }
        for corner in cut.triangles.into_iter().flatten() {
            triangles.indices.extend(polygon.get(corner));
            if has_corners {
                triangles.corners.push((place as u32, corner as u32));
            }
        }
    }
    for (place, strip) in contents.strips.iter().enumerate() {
        // A number below 0 begins the strip anew.
        for piece in strip.indices.split(|index| *index < 0) {
            for (i, corners) in piece.windows(3).enumerate() {
                let &[a, b, c] = corners else { continue };
                let [a, b, c] = [checked(place, a)?, checked(place, b)?, checked(place, c)?];
                if ![a, b, c].iter().all(|index| position(index).is_some()) {
                    warnings.add(Place(place), no_place);
                    continue;
                }
                triangles.indices.extend(if i % 2 == 0 { [a, b, c] } else { [a, c, b] });
                if has_corners {
                    triangles.corners.extend([(u32::MAX, 0); 3]);
                }
            }
        }
    }
    Ok(triangles)
}

/// The place of a warning.
struct Place(usize);

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "face {}", self.0)
    }
}
