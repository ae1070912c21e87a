//! The readers of all formats but glTF.

mod image_files;
mod mtl;
mod obj;
mod parts;
mod ply;
mod polygon;
mod smooth;
mod stl;
mod text;
mod threemf;
mod two_sided;
mod vertex_corners;

use super::detect::START_BYTES;
use super::format::Format;
use crate::gltf_file::{self, LoadError, LoadedScene};
use crate::tally::Tally;
use std::fmt::Display;

impl Tally {
    /// Counts a warning; those with the same message are one kind.
    pub(crate) fn add(&mut self, place: impl Display, message: &str) {
        self.add_as(message, place, message);
    }
}

type Resolve<'r> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'r;

/// Reads a model; `resolve` fetches what it names.
///
/// # Errors
/// It is broken; with the place in it.
pub(super) fn load(format: Format, bytes: &[u8], resolve: &mut Resolve) -> Result<LoadedScene, LoadError> {
    match format {
        Format::Gltf => gltf_file::load_bytes(bytes, resolve, ""),
        Format::Stl => stl::load(bytes),
        Format::Obj => obj::load(bytes, resolve),
        Format::Ply => ply::load(bytes, resolve),
        Format::ThreeMf => threemf::load(bytes),
    }
}

/// The files that an OBJ names: its libraries, then their textures; of a PLY the textures that its header names.
pub(super) fn names(format: Format, bytes: &[u8], resolve: &mut Resolve) -> Vec<String> {
    match format {
        Format::Obj => obj::names(bytes, resolve),
        Format::Ply => ply::names(bytes.get(..START_BYTES).unwrap_or(bytes)),
        Format::Gltf | Format::Stl | Format::ThreeMf => Vec::new(),
    }
}
