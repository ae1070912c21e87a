//! The version and the extensions of a file.

use super::error::LoadError;
use super::json::Json;

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
pub(super) const MAX_EXTENSIONS: usize = 100;

/// Refuses what is no glTF 2.
///
/// # Errors
/// It is none.
pub(super) fn check_version(root: &Json) -> Result<(), LoadError> {
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
///
/// # Errors
/// One is required.
pub(super) fn check_extensions(root: &Json) -> Result<Vec<String>, LoadError> {
    let is_supported = |name: &str| SUPPORTED_EXTENSIONS.contains(&name);
    if let Some(extension) = root.strings("extensionsRequired")?.into_iter().find(|name| !is_supported(name)) {
        return Err(LoadError::UnsupportedExtension { file: String::new(), extension: extension.to_owned() });
    }
    let used = root.strings("extensionsUsed")?;
    Ok(used.into_iter().filter(|name| !is_supported(name)).take(MAX_EXTENSIONS).map(str::to_owned).collect())
}
