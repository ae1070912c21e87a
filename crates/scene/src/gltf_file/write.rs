//! glTF files that are changed and written.

mod of_scene;
pub(super) mod prune;

use super::container::{self, GLB_MAGIC, Resolve, fetch};
use super::error::LoadError;
use super::extensions::check_version;
use super::files::{checked_relative_path, read_file};
use super::json::Json;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::hash::Hasher;
use std::io::Read as _;

/// The most bytes of a GLB: lengths have 32 bits.
const GLB_BYTES_MAX: usize = u32::MAX as usize;

/// A glTF file in one piece: its JSON, and the bytes of its first buffer, in which all others and all images lie.
///
/// ```no_run
/// # use manypass_scene::gltf_file::Parts;
/// # use std::path::Path;
/// let mut parts = Parts::read_path(Path::new("chair.gltf"))?;
/// parts.json["asset"]["copyright"] = "2026 Somebody".into();
/// std::fs::write("chair.glb", parts.to_glb().unwrap()).unwrap();
/// # Ok::<(), manypass_scene::LoadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Parts {
    /// What the file says.
    pub json: Value,
    binary: Vec<u8>,
}

/// What the numbers of an accessor are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Numbers<'a> {
    /// Three floats an element.
    Vec3(&'a [[f32; 3]]),
    /// Two floats an element.
    Vec2(&'a [[f32; 2]]),
    /// Four floats an element.
    Vec4(&'a [[f32; 4]]),
    /// A number an element, of 16 bits where all fit.
    Indices(&'a [u32]),
}

impl Parts {
    /// A file without anything.
    pub fn empty() -> Self {
        let json =
            json!({ "asset": { "version": "2.0", "generator": concat!("manypass ", env!("CARGO_PKG_VERSION")) } });
        Self { json, binary: Vec::new() }
    }

    /// Reads the file at `path`, and the files beside it that it names.
    ///
    /// # Errors
    /// As [`super::load_path`] has them.
    pub fn read_path(path: &std::path::Path) -> Result<Self, LoadError> {
        let name = path.display().to_string();
        let bytes = read_file(path).map_err(|message| LoadError::Io { file: name.clone(), message })?;
        let folder = path.parent().unwrap_or(std::path::Path::new("")).to_owned();
        let mut beside = |uri: &str| read_file(&folder.join(checked_relative_path(uri)?));
        Self::read(&bytes, &mut beside).map_err(|error| error.in_file(&name))
    }

    /// Reads a `.glb` or `.gltf` file from memory; see [`super::load_bytes`].
    ///
    /// # Errors
    /// It is no glTF file, or one that it names cannot be fetched.
    pub fn read(bytes: &[u8], resolve: &mut Resolve) -> Result<Self, LoadError> {
        let (text, binary) = container::split(bytes)?;
        let value: Value = serde_json::from_slice(text)
            .map_err(|error| LoadError::invalid("", format!("not a glTF file: its JSON does not parse: {error}")))?;
        let root = Json::root(&value)?;
        check_version(&root)?;
        let mut faults = super::faults::Faults::default();
        let buffers = container::read_buffers(&root, binary, bytes.starts_with(GLB_MAGIC), resolve, &mut faults)?;
        // What is written anew is whole.
        faults.into_result()?;
        let mut parts = Self { json: Value::Null, binary: Vec::new() };
        // Where the bytes of a buffer lie now; those without any stay buffers of their own.
        let mut places: BTreeMap<u64, (u64, u64)> = BTreeMap::new();
        let mut left = vec![json!({ "byteLength": 0 })];
        for (index, buffer) in buffers.iter().enumerate() {
            let place = match buffer {
                Some(bytes) => (0, parts.append_bytes(bytes) as u64),
                None => {
                    left.push(value["buffers"][index].clone());
                    (left.len() as u64 - 1, 0)
                }
            };
            places.insert(index as u64, place);
        }
        drop(buffers);
        parts.json = value;
        let views = parts.json.get_mut("bufferViews").and_then(Value::as_array_mut);
        for view in views.into_iter().flatten() {
            move_view(view, &places);
            let extensions = view.get_mut("extensions").and_then(Value::as_object_mut);
            extensions.into_iter().flat_map(Map::values_mut).for_each(|extension| move_view(extension, &places));
        }
        parts.json["buffers"] = left.into();
        parts.embed_images(resolve);
        Ok(parts)
    }

    /// The JSON of the GLB at `path`, if it is one, and as long as it says.
    pub fn json_of(path: &std::path::Path) -> Option<Value> {
        let mut file = crate::input_file::open(path).ok()?;
        let mut head = [0; 20];
        file.read_exact(&mut head).ok()?;
        let number = |at: usize| head[at..at + 4].try_into().ok().map(u32::from_le_bytes);
        let (whole, length) = (number(8)?, number(12)?);
        let is_whole = file.metadata().ok()?.len() == u64::from(whole);
        let is_glb = is_whole && head.starts_with(GLB_MAGIC) && &head[16..] == b"JSON";
        let mut text = Vec::new();
        file.take(u64::from(length)).read_to_end(&mut text).ok().filter(|_| is_glb)?;
        serde_json::from_slice(&text).ok()
    }

    /// Hashes all that it holds.
    pub fn hash_into(&self, hasher: &mut impl Hasher) {
        hasher.write(self.json.to_string().as_bytes());
        hasher.write(&self.binary);
    }

    /// Images that are files come in; one that cannot be fetched stays what it was.
    fn embed_images(&mut self, resolve: &mut Resolve) {
        let count = self.list("images").len();
        for index in 0..count {
            let Some(uri) = self.json["images"][index]["uri"].as_str().map(str::to_owned) else { continue };
            let Ok(bytes) = fetch(&uri, resolve) else { continue };
            let Some(kind) = image_kind(&bytes) else { continue };
            let view = self.append_view(&bytes);
            let image = &mut self.json["images"][index];
            if image["name"].is_null() && !uri.starts_with("data:") {
                image["name"] = uri.into();
            }
            image["bufferView"] = view.into();
            image["mimeType"] = kind.into();
            if let Some(image) = image.as_object_mut() {
                image.remove("uri");
            }
        }
    }

    /// The objects of a list of the file, such as `meshes`.
    pub fn list(&self, key: &str) -> &[Value] {
        self.json.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
    }

    /// Adds an object to a list of the file, and gives its index.
    pub fn push(&mut self, key: &str, object: Value) -> usize {
        if !self.json[key].is_array() {
            self.json[key] = json!([]);
        }
        let Some(list) = self.json[key].as_array_mut() else { return 0 };
        list.push(object);
        list.len() - 1
    }

    /// Says that the file uses an extension.
    pub fn use_extension(&mut self, name: &str) {
        if !self.list("extensionsUsed").iter().any(|used| used == name) {
            self.push("extensionsUsed", name.into());
        }
    }

    /// Says that the file does not use an extension any more.
    pub fn forget_extension(&mut self, name: &str) {
        for key in ["extensionsUsed", "extensionsRequired"] {
            let Some(list) = self.json.get_mut(key).and_then(Value::as_array_mut) else { continue };
            list.retain(|used| used != name);
            if list.is_empty()
                && let Some(root) = self.json.as_object_mut()
            {
                root.remove(key);
            }
        }
    }

    /// Takes an extension away from the root of the file.
    pub(super) fn forget_root(&mut self, name: &str) {
        if let Some(extensions) = self.json.get_mut("extensions").and_then(Value::as_object_mut) {
            extensions.remove(name);
            if extensions.is_empty()
                && let Some(root) = self.json.as_object_mut()
            {
                root.remove("extensions");
            }
        }
        self.forget_extension(name);
    }

    fn append_bytes(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(8), 0);
        let offset = self.binary.len();
        self.binary.extend_from_slice(bytes);
        offset
    }

    /// Adds bytes, and gives the index of their buffer view.
    pub fn append_view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.append_bytes(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// Adds numbers, and gives the index of their accessor. Those of three floats have bounds, as positions must.
    pub fn append_accessor(&mut self, numbers: Numbers) -> usize {
        let (count, kind, component) = match numbers {
            Numbers::Vec2(numbers) => (numbers.len(), "VEC2", 5126),
            Numbers::Vec3(numbers) => (numbers.len(), "VEC3", 5126),
            Numbers::Vec4(numbers) => (numbers.len(), "VEC4", 5126),
            Numbers::Indices(numbers) => {
                let is_short = numbers.iter().all(|index| *index < u32::from(u16::MAX));
                (numbers.len(), "SCALAR", if is_short { 5123 } else { 5125 })
            }
        };
        let view = match numbers {
            Numbers::Vec2(numbers) => self.append_view(bytemuck::cast_slice(numbers)),
            Numbers::Vec3(numbers) => self.append_view(bytemuck::cast_slice(numbers)),
            Numbers::Vec4(numbers) => self.append_view(bytemuck::cast_slice(numbers)),
            Numbers::Indices(numbers) if component == 5123 => {
                let short: Vec<u16> = numbers.iter().map(|index| *index as u16).collect();
                self.append_view(bytemuck::cast_slice(&short))
            }
            Numbers::Indices(numbers) => self.append_view(bytemuck::cast_slice(numbers)),
        };
        let target = if matches!(numbers, Numbers::Indices(_)) { 34963 } else { 34962 };
        self.json["bufferViews"][view]["target"] = target.into();
        let mut accessor = json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if let Numbers::Vec3(numbers) = numbers {
            let bound = |from: f32, of: fn(f32, f32) -> f32| {
                numbers.iter().fold([from; 3], |bound, number| [0, 1, 2].map(|part| of(bound[part], number[part])))
            };
            accessor["min"] = json!(bound(f32::INFINITY, f32::min));
            accessor["max"] = json!(bound(f32::NEG_INFINITY, f32::max));
        }
        self.push("accessors", accessor)
    }

    /// Adds the bytes of an image, and gives the index of the image.
    pub fn append_image(&mut self, name: &str, mime_type: &str, bytes: &[u8]) -> usize {
        let view = self.append_view(bytes);
        self.push("images", json!({ "name": name, "bufferView": view, "mimeType": mime_type }))
    }

    /// The file as GLB; none if it is larger than 4 GiB.
    pub fn to_glb(mut self) -> Option<Vec<u8>> {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let has_binary = !self.binary.is_empty();
        if has_binary {
            if self.list("buffers").is_empty() {
                self.push("buffers", Value::Null);
            }
            self.json["buffers"][0] = json!({ "byteLength": self.binary.len() });
        } else if self.list("buffers").len() <= 1
            && let Some(root) = self.json.as_object_mut()
        {
            root.remove("buffers");
        }
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunks = text.len() + if has_binary { 8 + self.binary.len() } else { 0 };
        let length = Some(20 + chunks).filter(|length| *length <= GLB_BYTES_MAX)?;
        let mut bytes = Vec::with_capacity(length);
        let number = |number: usize| (number as u32).to_le_bytes();
        bytes.extend_from_slice(GLB_MAGIC);
        bytes.extend([number(2), number(length), number(text.len())].concat());
        bytes.extend_from_slice(b"JSON");
        bytes.append(&mut text);
        if has_binary {
            bytes.extend(number(self.binary.len()));
            bytes.extend_from_slice(b"BIN\0");
            bytes.append(&mut self.binary);
        }
        Some(bytes)
    }
}

/// Says something in the `extras` of an object, where applications may put anything: what is there and is no object is
/// kept as `value` of one.
pub fn put_extra(object: &mut Value, key: &str, value: Value) {
    let extras = &mut object["extras"];
    if !extras.is_object() {
        let old = extras.take();
        *extras = if old.is_null() { json!({}) } else { json!({ "value": old }) };
    }
    extras[key] = value;
}

/// A view, or an extension of one, whose buffer lies elsewhere now.
fn move_view(view: &mut Value, places: &BTreeMap<u64, (u64, u64)>) {
    let buffer = view.get("buffer").and_then(Value::as_u64);
    let Some((buffer, offset)) = buffer.and_then(|buffer| places.get(&buffer)) else { return };
    view["buffer"] = (*buffer).into();
    let start = view.get("byteOffset").and_then(Value::as_u64).unwrap_or(0) + offset;
    view["byteOffset"] = start.into();
}

/// The media type of an image that glTF and its extensions know.
fn image_kind(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', ..] => Some("image/webp"),
        [0xab, b'K', b'T', b'X', ..] => Some("image/ktx2"),
        [0x76, 0x2f, 0x31, 0x01, ..] => Some("image/x-exr"),
        [b'#', b'?', ..] => Some("image/vnd.radiance"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_extras_are_one_more_fits() {
        for (before, after) in [
            (json!({}), json!({ "extras": { "mode": "baked" } })),
            (json!({ "extras": { "a": 1 } }), json!({ "extras": { "a": 1, "mode": "baked" } })),
            (json!({ "extras": "a text" }), json!({ "extras": { "value": "a text", "mode": "baked" } })),
            (json!({ "extras": [1] }), json!({ "extras": { "value": [1], "mode": "baked" } })),
        ] {
            let mut object = before;
            put_extra(&mut object, "mode", "baked".into());
            assert_eq!(object, after);
        }
    }
}
