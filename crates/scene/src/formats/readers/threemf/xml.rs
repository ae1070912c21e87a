//! From XML to objects. Nothing here is followed yet: what a part names may not be there.

use super::attribute::attribute;
use super::package::{Package, part_name};
use crate::formats::readers::parts::from_middle;
use crate::formats::readers::text;
use crate::gltf_file::LoadError;
use crate::tally::Tally;
use crate::{Sampler, Wrap};
use glam::{DMat4, DVec4, Vec3};
use quick_xml::{
    Reader,
    events::{BytesStart, Event},
};
use std::collections::HashMap;

/// Elements that hold others, and what is said about a model, which has no look.
const READ: [&str; 9] =
    ["resources", "build", "mesh", "vertices", "triangles", "components", "metadata", "metadatagroup", "trianglesets"];

/// No index.
pub(super) const NONE: u32 = u32::MAX;
/// The most parts of an archive that hold objects.
const MOST_PARTS: usize = 4096;

/// An object of a part, by the part's name and its number there.
pub(super) type Key = (String, u32);

/// One part of the archive.
#[derive(Debug, Default)]
pub(super) struct Model {
    /// Metres in a unit.
    pub(super) unit_m: f64,
    pub(super) objects: HashMap<u32, Object>,
    pub(super) properties: HashMap<u32, Property>,
    /// What is shown.
    pub(super) items: Vec<Item>,
    pub(super) textures: HashMap<u32, TextureFile>,
    pub(super) warnings: Tally,
}

/// An image of the archive.
#[derive(Debug)]
pub(super) struct TextureFile {
    pub(super) path: String,
    pub(super) sampler: Sampler,
}

/// What triangles refer to.
#[derive(Debug)]
pub(super) enum Property {
    /// Materials: names and sRGB colours.
    Bases(Vec<(String, [f32; 4])>),
    /// sRGB colours of corners.
    Colors(Vec<[f32; 4]>),
    /// Coordinates of corners on a texture; v points up.
    Coordinates { texture: u32, uvs: Vec<[f32; 2]> },
}

#[derive(Debug, Default)]
pub(super) struct Object {
    pub(super) name: String,
    /// The property of triangles that name none, and the index in it.
    pub(super) property: (u32, u32),
    /// Positions as they are read.
    places: Vec<[f64; 3]>,
    /// Positions from `origin` on, once all are read.
    pub(super) positions: Vec<[f32; 3]>,
    /// The middle of a mesh that lies away from the object's origin, in the file's unit.
    pub(super) origin: Vec3,
    pub(super) triangles: Vec<Triangle>,
    pub(super) components: Vec<Item>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) vertices: [u32; 3],
    pub(super) property: u32,
    pub(super) indices: [u32; 3],
}

/// An object in its place.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub(super) object: Key,
    pub(super) parent_from_object: DMat4,
}

/// Every part that is needed, by its name.
pub(super) fn read_all(package: &mut Package, root: &str) -> Result<HashMap<String, Model>, LoadError> {
    let mut models = HashMap::new();
    let mut pending = vec![root.to_owned()];
    while let Some(name) = pending.pop() {
        if models.contains_key(&name) {
            continue;
        }
        if models.len() == MOST_PARTS {
            return Err(LoadError::malformed("", format!("more than {MOST_PARTS} parts of the archive hold objects")));
        }
        let model = read(&package.read(&name)?, &name)?;
        let components = model.objects.values().flat_map(|object| &object.components);
        let named = model.items.iter().chain(components).map(|item| &item.object.0);
        pending.extend(named.filter(|part| **part != name).cloned());
        models.insert(name, model);
    }
    Ok(models)
}

/// Where the reader is, for attributes that are wrong.
struct Place<'a> {
    part: &'a str,
    byte: u64,
}

impl Place<'_> {
    fn wrong(&self, message: impl std::fmt::Display) -> LoadError {
        LoadError::malformed(&format!("part \"{}\", byte {}", self.part, self.byte), message.to_string())
    }

    fn text(&self, element: &BytesStart, name: &str) -> Result<String, LoadError> {
        let tag = element.local_name().as_ref().to_owned();
        attribute(element, name).ok_or_else(|| self.wrong(format!("<{tag}> has no \"{name}\"")))
    }

    fn number(&self, element: &BytesStart, name: &str) -> Result<f64, LoadError> {
        let value = self.text(element, name)?;
        let number = text::exact_number(value.trim().as_bytes());
        number.ok_or_else(|| {
            self.wrong(format!("\"{name}\": expected a finite number, found \"{}\"", text::shown(value.as_bytes())))
        })
    }

    /// An index, or none.
    fn index(&self, element: &BytesStart, name: &str) -> Result<Option<u32>, LoadError> {
        let Some(value) = attribute(element, name) else { return Ok(None) };
        let index = value.trim().parse().ok().filter(|index| *index != NONE);
        index.map(Some).ok_or_else(|| {
            self.wrong(format!("\"{name}\": expected a number from 0, found \"{}\"", text::shown(value.as_bytes())))
        })
    }

    fn needed(&self, element: &BytesStart, name: &str) -> Result<u32, LoadError> {
        self.index(element, name)?.ok_or_else(|| self.wrong(format!("\"{name}\" is missing")))
    }

    fn color(&self, element: &BytesStart, name: &str) -> Result<[f32; 4], LoadError> {
        let value = self.text(element, name)?;
        let digits = value.trim().strip_prefix('#').filter(|digits| [6, 8].contains(&digits.len()));
        let number = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
        let number = number.ok_or_else(|| {
            self.wrong(format!("expected a colour such as #RRGGBB, found \"{}\"", text::shown(value.as_bytes())))
        })?;
        let rgba = if value.trim().len() == 7 { number << 8 | 0xff } else { number };
        Ok(rgba.to_be_bytes().map(|byte| f32::from(byte) / 255.0))
    }

    /// Four rows of three numbers; a row is what a column is to us.
    fn transform(&self, element: &BytesStart) -> Result<DMat4, LoadError> {
        let Some(value) = attribute(element, "transform") else { return Ok(DMat4::IDENTITY) };
        let numbers: Option<Vec<f64>> = text::words(value.as_bytes()).map(text::exact_number).collect();
        match numbers.as_deref() {
            Some(&[a, b, c, d, e, f, g, h, i, x, y, z]) => Ok(DMat4::from_cols(
                DVec4::new(a, b, c, 0.0),
                DVec4::new(d, e, f, 0.0),
                DVec4::new(g, h, i, 0.0),
                DVec4::new(x, y, z, 1.0),
            )),
            _ => Err(self.wrong("\"transform\": expected twelve finite numbers")),
        }
    }

    fn item(&self, element: &BytesStart) -> Result<Item, LoadError> {
        let part = attribute(element, "path").map_or_else(|| self.part.to_owned(), |path| part_name(&path));
        let object = (part, self.needed(element, "objectid")?);
        Ok(Item { object, parent_from_object: self.transform(element)? })
    }
}

fn read(content: &str, part: &str) -> Result<Model, LoadError> {
    let mut reader = Reader::from_str(content);
    let mut model = Model { unit_m: 1e-3, ..Model::default() };
    // The object and the property that are being read.
    let (mut object, mut property) = (NONE, NONE);
    let mut is_model = false;
    loop {
        let place = Place { part, byte: reader.buffer_position() };
        match reader.read_event() {
            Ok(Event::Start(element) | Event::Empty(element)) => {
                is_model |= element.local_name().as_ref() == "model";
                read_element(&element, &place, &mut model, &mut object, &mut property)?;
            }
            Ok(Event::Eof) if is_model => {
                for object in model.objects.values_mut() {
                    (object.origin, object.positions) = from_middle(std::mem::take(&mut object.places));
                }
                return Ok(model);
            }
            Ok(Event::Eof) => return Err(place.wrong("expected a <model>, found none")),
            Ok(_) => {}
            Err(error) => return Err(place.wrong(text::shown(error.to_string().as_bytes()))),
        }
    }
}

fn read_element(
    element: &BytesStart,
    place: &Place,
    model: &mut Model,
    object: &mut u32,
    property: &mut u32,
) -> Result<(), LoadError> {
    let tag = element.local_name();
    match tag.as_ref() {
        "model" => {
            model.unit_m = unit_m(attribute(element, "unit").as_deref())
                .ok_or_else(|| place.wrong("\"unit\": expected micron, millimeter, centimeter, inch, foot or meter"))?;
        }
        "object" => {
            *object = place.needed(element, "id")?;
            let of_triangles =
                (place.index(element, "pid")?.unwrap_or(NONE), place.index(element, "pindex")?.unwrap_or(0));
            let name = attribute(element, "name").unwrap_or_default();
            model.objects.insert(*object, Object { name, property: of_triangles, ..Object::default() });
        }
        "basematerials" => {
            *property = place.needed(element, "id")?;
            model.properties.insert(*property, Property::Bases(Vec::new()));
        }
        "colorgroup" => {
            *property = place.needed(element, "id")?;
            model.properties.insert(*property, Property::Colors(Vec::new()));
        }
        "texture2d" => {
            let id = place.needed(element, "id")?;
            let path = part_name(&place.text(element, "path")?);
            let [wrap_u, wrap_v] = ["tilestyleu", "tilestylev"].map(|name| wrap(attribute(element, name).as_deref()));
            let is_linear = attribute(element, "filter").is_none_or(|filter| filter != "nearest");
            let sampler = Sampler { wrap_u, wrap_v, mag_linear: is_linear, ..Sampler::default() };
            model.textures.insert(id, TextureFile { path, sampler });
        }
        "texture2dgroup" => {
            *property = place.needed(element, "id")?;
            let texture = place.needed(element, "texid")?;
            model.properties.insert(*property, Property::Coordinates { texture, uvs: Vec::new() });
        }
        "tex2coord" => {
            let uv = [place.number(element, "u")? as f32, place.number(element, "v")? as f32];
            if let Some(Property::Coordinates { uvs, .. }) = model.properties.get_mut(property) {
                uvs.push(uv);
            }
        }
        "base" => {
            let base = (attribute(element, "name").unwrap_or_default(), place.color(element, "displaycolor")?);
            if let Some(Property::Bases(bases)) = model.properties.get_mut(property) {
                bases.push(base);
            }
        }
        "color" => {
            let color = place.color(element, "color")?;
            if let Some(Property::Colors(colors)) = model.properties.get_mut(property) {
                colors.push(color);
            }
        }
        "vertex" | "triangle" | "component" => read_geometry(element, place, model.objects.get_mut(object))?,
        "item" => model.items.push(place.item(element)?),
        _ if READ.contains(&tag.as_ref()) => {}
        _ => {
            let message = format!("<{}> is not read", text::shown(tag.as_ref().as_bytes()));
            model.warnings.add(format!("part \"{}\", byte {}", place.part, place.byte), &message);
        }
    }
    Ok(())
}

fn read_geometry(element: &BytesStart, place: &Place, object: Option<&mut Object>) -> Result<(), LoadError> {
    let Some(object) = object else { return Err(place.wrong("it belongs to no <object>")) };
    match element.local_name().as_ref() {
        "vertex" => {
            let position = ["x", "y", "z"].map(|name| place.number(element, name));
            let [x, y, z] = position;
            object.places.push([x?, y?, z?]);
        }
        "triangle" => {
            let [a, b, c] = ["v1", "v2", "v3"].map(|name| place.needed(element, name));
            let vertices = [a?, b?, c?];
            // Vertices come before triangles.
            if let Some(index) = vertices.iter().find(|index| **index as usize >= object.places.len()) {
                let count = object.places.len();
                return Err(place.wrong(format!("vertex {index} is named, and the mesh has {count}")));
            }
            let (default_property, default_index) = object.property;
            let property = place.index(element, "pid")?.unwrap_or(default_property);
            let first = place.index(element, "p1")?.unwrap_or(default_index);
            let second = place.index(element, "p2")?.unwrap_or(first);
            let third = place.index(element, "p3")?.unwrap_or(first);
            object.triangles.push(Triangle { vertices, property, indices: [first, second, third] });
        }
        _ => object.components.push(place.item(element)?),
    }
    Ok(())
}

/// How a texture goes on beyond its edges. None, where it is not there at all, is taken as its edge.
fn wrap(style: Option<&str>) -> Wrap {
    match style {
        Some("mirror") => Wrap::MirroredRepeat,
        Some("clamp" | "none") => Wrap::ClampToEdge,
        _ => Wrap::Repeat,
    }
}

fn unit_m(name: Option<&str>) -> Option<f64> {
    match name.unwrap_or("millimeter") {
        "micron" => Some(1e-6),
        "millimeter" => Some(1e-3),
        "centimeter" => Some(1e-2),
        "inch" => Some(0.0254),
        "foot" => Some(0.3048),
        "meter" => Some(1.0),
        _ => None,
    }
}
