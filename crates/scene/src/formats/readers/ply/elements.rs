//! The elements of PLY that are read, and which of their properties.

use ply_rs_bw::ply::{ElementDef, Header, Property, PropertyAccess, PropertyAccessResult};

/// A vertex with whatever attributes it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    pub(super) position: [f32; 3],
    /// What rounding took from the position of a file of doubles, or of text.
    pub(super) position_rest: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) color_srgb: [f32; 4],
    pub(super) uv: [f32; 2],
}

/// A polygon, or a strip of triangles.
#[derive(Debug, Default)]
pub(super) struct Face {
    pub(super) indices: Vec<i64>,
    /// What few files have.
    pub(super) surface: Option<Box<Surface>>,
}

/// How a polygon looks by itself.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// Two numbers for each corner.
    pub(super) uvs: Vec<f32>,
    /// Which texture of the file it has.
    pub(super) texture: u32,
    pub(super) color_srgb: [f32; 4],
}

/// What is passed over.
pub(super) struct Nothing;

/// The properties that are read of vertices, of faces, and of strips.
const OF_VERTICES: [&str; 24] = [
    "x",
    "y",
    "z",
    "nx",
    "ny",
    "nz",
    "red",
    "r",
    "diffuse_red",
    "green",
    "g",
    "diffuse_green",
    "blue",
    "b",
    "diffuse_blue",
    "alpha",
    "a",
    "diffuse_alpha",
    "s",
    "u",
    "texture_u",
    "t",
    "v",
    "texture_v",
];
const OF_FACES: [&str; 8] =
    ["vertex_indices", "vertex_index", "texcoord", "texnumber", "red", "green", "blue", "alpha"];
const OF_STRIPS: [&str; 2] = ["vertex_indices", "vertex_index"];
/// So many properties are named.
const NAMED_MAX: usize = 12;

/// A coordinate as a float, and what rounding took from it.
fn coordinate(property: &Property) -> Option<(f32, f32)> {
    let exact = match property {
        Property::Double(number) => *number,
        Property::Int(number) => f64::from(*number),
        Property::UInt(number) => f64::from(*number),
        _ => return property.to_f32_lossy().map(|number| (number, 0.0)),
    };
    let number = exact as f32;
    Some((number, (exact - f64::from(number)) as f32))
}

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

impl Vertex {
    /// Its place with all digits that were read.
    pub(super) fn place(&self) -> [f64; 3] {
        std::array::from_fn(|axis| f64::from(self.position[axis]) + f64::from(self.position_rest[axis]))
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: [0.0; 3], position_rest: [0.0; 3], normal: [0.0; 3], color_srgb: [1.0; 4], uv: [0.0; 2] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) {
            let Some(found) = coordinate(&property) else { return PropertyAccessResult::Ignored };
            (self.position[axis], self.position_rest[axis]) = found;
            return PropertyAccessResult::Set;
        }
        let Some((number, share)) = value(&property) else { return PropertyAccessResult::Ignored };
        let ([nx, ny, nz], [r, g, b, a], [u, v]) = (&mut self.normal, &mut self.color_srgb, &mut self.uv);
        match name {
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

impl Face {
    fn surface(&mut self) -> &mut Surface {
        let nothing = || Box::new(Surface { uvs: Vec::new(), texture: 0, color_srgb: [1.0; 4] });
        self.surface.get_or_insert_with(nothing)
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let place = ["red", "green", "blue", "alpha"].iter().position(|channel| *channel == name);
        match (name, property) {
            ("vertex_indices" | "vertex_index", property) => {
                self.indices = match property {
                    Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
                    Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
                    Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
                    Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
                    Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
                    Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
                    _ => return PropertyAccessResult::UnsupportedType,
                };
            }
            ("texcoord", Property::ListFloat(list)) => self.surface().uvs = list,
            ("texcoord", Property::ListDouble(list)) => {
                self.surface().uvs = list.into_iter().map(|value| value as f32).collect();
            }
            ("texnumber", property) => {
                let Some((number, _)) = value(&property) else { return PropertyAccessResult::Ignored };
                self.surface().texture = number as u32;
            }
            (_, property) => {
                let (Some((_, share)), Some(place)) = (value(&property), place) else {
                    return PropertyAccessResult::Ignored;
                };
                if let Some(channel) = self.surface().color_srgb.get_mut(place) {
                    *channel = share;
                }
            }
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Nothing {
    fn new() -> Self {
        Self
    }
}

/// What is said of the elements and properties that are passed over.
pub(super) fn unread(header: &Header) -> Vec<String> {
    let mut warnings = Vec::new();
    for element in header.elements.values().filter(|element| element.count > 0) {
        let name = &element.name;
        let read = match name.as_str() {
            "vertex" => &OF_VERTICES[..],
            "face" => &OF_FACES,
            "tristrips" => &OF_STRIPS,
            _ => {
                warnings.push(format!("the element \"{name}\", of which there are {}, is not read", element.count));
                continue;
            }
        };
        if name == "vertex" && is_splat(element) {
            warnings.push("Gaussian splats are not drawn as such: their centres are drawn as points".into());
            continue;
        }
        let others: Vec<&str> = element
            .properties
            .values()
            .map(|found| found.name.as_str())
            .filter(|found| !read.contains(found))
            .collect();
        if !others.is_empty() {
            let more = if others.len() > NAMED_MAX { ", …" } else { "" };
            let named: Vec<&str> = others.iter().copied().take(NAMED_MAX).collect();
            let count = others.len();
            warnings
                .push(format!("{count} properties of the element \"{name}\" are not read: {}{more}", named.join(", ")));
        }
    }
    warnings
}

/// Whether vertices are Gaussians (Kerbl et al. 2023).
fn is_splat(vertex: &ElementDef) -> bool {
    ["f_dc_0", "scale_0", "rot_0"].iter().all(|name| vertex.properties.contains_key(*name))
}
