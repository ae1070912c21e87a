//! PLY (Turk 1994): meshes and clouds of points, as scanners write them; text, or bytes in either order. It has no
//! units, and is taken as it is: Y points up.

mod faults;

use super::parts::{Parts, linear, plain_material};
use super::polygon;
use super::smooth::{Smoothing, smooth, weld};
use crate::gltf_file::{LoadError, Loaded};
use crate::{Primitive, Topology};
use glam::Vec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};
use std::collections::HashMap;

/// A vertex with whatever attributes it has.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    color_srgb: [f32; 4],
    uv: [f32; 2],
}

/// A polygon, or a strip of triangles.
#[derive(Debug, Default)]
struct Face {
    indices: Vec<i64>,
}

/// What is passed over.
struct Nothing;

/// What a property is as a number; colours of bytes are shares of 255, and those of two bytes of 65535.
fn value(property: &Property) -> Option<(f32, f32)> {
    let number = property.to_f32_lossy()?;
    let share = match property {
        Property::UChar(_) => number / 255.0,
        Property::UShort(_) => number / 65535.0,
        _ => number,
    };
    Some((number, share))
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: [0.0; 3], normal: [0.0; 3], color_srgb: [1.0; 4], uv: [0.0; 2] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some((number, share)) = value(&property) else { return PropertyAccessResult::Ignored };
        let ([x, y, z], [nx, ny, nz], [r, g, b, a], [u, v]) =
            (&mut self.position, &mut self.normal, &mut self.color_srgb, &mut self.uv);
        match name {
            "x" => *x = number,
            "y" => *y = number,
            "z" => *z = number,
            "nx" => *nx = number,
            "ny" => *ny = number,
            "nz" => *nz = number,
            "red" | "r" | "diffuse_red" => *r = share,
            "green" | "g" | "diffuse_green" => *g = share,
            "blue" | "b" | "diffuse_blue" => *b = share,
            "alpha" | "a" | "diffuse_alpha" => *a = share,
            "s" | "u" | "texture_u" => *u = number,
            "t" | "v" | "texture_v" => *v = number,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !["vertex_indices", "vertex_index"].contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.indices = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Nothing {
    fn new() -> Self {
        Self
    }
}

/// What the elements of a file hold.
#[derive(Default)]
struct Contents {
    vertices: Vec<Vertex>,
    faces: Vec<Face>,
    strips: Vec<Face>,
    has_vertices: bool,
    has_faces: bool,
}

pub(super) fn load(bytes: &[u8]) -> Result<Loaded, LoadError> {
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
    let has_colors = has(&["red", "r", "diffuse_red"]);
    let (has_normals, has_uvs) = (has(&["nx"]), has(&["s", "u", "texture_u"]));
    let contents = read(&mut reader, &header, bytes)?;

    let mut parts = Parts::default();
    let material = parts.material(plain_material(has_colors));
    let mut primitive = Primitive { material: Some(material), ..Primitive::default() };
    let vertices = &contents.vertices;
    if contents.has_faces {
        primitive.indices = triangles(&contents)?;
    } else {
        primitive.topology = Topology::Points;
    }
    let source: Vec<u32> = if has_normals || primitive.topology == Topology::Points {
        if has_normals {
            primitive.normals = vertices.iter().map(|vertex| unit(vertex.normal)).collect();
        }
        (0..vertices.len() as u32).collect()
    } else {
        let (positions, places) = weld(vertices.iter().map(|vertex| vertex.position));
        let indices: Vec<u32> =
            primitive.indices.iter().filter_map(|&index| places.get(index as usize).copied()).collect();
        let smoothed = smooth(&positions, &indices, |_| Smoothing::ByAngle);
        split(&mut primitive, smoothed.indices, &smoothed.normals)
    };
    let of_source = || source.iter().filter_map(|&index| vertices.get(index as usize));
    primitive.positions = of_source().map(|vertex| vertex.position).collect();
    if has_colors {
        primitive.colors = of_source().map(|vertex| linear(vertex.color_srgb)).collect();
    }
    if has_uvs {
        primitive.uv0 = of_source().map(|vertex| [vertex.uv[0], 1.0 - vertex.uv[1]]).collect();
    }
    if !primitive.positions.is_empty() {
        parts.add("", vec![primitive]);
    }
    parts.finish()
}

fn unit(normal: [f32; 3]) -> [f32; 3] {
    Vec3::from(normal).try_normalize().unwrap_or(Vec3::Y).to_array()
}

/// Makes a vertex for every pair of a vertex and a normal; gives the former vertex of each.
fn split(primitive: &mut Primitive, normal_of_corner: Vec<u32>, normals: &[[f32; 3]]) -> Vec<u32> {
    let (mut source, mut known) = (Vec::new(), HashMap::new());
    for (index, normal) in primitive.indices.iter_mut().zip(normal_of_corner) {
        *index = *known.entry((*index, normal)).or_insert_with(|| {
            source.push(*index);
            primitive.normals.push(normals.get(normal as usize).copied().unwrap_or([0.0, 1.0, 0.0]));
            source.len() as u32 - 1
        });
    }
    source
}

/// Reads the elements in their order.
fn read(reader: &mut Reader<&[u8]>, header: &Header, bytes: &[u8]) -> Result<Contents, LoadError> {
    let mut contents = Contents::default();
    for element in header.elements.values() {
        let left_bytes = reader.get_ref().len();
        check_count(element, header, left_bytes)?;
        let fault =
            |error: ParseError| faults::of_element(&error, element, header.encoding, bytes, bytes.len() - left_bytes);
        match element.name.as_str() {
            "vertex" => {
                contents.vertices = Parser::new().read_payload_for_element(reader, element, header).map_err(fault)?;
                contents.has_vertices = true;
            }
            "face" => {
                contents.faces = Parser::new().read_payload_for_element(reader, element, header).map_err(fault)?;
                contents.has_faces |= element.count > 0;
            }
            "tristrips" => {
                contents.strips = Parser::new().read_payload_for_element(reader, element, header).map_err(fault)?;
                contents.has_faces |= element.count > 0;
            }
            _ if contents.has_vertices && element.count == 0 => {}
            _ => {
                let parser = Parser::<Nothing>::new();
                parser.read_payload_for_element(reader, element, header).map_err(fault)?;
            }
        }
    }
    let is_placed = |vertex: &Vertex| vertex.position.iter().chain(&vertex.uv).all(|value| value.is_finite());
    if let Some(place) = contents.vertices.iter().position(|vertex| !is_placed(vertex)) {
        let position = contents.vertices.get(place).map(|vertex| vertex.position).unwrap_or_default();
        return Err(LoadError::malformed(
            &format!("vertex {place}"),
            format!("it is at {position:?}, which is no place"),
        ));
    }
    Ok(contents)
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

/// The list of triangles of faces and strips.
fn triangles(contents: &Contents) -> Result<Vec<u32>, LoadError> {
    let vertices = &contents.vertices;
    let mut indices = Vec::new();
    let mut polygon = Vec::new();
    let checked = |place: usize, index: i64| {
        let found = u32::try_from(index).ok().filter(|index| (*index as usize) < vertices.len());
        found.ok_or_else(|| {
            let message = format!("vertex {index} is named, and the file has {}", vertices.len());
            LoadError::malformed(&format!("face {place}"), message)
        })
    };
    for (place, face) in contents.faces.iter().enumerate() {
        polygon.clear();
        for &index in &face.indices {
            polygon.push(checked(place, index)?);
        }
        let position = |index: &u32| vertices.get(*index as usize).map(|vertex| Vec3::from(vertex.position));
        let points: Vec<Vec3> = polygon.iter().filter_map(position).collect();
        let corners = polygon::triangles(&points).into_iter().flatten();
        indices.extend(corners.filter_map(|corner| polygon.get(corner)));
    }
    for (place, strip) in contents.strips.iter().enumerate() {
        // A number below 0 begins the strip anew.
        for piece in strip.indices.split(|index| *index < 0) {
            for (i, corners) in piece.windows(3).enumerate() {
                let &[a, b, c] = corners else { continue };
                let [a, b, c] = [checked(place, a)?, checked(place, b)?, checked(place, c)?];
                indices.extend(if i % 2 == 0 { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    Ok(indices)
}
