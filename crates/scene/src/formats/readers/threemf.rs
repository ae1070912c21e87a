//! 3MF (3MF Consortium, core specification 1.3): parts in units, as printers take them, in a ZIP archive. Read are
//! meshes, components, base materials, groups of colours and textures, in one part of the archive or several (production
//! extension).
//!
//! Z points up in the file. Meshes keep the file's numbers; a node above all turns them and takes them to metres.

mod attribute;
mod build;
mod package;
mod xml;

use crate::gltf_file::{LoadError, LoadedScene};

pub(super) fn load(bytes: &[u8]) -> Result<LoadedScene, LoadError> {
    let mut package = package::Package::open(bytes)?;
    let root = package.root()?;
    let models = xml::read_all(&mut package, &root)?;
    build::scene(&models, &root, &mut package)
}
