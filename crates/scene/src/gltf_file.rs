//! Reads glTF 2.0, as `.gltf` with its files or as `.glb`.
//!
//! The file is never trusted: every range, count and reference is checked before memory is taken, so that a hostile
//! file ends in a [`LoadError`] that names the place, not in a panic. What is wrong but harmless becomes a warning.

mod accessor;
mod animation;
mod component;
mod container;
mod document;
mod draco;
mod error;
mod extensions;
mod faults;
mod files;
pub(crate) mod geometry;
mod instances;
mod json;
mod levels;
mod material;
mod mesh;
mod meshopt;
mod needed;
mod node;
mod packed;
mod probes;
pub(crate) mod references;
mod surroundings;
mod write;

pub use error::LoadError;
pub use extensions::SUPPORTED_EXTENSIONS;
pub use files::MAX_FILE_BYTES;
pub(crate) use files::{checked_relative_path, read_file, texel_budget_bytes};
pub use references::{mentions, references};
pub use write::prune::UnreferencedObjects;
pub use write::{Numbers, Parts, put_extra};

use crate::tally::Tally;
use crate::turns::{Turns, at_once};
use crate::{Scene, scenes::MAX_DRAWN_PRIMITIVES};
use document::Document;
use extensions::{MAX_EXTENSIONS, check_extensions, check_version};
use faults::Faults;
use json::Json;
use std::collections::BTreeMap;
use std::path::Path;

/// A loaded scene, with the warnings about its file.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The scene, its transforms up to date.
    pub scene: Scene,
    /// One line each.
    pub warnings: Vec<String>,
}

/// Reads the model at `path`, together with the files beside it that it names. Files outside its folder are refused.
pub fn load_path(path: &Path) -> Result<LoadedScene, LoadError> {
    let name = path.display().to_string();
    let bytes = read_file(path).map_err(|message| LoadError::Io { file: name.clone(), message })?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    load_bytes(&bytes, &mut |uri| read_file(&folder.join(checked_relative_path(uri)?)), &name)
}

/// Reads a `.glb` or `.gltf` file from memory. `resolve` fetches the bytes of a relative URI, already percent-decoded;
/// data URIs never reach it. `name` appears in errors.
pub fn load_bytes(
    bytes: &[u8],
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    name: &str,
) -> Result<LoadedScene, LoadError> {
    at_once(load_bytes_in_turns(bytes, resolve, name, &mut || None))
}

/// As [`load_bytes`]; `turns` is asked after every primitive, and between slices of a large one.
pub(crate) async fn load_bytes_in_turns(
    bytes: &[u8],
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    name: &str,
    turns: &mut Turns<'_>,
) -> Result<LoadedScene, LoadError> {
    load(bytes, resolve, turns).await.map_err(|error| error.in_file(name))
}

async fn load(
    bytes: &[u8],
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    turns: &mut Turns<'_>,
) -> Result<LoadedScene, LoadError> {
    let (json_bytes, binary) = container::split(bytes)?;
    let value: serde_json::Value = serde_json::from_slice(json_bytes)
        .map_err(|error| LoadError::invalid("", format!("not a glTF file: its JSON does not parse: {error}")))?;
    let root = Json::root(&value)?;
    check_version(&root)?;
    let unread = check_extensions(&root)?;
    let mut faults = Faults::default();
    let buffers =
        container::read_buffers(&root, binary, bytes.starts_with(container::GLB_MAGIC), resolve, &mut faults)?;
    let views = container::read_views(&root, &buffers, &mut faults)?;
    let mut document = Document {
        accessors: root.objects("accessors")?,
        root,
        views,
        buffers,
        warnings: Tally::default(),
        faults,
        unpacked: BTreeMap::new(),
        uv_sets: Vec::new(),
        variants: Vec::new(),
        budget_bytes: 0,
        zeros_budget_bytes: 1 << 28,
    };
    unread.iter().for_each(|name| {
        document.warn("/extensionsUsed", &format!("{name} is not supported; the model may look different"));
    });
    if bytes.starts_with(container::BYTE_ORDER_MARK) {
        document.warn("", "the file starts with a byte order mark, which glTF forbids; it is passed over");
    }
    needed::check_names(&mut document)?;
    meshopt::unpack_views(&mut document, resolve)?;
    let buffer_bytes: u64 = document.buffers.iter().flatten().map(|bytes| bytes.len() as u64).sum();
    // Floats from bytes, unwelding and sharing multiply what a buffer holds; honest models stay far below this.
    document.budget_bytes = (256 << 20) + buffer_bytes.saturating_mul(32).min(8 << 30);
    accessor::check_all(&mut document);

    let mut images = material::read_images(&mut document, resolve)?;
    let textures = material::read_textures(&mut document, &mut images)?;
    let mut materials = material::read_materials(&mut document, &textures, &images)?;
    let levels = levels::of_materials(&mut document, materials.len())?;
    materials.iter_mut().zip(levels).for_each(|(material, levels)| material.levels = levels);
    document.variants = read_variants(&document.root)?;
    let meshes = mesh::read_meshes(&mut document, &materials, turns).await?;
    let mut scene = Scene { images: images.images, textures, materials, meshes, ..Scene::default() };
    scene.variants = std::mem::take(&mut document.variants);
    let used = document.root.strings("extensionsUsed")?;
    scene.extensions_used = used.into_iter().take(MAX_EXTENSIONS).map(str::to_owned).collect();
    let stops = value.pointer("/asset/extras/exposureStops").and_then(serde_json::Value::as_f64);
    scene.exposure_stops = stops.map(|stops| stops as f32).filter(|stops| stops.is_finite());
    let holds_light = |baked: &&serde_json::Value| {
        ["lightMap", "emission", "probes", "surroundings"].iter().any(|of| baked.get(of).is_some())
    };
    let baked = value.pointer("/asset/extras/bake").filter(holds_light);
    // What was baked in the studio is shown in the studio.
    scene.holds_baked_light = baked.is_some_and(|baked| baked.get("environment").is_none_or(|of| of != "studio"));
    scene.probes = probes::read_probes(&mut document)?;
    scene.surroundings = surroundings::read_surroundings(&mut document)?;
    scene.cameras = node::read_cameras(&mut document)?;
    scene.lights = node::read_lights(&mut document)?;
    scene.lights_are_photometric = true;
    node::read_nodes(&mut document, &mut scene)?;
    levels::of_nodes(&mut document, &mut scene)?;
    node::read_skins(&mut document, &mut scene)?;
    animation::read_animations(&mut document, &mut scene)?;
    instances::place(&mut document, &mut scene)?;
    needed::check_needed(&mut document, &scene)?;
    scene.update_transforms();
    match scene.drawn_primitives() {
        0 => document.warn("/scene", "the scene draws nothing; it has no visible node with a mesh"),
        1..=MAX_DRAWN_PRIMITIVES => {}
        count => {
            let message = format!(
                "the nodes draw {count} primitives together, and {MAX_DRAWN_PRIMITIVES} are possible; join meshes"
            );
            return Err(LoadError::invalid("/nodes", message));
        }
    }
    Ok(LoadedScene { scene, warnings: document.warnings.into_lines() })
}

/// The names of the file's variants.
fn read_variants(root: &Json) -> Result<Vec<String>, LoadError> {
    let Some(extension) = root.extension("KHR_materials_variants")? else { return Ok(Vec::new()) };
    Ok(extension.objects("variants")?.iter().map(Json::name).collect())
}
