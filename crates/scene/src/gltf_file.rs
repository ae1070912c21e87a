//! Reads glTF 2.0, as `.gltf` with its files or as `.glb`.
//!
//! The file is never trusted: every range, count and reference is checked before memory is taken, so that a hostile
//! file ends in a [`LoadError`] that names the place, not in a panic. What is wrong but harmless becomes a warning.

mod accessor;
mod animation;
mod container;
mod draco;
mod faults;
pub(crate) mod geometry;
mod instances;
mod json;
mod levels;
mod material;
mod mesh;
mod meshopt;
mod node;
mod packed;
mod probes;
pub(crate) mod references;
mod surroundings;
mod write;

pub(crate) use material::texel_budget_bytes;
pub use references::{mentions, references};
pub use write::{Numbers, Parts, Unreferenced, put_extra};

use crate::input_file::{self, InputError};
use crate::tally::Tally;
use crate::turns::{Turns, at_once};
use crate::{Scene, scenes::MAX_DRAWN_PRIMITIVES};
use faults::Faults;
use json::Json;
use std::collections::BTreeMap;
use std::path::{Component, Path};

/// The extensions that are read; a file that requires another one is refused.
pub const SUPPORTED_EXTENSIONS: [&str; 32] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "MANYPASS_light_direction",
    "MANYPASS_probes",
    "MANYPASS_surroundings",
    "MANYPASS_texture_exr",
    "MSFT_lod",
    "MOZ_lightmap",
    "MOZ_texture_rgbe",
];

/// The most extensions of a file that are named; there are not as many.
const MAX_EXTENSIONS: usize = 100;

/// The largest file that is read, the model's own or one beside it: 1 GiB.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// A scene as read, and what is wrong with its file but does not hinder drawing.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene, its transforms up to date.
    pub scene: Scene,
    /// One line each.
    pub warnings: Vec<String>,
}

/// Why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file or one that it names cannot be fetched.
    #[error("{file}: {message}")]
    Io {
        /// The model's file.
        file: String,
        /// What went wrong and what to do.
        message: String,
    },
    /// The file is not valid glTF 2.0.
    #[error("{file}: {}{message}", place(pointer))]
    Invalid {
        /// The model's file.
        file: String,
        /// The JSON pointer of what is wrong; empty for the whole file.
        pointer: String,
        /// What was expected and what to do.
        message: String,
    },
    /// The file is not valid in a format other than glTF.
    #[error("{file}: {}{message}", place_before(place))]
    Malformed {
        /// The model's file.
        file: String,
        /// What is wrong: `line 5`, `byte 84`; empty for the whole file.
        place: String,
        /// What was expected and what to do.
        message: String,
    },
    /// The file requires an extension that is not supported.
    #[error(
        "{file}: at \"/extensionsRequired\": requires {extension}, which is not supported; \
         export the model again without it"
    )]
    UnsupportedExtension {
        /// The model's file.
        file: String,
        /// The name of the extension.
        extension: String,
    },
}

/// Where something is, for a message; nothing for the whole file.
fn place(pointer: &str) -> String {
    if pointer.is_empty() { String::new() } else { format!("at \"{pointer}\": ") }
}

/// The same of other formats.
fn place_before(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!("{place}: ") }
}

impl LoadError {
    /// An error at a place of a file that is not glTF.
    pub(crate) fn malformed(place: &str, message: impl Into<String>) -> Self {
        Self::Malformed { file: String::new(), place: place.to_owned(), message: message.into() }
    }

    /// An error at `pointer`; [`load_bytes`] adds the file's name.
    fn invalid(pointer: &str, message: impl Into<String>) -> Self {
        Self::Invalid { file: String::new(), pointer: pointer.to_owned(), message: message.into() }
    }

    /// Where it is in the JSON of a glTF file; empty for the whole file.
    fn pointer(&self) -> &str {
        if let Self::Invalid { pointer, .. } = self { pointer } else { "" }
    }

    /// What went wrong, without the place.
    fn into_message(self) -> String {
        match self {
            Self::Io { message, .. } | Self::Invalid { message, .. } | Self::Malformed { message, .. } => message,
            unsupported @ Self::UnsupportedExtension { .. } => unsupported.to_string(),
        }
    }

    pub(crate) fn in_file(mut self, name: &str) -> Self {
        let (Self::Io { file, .. }
        | Self::Invalid { file, .. }
        | Self::Malformed { file, .. }
        | Self::UnsupportedExtension { file, .. }) = &mut self;
        name.clone_into(file);
        self
    }
}

/// Reads the model at `path`, together with the files beside it that it names. Files outside its folder are refused.
pub fn load_path(path: &Path) -> Result<Loaded, LoadError> {
    let name = path.display().to_string();
    let bytes = read_file(path).map_err(|message| LoadError::Io { file: name.clone(), message })?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    load_bytes(&bytes, &mut |uri| read_file(&folder.join(checked_relative_path(uri)?)), &name)
}

/// The file beside the model that a decoded URI names.
pub(crate) fn checked_relative_path(uri: &str) -> Result<&Path, String> {
    let path = Path::new(uri);
    let is_plain = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if uri.is_empty() || !is_plain || uri.contains([':', '\\', '\0']) {
        return Err(format!(
            "\"{uri}\" is not a path inside the model's folder; put the file there and name it plainly"
        ));
    }
    Ok(path)
}

pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    input_file::read(path, MAX_FILE_BYTES).map_err(|error| match error {
        InputError::NotRegular | InputError::Folder => {
            let hint = "a model can be piped in as `-`";
            format!("\"{}\" is not a regular file; {hint}", path.display())
        }
        InputError::TooLarge(_) => format!("\"{}\" is larger than 1 GiB; split it", path.display()),
        error => format!("cannot read \"{}\": {error}", path.display()),
    })
}

/// Reads a `.glb` or `.gltf` file from memory. `resolve` fetches the bytes of a relative URI, already percent-decoded;
/// data URIs never reach it. `name` appears in errors.
pub fn load_bytes(
    bytes: &[u8],
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    name: &str,
) -> Result<Loaded, LoadError> {
    at_once(load_bytes_in_turns(bytes, resolve, name, &mut || None))
}

/// As [`load_bytes`]; `turns` is asked after every primitive, and between slices of a large one.
pub(crate) async fn load_bytes_in_turns(
    bytes: &[u8],
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    name: &str,
    turns: &mut Turns<'_>,
) -> Result<Loaded, LoadError> {
    load(bytes, resolve, turns).await.map_err(|error| error.in_file(name))
}

/// What the parts of the reader share.
struct Document<'a> {
    root: Json<'a>,
    accessors: Vec<Json<'a>>,
    views: Vec<container::View>,
    buffers: Vec<Option<std::borrow::Cow<'a, [u8]>>>,
    warnings: Tally,
    /// What is broken and may not be needed.
    faults: Faults,
    /// Accessors of the primitive that is read, if it is packed.
    unpacked: BTreeMap<usize, draco::Unpacked>,
    /// The UV sets of the file that vertices have for each material.
    uv_sets: Vec<[u32; 2]>,
    /// The names of the file's variants.
    variants: Vec<String>,
    /// Bytes that may still be decoded, so that accessors which share bytes cannot multiply them without end.
    budget_bytes: u64,
    /// The same for accessors without bytes of their own.
    zeros_budget_bytes: u64,
}

impl Document<'_> {
    /// Counts a warning. Those of the same kind differ in numbers alone, those of their places too.
    fn warn(&mut self, pointer: &str, message: &str) {
        let kind: String = format!("{pointer} {message}").chars().filter(|c| !c.is_ascii_digit()).collect();
        let place = if pointer.is_empty() { String::new() } else { format!("at \"{pointer}\"") };
        self.warnings.add_as(&kind, place, message);
    }

    /// Numbers of at least 0 and at most `max`; those outside are moved there, with a warning.
    fn clamped<const N: usize>(
        &mut self,
        json: &Json,
        key: &str,
        default: [f32; N],
        max: f32,
    ) -> Result<[f32; N], LoadError> {
        let given = json.numbers(key)?.unwrap_or(default);
        Ok(self.clamp(json, key, given, max))
    }

    /// As [`Self::clamped`], for a single number.
    fn clamped_number(&mut self, json: &Json, key: &str, default: f32, max: f32) -> Result<f32, LoadError> {
        let given = [json.number(key)?.unwrap_or(default)];
        let [number] = self.clamp(json, key, given, max);
        Ok(number)
    }

    fn clamp<const N: usize>(&mut self, json: &Json, key: &str, given: [f32; N], max: f32) -> [f32; N] {
        let numbers = given.map(|number| number.clamp(0.0, max));
        if numbers != given {
            let upper = if max == f32::MAX { String::new() } else { format!(" and at most {max}") };
            self.warn(&json.at(key), &format!("expected at least 0{upper}, found {given:?}; {numbers:?} is used"));
        }
        numbers
    }
}

async fn load(
    bytes: &[u8],
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    turns: &mut Turns<'_>,
) -> Result<Loaded, LoadError> {
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
    faults::check_names(&mut document)?;
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
    faults::check_needed(&mut document, &scene)?;
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
    Ok(Loaded { scene, warnings: document.warnings.into_lines() })
}

/// The names of the file's variants.
fn read_variants(root: &Json) -> Result<Vec<String>, LoadError> {
    let Some(extension) = root.extension("KHR_materials_variants")? else { return Ok(Vec::new()) };
    Ok(extension.objects("variants")?.iter().map(Json::name).collect())
}

fn check_version(root: &Json) -> Result<(), LoadError> {
    let asset = root.object("asset")?.ok_or_else(|| {
        LoadError::invalid("/asset", "expected an object with the glTF version; is this a glTF file?")
    })?;
    for (key, required) in [("version", true), ("minVersion", false)] {
        match asset.string(key)? {
            Some("2.0") => {}
            Some(version) if key == "version" && version.starts_with("2.") => {}
            None if !required => {}
            found => {
                let found = found.unwrap_or("nothing");
                let message = format!("expected version 2.0, found {found}; export the model as glTF 2.0");
                return Err(LoadError::invalid(&format!("/asset/{key}"), message));
            }
        }
    }
    Ok(())
}

/// Refuses extensions that are required and not supported; gives those that are only used.
fn check_extensions(root: &Json) -> Result<Vec<String>, LoadError> {
    let is_supported = |name: &str| SUPPORTED_EXTENSIONS.contains(&name);
    if let Some(extension) = root.strings("extensionsRequired")?.into_iter().find(|name| !is_supported(name)) {
        return Err(LoadError::UnsupportedExtension { file: String::new(), extension: extension.to_owned() });
    }
    let used = root.strings("extensionsUsed")?;
    Ok(used.into_iter().filter(|name| !is_supported(name)).take(MAX_EXTENSIONS).map(str::to_owned).collect())
}
