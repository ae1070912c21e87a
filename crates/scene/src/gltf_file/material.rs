//! Images, textures, samplers and materials.

mod layers;
mod slots;

use super::container::{Resolve, decoded_uri, fetch};
use super::document::Document;
use super::error::LoadError;
use super::faults::List;
use super::files::texel_budget_bytes;
use super::json::Json;
use super::needed::index_or_none;
use crate::{
    AlphaMode, Image, ImageSource, Material, ON_ITS_WAY, PixelFormat, Pixels, Sampler, ShadingModel, Texture, Wrap,
};
use glam::{Vec3, Vec4};
use slots::Slots;
use std::collections::BTreeSet;
use std::sync::Arc;

fn white() -> ImageSource {
    ImageSource::Pixels(Arc::new(Pixels { width: 1, height: 1, format: PixelFormat::Rgba8, data: vec![255; 4] }))
}

/// The images of a file.
#[derive(Default)]
pub(super) struct Images {
    pub(super) images: Vec<Image>,
    /// Whether each could be read; materials do without those that are white instead.
    is_there: Vec<bool>,
}

impl Images {
    fn push(&mut self, name: String, source: Option<ImageSource>) {
        self.is_there.push(source.is_some());
        self.images.push(Image { name, source: source.unwrap_or_else(white) });
    }
}

/// Every image, still encoded. One that cannot be read becomes white and a warning.
pub(super) fn read_images(document: &mut Document, resolve: &mut Resolve) -> Result<Images, LoadError> {
    let mut images = Images::default();
    let (mut encoded_bytes, mut texel_bytes) = (0_u64, 0_u64);
    for json in document.root.objects("images")? {
        if json.string("mimeType").is_err() {
            document.warn(&json.at("mimeType"), "expected a string; the bytes tell the format");
        }
        let named = json.string("uri").and_then(|uri| {
            let view = json.index("bufferView", document.views.len(), "bufferView")?;
            Ok((uri, view))
        });
        let (uri, view) = match named {
            Ok(named) => named,
            Err(error) => {
                let pointer = error.pointer().to_owned();
                document.warn(&pointer, &format!("{}; materials do without the image", error.into_message()));
                images.push(json.name(), None);
                continue;
            }
        };
        let mut name = json.name();
        if let Some(uri) = uri
            && name.is_empty()
            && !uri.starts_with("data:")
        {
            uri.clone_into(&mut name);
        }
        let bytes = match (uri, view) {
            (Some(uri), None) => match fetch(uri, resolve) {
                Err(message) if message == ON_ITS_WAY => {
                    images.push(name, Some(ImageSource::Loading(decoded_uri(uri).unwrap_or_default().into())));
                    continue;
                }
                fetched => fetched,
            },
            (None, Some(view)) => {
                let bytes = document.view_bytes(view, &json.at("bufferView"));
                bytes.map(|(bytes, _)| bytes.to_vec()).map_err(LoadError::into_message)
            }
            (Some(_), Some(_)) => Err("expected a uri or a bufferView, found both".to_owned()),
            (None, None) => Err("expected a uri or a bufferView, found neither".to_owned()),
        };
        let source = bytes.and_then(|bytes| {
            encoded_bytes += bytes.len() as u64;
            let image = Image { name: String::new(), source: ImageSource::Encoded(bytes.into()) };
            let (width, height) = image.dimensions().map_err(|error| error.message)?;
            let image_bytes = u64::from(width) * u64::from(height) * 4;
            if texel_bytes + image_bytes > texel_budget_bytes(encoded_bytes) {
                return Err(format!(
                    "the images take more than {} MiB together; make them smaller",
                    texel_budget_bytes(encoded_bytes) >> 20
                ));
            }
            texel_bytes += image_bytes;
            if let Some(warning) = image.size_warning() {
                document.warn(&json.pointer, &warning);
            }
            Ok(image.source)
        });
        if let Err(message) = &source {
            document
                .warn(&json.pointer, &format!("{message}; materials do without it, unless a texture names another"));
        }
        images.push(name, source.ok());
    }
    Ok(images)
}

/// What a sampler says by one of these numbers, or the default with a warning.
fn chosen<T: Copy>(document: &mut Document, json: &Json, key: &str, choices: &[(usize, T)], default: T) -> T {
    if !json.has(key) {
        return default;
    }
    let found = json.integer(key).ok().flatten();
    let choice = found.and_then(|found| choices.iter().find(|(number, _)| *number == found));
    choice.map_or_else(
        || {
            let expected: Vec<String> = choices.iter().map(|(number, _)| number.to_string()).collect();
            let found = found.map_or("something else".into(), |found| found.to_string());
            let message = format!("expected {}, found {found}; the default is used", expected.join(", "));
            document.warn(&json.at(key), &message);
            default
        },
        |(_, value)| *value,
    )
}

fn read_sampler(document: &mut Document, json: &Json) -> Sampler {
    let minification = [
        (9728, (false, None)),
        (9729, (true, None)),
        (9984, (false, Some(false))),
        (9985, (true, Some(false))),
        (9986, (false, Some(true))),
        (9987, (true, Some(true))),
    ];
    let wraps = [(33071, Wrap::ClampToEdge), (33648, Wrap::MirroredRepeat), (10497, Wrap::Repeat)];
    let (min_linear, mip_linear) = chosen(document, json, "minFilter", &minification, (true, Some(true)));
    let mag_linear = chosen(document, json, "magFilter", &[(9728, false), (9729, true)], true);
    let [wrap_u, wrap_v] = ["wrapS", "wrapT"].map(|key| chosen(document, json, key, &wraps, Wrap::Repeat));
    Sampler { wrap_u, wrap_v, mag_linear, min_linear, mip_linear }
}

/// Every texture. One without an image that is supported gets a white one, and materials do without it.
pub(super) fn read_textures(document: &mut Document, images: &mut Images) -> Result<Vec<Texture>, LoadError> {
    let samplers = document.root.objects("samplers")?;
    let samplers: Vec<Sampler> = samplers.iter().map(|json| read_sampler(document, json)).collect();
    let (image_count, mut textures) = (images.images.len(), Vec::new());
    for json in document.root.objects("textures")? {
        let sampler = index_or_none(document, &json, "sampler", samplers.len(), "sampler");
        let (mut sources, mut has_source) = (Vec::new(), json.has("source"));
        for name in ["KHR_texture_basisu", "EXT_texture_webp", "MOZ_texture_rgbe", "MANYPASS_texture_exr"] {
            if let Some(extension) = json.extension(name)? {
                has_source |= extension.has("source");
                sources.extend(index_or_none(document, &extension, "source", image_count, "image"));
            }
        }
        sources.extend(index_or_none(document, &json, "source", image_count, "image"));
        // The plain image stands in for one that could not be read.
        let is_there = |image: &&usize| images.is_there.get(**image).copied().unwrap_or(false);
        let image = sources.iter().find(is_there).or(sources.first()).copied();
        if image.is_none() {
            // One that names an image which is not there has its warning.
            if !has_source {
                document.warn(&json.pointer, "the texture has no image that is supported; materials do without it");
            }
            images.push(String::new(), None);
        }
        textures.push(Texture {
            image: image.unwrap_or(images.images.len().saturating_sub(1)),
            sampler: sampler.and_then(|i| samplers.get(i).copied()).unwrap_or_default(),
        });
    }
    Ok(textures)
}

/// The materials whose extensions pointers of animations name. What is broken in animations is said where they are read.
fn animated_materials(document: &Document) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    for animation in document.root.objects("animations").unwrap_or_default() {
        for channel in animation.objects("channels").unwrap_or_default() {
            let target = channel.object("target").ok().flatten();
            let extension = target.and_then(|target| target.extension("KHR_animation_pointer").ok().flatten());
            let pointer = extension.and_then(|extension| extension.string("pointer").ok().flatten());
            let below = pointer.and_then(|pointer| pointer.strip_prefix("/materials/"));
            let index = below.and_then(|below| below.split_once("/extensions/")?.0.parse::<usize>().ok());
            found.extend(index);
        }
    }
    found
}

/// Every material. Where the image of a texture could not be read, it has no texture: a material without one is
/// defined.
pub(super) fn read_materials(
    document: &mut Document,
    textures: &[Texture],
    images: &Images,
) -> Result<Vec<Material>, LoadError> {
    let is_there = |texture: &Texture| images.is_there.get(texture.image).copied().unwrap_or(false);
    let has_image = textures.iter().map(is_there).collect();
    let materials = document.root.objects("materials")?;
    let kept = kept_materials(document, &materials)?;
    let animated = animated_materials(document);
    let mut slots = Slots { document, has_image, is_animated: false, uv_sets: [0, 1] };
    let mut all = Vec::with_capacity(kept);
    for (index, json) in materials.iter().enumerate().take(kept) {
        slots.is_animated = animated.contains(&index);
        slots.uv_sets = uv_sets(json);
        let read = read_material(json, &mut slots);
        all.push(slots.document.faults.or(List::Materials, index, read, Material::default()));
        slots.document.uv_sets.push(slots.uv_sets);
    }
    Ok(all)
}

/// So many materials are kept, whether anything uses them or not.
const KEPT_MATERIALS: usize = 4096;

/// How many materials are read: those behind the last one that something uses cost nothing if there are many.
fn kept_materials(document: &mut Document, materials: &[Json]) -> Result<usize, LoadError> {
    if materials.len() <= KEPT_MATERIALS {
        return Ok(materials.len());
    }
    let mut used = BTreeSet::new();
    let number = |json: &Json, key: &str| json.integer(key).ok().flatten();
    for mesh in document.root.objects("meshes")? {
        for primitive in mesh.objects("primitives").unwrap_or_default() {
            used.extend(number(&primitive, "material"));
            let variants = primitive.extension("KHR_materials_variants").ok().flatten();
            let mappings = variants.and_then(|variants| variants.objects("mappings").ok()).unwrap_or_default();
            used.extend(mappings.iter().filter_map(|mapping| number(mapping, "material")));
        }
    }
    let levels = materials.iter().filter_map(|json| json.extension("MSFT_lod").ok().flatten());
    used.extend(levels.flat_map(|levels| levels.indices("ids", materials.len(), "material").unwrap_or_default()));
    let kept = used.last().map_or(0, |last| last + 1).clamp(KEPT_MATERIALS, materials.len());
    let unused = materials.len() - kept;
    if unused > 0 {
        document.warn("/materials", &format!("{unused} materials at the end are used by nothing; they are left out"));
    }
    Ok(kept)
}

/// The two UV sets that the textures of a material are on; those of the file's first two that it needs keep their place.
fn uv_sets(material: &Json) -> [u32; 2] {
    let named = material.texture_sets();
    let mut others = named.iter().copied().filter(|set| *set > 1);
    [0, 1].map(|slot| if named.contains(&slot) { slot } else { others.next().unwrap_or(slot) })
}

fn read_material(json: &Json, slots: &mut Slots) -> Result<Material, LoadError> {
    let mut material = Material { name: json.name(), ..Material::default() };
    if let Some(pbr) = json.object("pbrMetallicRoughness")? {
        let document = &mut *slots.document;
        material.base_color_factor = Vec4::from(document.clamped(&pbr, "baseColorFactor", [1.0; 4], 1.0)?);
        material.metallic_factor = document.clamped_number(&pbr, "metallicFactor", 1.0, 1.0)?;
        material.roughness_factor = document.clamped_number(&pbr, "roughnessFactor", 1.0, 1.0)?;
        material.base_color_texture = slots.read(&pbr, "baseColorTexture")?;
        material.metallic_roughness_texture = slots.read(&pbr, "metallicRoughnessTexture")?;
    }
    material.normal_texture = slots.read(json, "normalTexture")?;
    if let Some(normal) = json.object("normalTexture")? {
        material.normal_scale = normal.number("scale")?.unwrap_or(1.0);
    }
    material.occlusion_texture = slots.read(json, "occlusionTexture")?;
    if let Some(occlusion) = json.object("occlusionTexture")? {
        material.occlusion_strength = slots.document.clamped_number(&occlusion, "strength", 1.0, 1.0)?;
    }
    material.emissive_texture = slots.read(json, "emissiveTexture")?;
    // Files from before KHR_materials_emissive_strength exceed 1 to glow; only negative light is impossible.
    material.emissive_factor = Vec3::from(slots.document.clamped(json, "emissiveFactor", [0.0; 3], f32::MAX)?);
    if let Some(extension) = json.extension("KHR_materials_emissive_strength")? {
        material.emissive_factor *= slots.document.clamped_number(&extension, "emissiveStrength", 1.0, f32::MAX)?;
        if !material.emissive_factor.is_finite() {
            return Err(extension.error("emissiveStrength", "the emission exceeds what 32 bits hold"));
        }
    }
    if material.emissive_texture.is_none() && json.has("emissiveTexture") {
        // Without the texture that hinders it the factor would shine all over.
        material.emissive_factor = Vec3::ZERO;
    }
    if json.extension("KHR_materials_unlit")?.is_some() {
        material.shading_model = ShadingModel::Unlit;
    }
    let cutoff = slots.document.clamped_number(json, "alphaCutoff", 0.5, f32::MAX)?;
    material.alpha_mode = match json.string("alphaMode")?.unwrap_or("OPAQUE") {
        "OPAQUE" => AlphaMode::Opaque,
        "MASK" => AlphaMode::Mask { cutoff },
        "BLEND" => AlphaMode::Blend,
        other => {
            let message = format!("expected OPAQUE, MASK or BLEND, found {other}; OPAQUE is used");
            slots.document.warn(&json.at("alphaMode"), &message);
            AlphaMode::Opaque
        }
    };
    material.double_sided = json.bool("doubleSided", false)?;
    material.casts_shadow = !json.denies("castShadow");
    layers::read(json, slots, &mut material)?;
    Ok(material)
}
