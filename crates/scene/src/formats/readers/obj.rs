//! Wavefront OBJ: polygons, lines and points, with materials of an MTL beside it. It has no units; Y points up.
//!
//! An object (`o`) is a node, or a group (`g`) where the file has no objects. Vertices may have colours after their
//! positions, as scanners write them.

mod file;
mod surface;

use super::image_files::ImageFiles;
use super::mtl;
use super::parts::{Parts, from_middle, linear, plain_material};
use super::smooth::Smoothing;
use super::text::{self, Line, at_line};
use crate::gltf_file::{LoadError, LoadedScene};
use crate::tally::Tally;
use crate::{Aabb, Primitive, Topology};
use file::{Corner, Element, File, NONE, SurfacePart, check, elements, push_vertex};
use glam::Vec3;
use std::collections::{BTreeSet, HashMap};

/// The most libraries of materials that a file names, and the bytes that they take together.
const MOST_LIBRARIES: usize = 256;
const MOST_LIBRARY_BYTES: usize = 64 << 20;

/// What stands for the colour of a vertex that has none.
const NO_COLOR: [f32; 4] = [-1.0; 4];
/// Statements that are known and not read: curves, surfaces, and what older programs drew with.
const UNREAD: [&[u8]; 27] = [
    b"vp",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"mg",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"maplib",
    b"usemap",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"call",
];

type Resolve<'r> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'r;

/// The files that an OBJ names: its libraries, then the textures in those that can be read. Absolute paths are there as
/// they are written, too.
pub(super) fn names(bytes: &[u8], resolve: &mut Resolve) -> Vec<String> {
    let mut libraries = Vec::new();
    for (_, line) in text::lines(bytes) {
        let (keyword, rest) = text::first_word(&line);
        if keyword == b"mtllib" {
            add_library(&mut libraries, rest);
        }
    }
    let definitions = read_libraries(&libraries, resolve, &mut Tally::default());
    let textures: BTreeSet<&str> =
        definitions.iter().flat_map(mtl::Definition::maps).flat_map(|map| map.name.all()).collect();
    libraries.iter().flat_map(mtl::NamedFile::all).chain(textures).map(str::to_owned).collect()
}

/// Adds a library that is not known yet.
fn add_library(libraries: &mut Vec<mtl::NamedFile>, rest: &[u8]) {
    let library = mtl::NamedFile::new("", &text::name(rest));
    if !library.path.is_empty() && libraries.len() < MOST_LIBRARIES && !libraries.contains(&library) {
        libraries.push(library);
    }
}

/// The materials of all libraries.
fn read_libraries(libraries: &[mtl::NamedFile], resolve: &mut Resolve, warnings: &mut Tally) -> Vec<mtl::Definition> {
    let (mut definitions, mut left_bytes) = (Vec::new(), MOST_LIBRARY_BYTES);
    for library in libraries {
        library.warn("", warnings);
        let path = &library.path;
        let read = resolve(path).and_then(|bytes| {
            left_bytes = left_bytes.checked_sub(bytes.len()).ok_or("libraries take more than 64 MiB together")?;
            Ok(bytes)
        });
        match read {
            Ok(bytes) => definitions.extend(mtl::parse(&bytes, path, warnings)),
            Err(message) => warnings.add("", &format!("materials of \"{path}\": {message}; they are left out")),
        }
    }
    definitions
}

pub(super) fn load(bytes: &[u8], resolve: &mut Resolve) -> Result<LoadedScene, LoadError> {
    let mut file = read(bytes)?;
    if file.positions.is_empty() {
        return Err(LoadError::malformed("", "not an OBJ file: it has no vertices"));
    }
    let mut parts = Parts { warnings: std::mem::take(&mut file.warnings), ..Parts::default() };
    let materials = materials(&file, &mut parts, resolve);
    for part in &file.parts {
        let mut primitives = surface::primitives(&file, part, &materials, &mut parts)?;
        primitives.extend(others(&file, part, &materials)?);
        if !primitives.is_empty() {
            let node = parts.add(&part.name, primitives);
            parts.scene.node_mut(node).translation = file.origin;
        }
    }
    parts.finish()
}

/// The scene's materials by their indices in the file.
fn materials(file: &File, parts: &mut Parts, resolve: &mut Resolve) -> Vec<usize> {
    let definitions = read_libraries(&file.libraries, resolve, &mut parts.warnings);
    let has_colors = !file.colors.is_empty();
    let bounds = Aabb::from_points(file.positions.iter().copied().map(Vec3::from));
    let size_m = (bounds.max - bounds.min).length();
    let by_name: HashMap<&str, &mtl::Definition> =
        definitions.iter().map(|definition| (definition.name.as_str(), definition)).collect();
    let mut images = ImageFiles::default();
    let used: BTreeSet<usize> =
        file.parts.iter().flat_map(|part| &part.elements).map(|element| element.material).collect();
    let of_name = |(index, name): (usize, &String)| {
        if !used.contains(&index) {
            return 0;
        }
        let material = match by_name.get(name.as_str()) {
            Some(definition) => definition.material(has_colors, size_m, parts, &mut images, resolve),
            None => {
                if index > 0 && !definitions.is_empty() {
                    parts.warn(format!("no library has the material \"{name}\"; it is drawn grey"));
                }
                crate::Material { name: name.clone(), ..plain_material(has_colors) }
            }
        };
        parts.scene.materials.push(material);
        parts.scene.materials.len() - 1
    };
    file.materials.iter().enumerate().map(of_name).collect()
}

fn read(bytes: &[u8]) -> Result<File, LoadError> {
    let mut file = File { materials: vec![String::new()], ..File::default() };
    let (mut material, mut smoothing, mut has_objects) = (0, Smoothing::ByAngle, false);
    let mut part = file.part("");
    for (line, content) in text::lines(bytes) {
        let (keyword, rest) = text::first_word(&content);
        let mut words = text::words_before_comment(rest);
        match keyword {
            b"v" => file.add_vertex(&mut words, line)?,
            b"vt" => {
                let [u] = text::vector(&mut words, line)?;
                let v = words.next().map_or(Some(0.0), text::number);
                let v = v.ok_or_else(|| at_line(line, "expected two finite numbers"))?;
                // It points up here, and down in textures.
                file.uvs.push([u, 1.0 - v]);
            }
            b"vn" => file.add_normal(&mut words, line)?,
            b"f" => file.add_element(part, Topology::Triangles, smoothing, material, (rest, line))?,
            b"l" => file.add_element(part, Topology::Lines, smoothing, material, (rest, line))?,
            b"p" => file.add_element(part, Topology::Points, smoothing, material, (rest, line))?,
            b"o" => {
                has_objects = true;
                part = file.part(&text::name(rest));
            }
            b"g" if !has_objects => part = file.part(&text::name(rest)),
            b"s" => {
                smoothing = match words.next() {
                    None | Some(b"off" | b"0") => Smoothing::Flat,
                    Some(word) => text::number(word).map_or(Smoothing::ByAngle, |n| Smoothing::Group(n as u32)),
                };
            }
            b"usemtl" => material = file.material(&text::name(rest)),
            b"mtllib" => add_library(&mut file.libraries, rest),
            b"" | b"g" => {}
            _ if keyword.starts_with(b"#") => {}
            _ => file.pass_over(keyword, line),
        }
    }
    file.settle_colors();
    (file.origin, file.positions) = from_middle(std::mem::take(&mut file.places));
    Ok(file)
}

impl File {
    fn part(&mut self, name: &str) -> usize {
        if let Some(&part) = self.part_of.get(name) {
            return part;
        }
        self.parts.push(SurfacePart { name: name.to_owned(), ..SurfacePart::default() });
        self.part_of.insert(name.to_owned(), self.parts.len() - 1);
        self.parts.len() - 1
    }

    fn material(&mut self, name: &str) -> usize {
        if let Some(&material) = self.material_of.get(name) {
            return material;
        }
        self.materials.push(name.to_owned());
        self.material_of.insert(name.to_owned(), self.materials.len() - 1);
        self.materials.len() - 1
    }

    fn add_vertex<'w>(&mut self, words: &mut impl Iterator<Item = &'w [u8]>, line: u32) -> Result<(), LoadError> {
        self.places.push(text::place(words, line)?);
        // One number more is the weight of curves, which are not read; three are a colour.
        let rest: Vec<f32> = words.take(4).map_while(text::number).collect();
        if let [r, g, b, ..] = rest[..] {
            self.colors.resize(self.places.len() - 1, NO_COLOR);
            self.colors.push([r, g, b, 1.0]);
        } else if !self.colors.is_empty() {
            self.colors.push(NO_COLOR);
        }
        Ok(())
    }

    /// Takes colours to light. Some scanners write them from 0 to 255, and not from 0 to 1.
    fn settle_colors(&mut self) {
        let is_of_bytes = self.colors.iter().flatten().any(|value| *value > 1.0);
        if is_of_bytes {
            self.warnings.add("", "colours of vertices above 1: all are taken to be from 0 to 255");
        }
        let most = if is_of_bytes { 255.0 } else { 1.0 };
        for color in &mut self.colors {
            let [r, g, b, _] = color.map(|value| value / most);
            *color = if *color == NO_COLOR { [1.0; 4] } else { linear([r, g, b, 1.0]) };
        }
    }

    /// A normal without direction stays zero: it is made from faces, as where there is none.
    fn add_normal<'w>(&mut self, words: &mut impl Iterator<Item = &'w [u8]>, line: u32) -> Result<(), LoadError> {
        let normal = Vec3::from(text::vector(words, line)?).normalize_or_zero();
        if normal == Vec3::ZERO {
            self.warnings.add(Line(line), "a normal has no direction; it is made from the faces instead");
        }
        self.normals.push(normal.to_array());
        Ok(())
    }

    /// Counts a statement that is not read.
    fn pass_over(&mut self, keyword: &[u8], line: u32) {
        let message = match UNREAD.contains(&keyword) {
            true => format!("\"{}\" is not read", text::name(keyword)),
            false => format!("\"{}\" is not a statement of OBJ; it is passed over", text::shown(keyword)),
        };
        self.warnings.add_as(if UNREAD.contains(&keyword) { &message } else { "no statement" }, Line(line), &message);
    }

    fn add_element(
        &mut self,
        part: usize,
        topology: Topology,
        smoothing: Smoothing,
        material: usize,
        (rest, line): (&[u8], u32),
    ) -> Result<(), LoadError> {
        let counts = [self.places.len(), self.uvs.len(), self.normals.len()];
        let Some(part) = self.parts.get_mut(part) else { return Ok(()) };
        let start = part.corners.len();
        for word in text::words_before_comment(rest) {
            part.corners.push(corner(word, counts, line)?);
        }
        let (least, what) = match topology {
            Topology::Triangles => (3, "a face of fewer than three corners is left out"),
            Topology::Lines => (2, "a line of fewer than two vertices is left out"),
            Topology::Points => (1, "points without a vertex are left out"),
        };
        if part.corners.len() - start < least {
            part.corners.truncate(start);
            self.warnings.add(Line(line), what);
            return Ok(());
        }
        let end = part.corners.len() as u32;
        part.elements.push(Element { end, line, topology, smoothing, material });
        Ok(())
    }
}

/// Reads `position/uv/normal`, each counted from 1, or backwards from the latest one. Whether they are there is known
/// at the end.
fn corner(word: &[u8], counts: [usize; 3], line: u32) -> Result<Corner, LoadError> {
    let wrong =
        || at_line(line, format!("\"{}\" is not a vertex; expected v, v/vt, v//vn or v/vt/vn", text::shown(word)));
    let mut corner = [NONE; 3];
    let mut given = word.split(|byte| *byte == b'/');
    for (slot, count) in corner.iter_mut().zip(counts) {
        let Some(index) = given.next().filter(|index| !index.is_empty()) else { continue };
        let index: i64 = std::str::from_utf8(index).ok().and_then(|index| index.parse().ok()).ok_or_else(wrong)?;
        let index = if index < 0 { count as i64 + index } else { index - 1 };
        *slot = u32::try_from(index).map_err(|_| wrong())?;
    }
    if corner[0] == NONE || given.next().is_some() { Err(wrong()) } else { Ok(corner) }
}

/// The primitives of a part's lines and points.
fn others(file: &File, part: &SurfacePart, materials: &[usize]) -> Result<Vec<Primitive>, LoadError> {
    let mut primitives: Vec<Primitive> = Vec::new();
    let mut places: HashMap<(Topology, usize), usize> = HashMap::new();
    for (element, corners) in elements(part).filter(|(element, _)| element.topology != Topology::Triangles) {
        check(file, corners, element.line)?;
        let place = *places.entry((element.topology, element.material)).or_insert_with(|| {
            let material = materials.get(element.material).copied();
            primitives.push(Primitive { topology: element.topology, material, ..Primitive::default() });
            primitives.len() - 1
        });
        let Some(primitive) = primitives.get_mut(place) else { continue };
        let first = primitive.positions.len() as u32;
        corners.iter().for_each(|corner| push_vertex(file, primitive, *corner, false));
        let last = primitive.positions.len() as u32;
        match element.topology {
            Topology::Lines => primitive.indices.extend((first + 1..last).flat_map(|i| [i - 1, i])),
            _ => primitive.indices.extend(first..last),
        }
    }
    Ok(primitives)
}
