//! Models of every format that is read: glTF, and the files that scanners, printers and older programs write.
//!
//! Which format a file has is told by its bytes where they tell, and by its ending where they do not. `docs/inputs.md`
//! says what each format means here: units, the axis that points up, normals, colours, materials.

mod detect;
mod format;
#[cfg(feature = "formats")]
mod readers;
#[cfg(not(feature = "formats"))]
#[path = "formats/absent.rs"]
mod readers;

pub use format::Format;

use crate::gltf_file::{
    self, LoadError, LoadedScene, MAX_FILE_BYTES, checked_relative_path, read_file, references::meant_paths,
};
use crate::input_file::{self, InputError};
use crate::turns::{Turns, at_once};
use detect::START_BYTES;
use std::io::Read;
use std::path::{Path, PathBuf};

/// How the names of models end, whatever the case of the letters.
pub const MODEL_ENDINGS: [&str; 6] = ["glb", "gltf", "stl", "obj", "ply", "3mf"];

impl Format {
    /// The format of a file of these bytes and this name. What cannot be told is taken for glTF, whose reader says what
    /// is wrong.
    pub fn of(bytes: &[u8], name: &str) -> Self {
        Self::of_start(bytes, bytes.len() as u64, name)
    }

    fn of_start(start: &[u8], file_bytes: u64, name: &str) -> Self {
        let start = start.get(..START_BYTES).unwrap_or(start);
        detect::of_content(start, file_bytes).or_else(|| Self::of_ending(name)).unwrap_or(Self::Gltf)
    }

    fn of_ending(name: &str) -> Option<Self> {
        let ending = Path::new(name).extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "glb" | "gltf" => Some(Self::Gltf),
            "stl" => Some(Self::Stl),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "3mf" => Some(Self::ThreeMf),
            _ => None,
        }
    }

    /// The format of the file at `path`; glTF if it cannot be read.
    fn at(path: &Path) -> Self {
        let start = || {
            let file = input_file::open(path).ok()?;
            let file_bytes = file.metadata().ok()?.len();
            let mut start = Vec::new();
            file.take(START_BYTES as u64).read_to_end(&mut start).ok()?;
            Some((start, file_bytes))
        };
        match start() {
            Some((start, file_bytes)) => Self::of_start(&start, file_bytes, &path.to_string_lossy()),
            None => Self::Gltf,
        }
    }
}

/// Whether a path is called as models are.
pub fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|end| MODEL_ENDINGS.iter().any(|model| end.eq_ignore_ascii_case(model)))
}

/// Reads the model at `path`, of any [`Format`], together with the files beside it that it names. Files outside its
/// folder are refused.
///
/// # Errors
/// The file cannot be read, or is wrong; with the place in it.
pub fn load_path(path: &Path) -> Result<LoadedScene, LoadError> {
    let name = path.display().to_string();
    let bytes = read_file(path).map_err(|message| LoadError::Io { file: name.clone(), message })?;
    load_bytes(&bytes, &mut read_beside(path), &name)
}

/// Reads a model of any [`Format`] from memory. `resolve` fetches the bytes of a file that the model names, by its path
/// from the model. `name` appears in errors, and its ending tells the format where the bytes do not.
///
/// # Errors
/// As [`load_path`].
pub fn load_bytes(
    bytes: &[u8],
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    name: &str,
) -> Result<LoadedScene, LoadError> {
    at_once(load_bytes_in_turns(bytes, resolve, name, &mut || None))
}

/// As [`load_bytes`]; between the primitives of glTF, and between slices of large ones, `turns` is asked whether others
/// are to have the thread.
///
/// # Errors
/// As [`load_path`].
pub async fn load_bytes_in_turns(
    bytes: &[u8],
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    name: &str,
    turns: &mut Turns<'_>,
) -> Result<LoadedScene, LoadError> {
    let format = Format::of(bytes, name);
    if format != Format::Gltf && bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(LoadError::malformed("", "it is larger than 1 GiB; split it").in_file(name));
    }
    let loaded = match format {
        Format::Gltf => return gltf_file::load_bytes_in_turns(bytes, resolve, name, turns).await,
        other => readers::load(other, bytes, resolve),
    };
    loaded.map_err(|error| error.in_file(name))
}

/// Reads files beside the model at `path`.
fn read_beside(path: &Path) -> impl FnMut(&str) -> Result<Vec<u8>, String> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    move |name| read_file(&folder.join(checked_relative_path(name)?))
}

/// The files that an OBJ names: its libraries, then their textures.
fn obj_names(path: &Path) -> Result<Vec<String>, LoadError> {
    let name = path.display().to_string();
    let bytes = read_file(path).map_err(|message| LoadError::Io { file: name, message })?;
    Ok(readers::names(Format::Obj, &bytes, &mut read_beside(path)))
}

/// The textures that the header of a PLY names.
fn ply_names(path: &Path) -> Result<Vec<String>, LoadError> {
    let read = || {
        let mut start = Vec::new();
        input_file::open(path)?.take(START_BYTES as u64).read_to_end(&mut start)?;
        Ok(start)
    };
    let error = |error: InputError| LoadError::Io { file: path.display().to_string(), message: error.to_string() };
    Ok(readers::names(Format::Ply, &read().map_err(error)?, &mut read_beside(path)))
}

/// The paths of the files that a model in memory names: of an OBJ its libraries of materials, then the textures of those
/// that `resolve` fetches, and of a PLY its textures. None for other formats, and none that could lead out of the model's
/// folder.
pub fn named_files(bytes: &[u8], resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>) -> Vec<String> {
    let mut names = readers::names(Format::of(bytes, ""), bytes, resolve);
    names.retain(|name| checked_relative_path(name).is_ok());
    names
}

/// The files that [`load_path`] would read beside the model at `path`, whether they are there or not: buffers and
/// images of glTF, material libraries of OBJ and their textures. Places outside the model's folder are none.
///
/// # Errors
/// If the model cannot be read. What else may be wrong with it is not looked at.
pub fn references(path: &Path) -> Result<Vec<PathBuf>, LoadError> {
    if input_file::is_open_pipe(path) {
        // What is read here is gone when the model is loaded, and there is no folder beside it.
        return Ok(Vec::new());
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    match Format::at(path) {
        Format::Gltf => gltf_file::references(path),
        format @ (Format::Obj | Format::Ply) => {
            let names = if format == Format::Obj { obj_names(path)? } else { ply_names(path)? };
            Ok(names.iter().filter_map(|name| checked_relative_path(name).ok()).map(|file| folder.join(file)).collect())
        }
        Format::Stl | Format::ThreeMf => Ok(Vec::new()),
    }
}

/// Every path that the model at `path` could mean by a name in it, also where [`load_path`] refuses to read it. For
/// whoever must not write to any of them.
///
/// # Errors
/// As [`references`].
pub fn mentions(path: &Path) -> Result<Vec<PathBuf>, LoadError> {
    if input_file::is_open_pipe(path) {
        return Ok(Vec::new());
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    match Format::at(path) {
        Format::Gltf => gltf_file::mentions(path),
        Format::Obj => Ok(meant_paths(folder, &obj_names(path)?)),
        Format::Ply => Ok(meant_paths(folder, &ply_names(path)?)),
        Format::Stl | Format::ThreeMf => Ok(Vec::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_tell_the_format_before_the_ending_does() {
        let mut binary_stl = b"solid, but not as text".to_vec();
        binary_stl.resize(80, b' ');
        binary_stl.extend(1_u32.to_le_bytes());
        binary_stl.extend([0; 50]);
        let cases: [(&[u8], &str, Format); 16] = [
            (b"glTF\x02\0\0\0", "a.stl", Format::Gltf),
            (b"\xef\xbb\xbf {}", "a.obj", Format::Gltf),
            (b"ply\r\nformat ascii 1.0\r\n", "a", Format::Ply),
            (b"PK\x03\x04", "a", Format::ThreeMf),
            (&binary_stl, "-", Format::Stl),
            (&binary_stl[..100], "a.STL", Format::Stl),
            (&binary_stl[..100], "a", Format::Gltf),
            (b"solid a\n facet normal 0 0 1\n", "-", Format::Stl),
            (b"solid\nendsolid\n", "-", Format::Stl),
            (b"# made by hand\n\nmtllib a.mtl\n", "-", Format::Obj),
            (b"v 1 2 3\n", "-", Format::Obj),
            (b"vector", "-", Format::Gltf),
            (b"# nothing", "a.obj", Format::Obj),
            (b"", "a.3mf", Format::ThreeMf),
            (b"", "a.ply", Format::Ply),
            (b"", "", Format::Gltf),
        ];
        for (bytes, name, expected) in cases {
            assert_eq!(Format::of(bytes, name), expected, "{name} {:?}", String::from_utf8_lossy(bytes));
        }
    }
}
