//! The textures that a material names.

use crate::gltf_file::document::Document;
use crate::gltf_file::error::LoadError;
use crate::gltf_file::json::Json;
use crate::{TextureRef, TextureTransform};
use glam::Vec2;

/// Reads the textures of a material.
pub(super) struct Slots<'d, 'a> {
    pub(super) document: &'d mut Document<'a>,
    pub(super) has_image: Vec<bool>,
    /// The UV sets of the file that vertices have for the material that is read.
    pub(super) uv_sets: [u32; 2],
    /// Whether the layers of the material that is read may be animated: then those count that have no weight yet.
    pub(super) is_animated: bool,
}

impl Slots<'_, '_> {
    /// Whether a layer is read that counts as it stands, or does not.
    pub(super) fn keeps(&self, counts: bool) -> bool {
        counts || self.is_animated
    }

    /// The UV set of the file that is one of vertices.
    pub(super) fn uv_set_of(&self, slot: u32) -> usize {
        self.uv_sets.get(slot as usize).map_or(0, |set| *set as usize)
    }

    pub(super) fn read(&mut self, json: &Json, key: &str) -> Result<Option<TextureRef>, LoadError> {
        let Some(info) = json.object(key)? else { return Ok(None) };
        self.read_info(&info, 0)
    }

    /// A texture by its index, on the UV set `uv_set` unless it says another one.
    pub(super) fn read_info(&mut self, info: &Json, uv_set: usize) -> Result<Option<TextureRef>, LoadError> {
        let texture = info.index("index", self.has_image.len(), "texture")?;
        let texture = texture.ok_or_else(|| info.error("index", "expected the index of a texture"))?;
        let mut uv_set = info.integer("texCoord")?.unwrap_or(uv_set);
        let mut transform = TextureTransform::default();
        if let Some(extension) = info.extension("KHR_texture_transform")? {
            uv_set = extension.integer("texCoord")?.unwrap_or(uv_set);
            transform = TextureTransform {
                offset: Vec2::from(extension.numbers("offset")?.unwrap_or([0.0; 2])),
                rotation_rad: extension.number("rotation")?.unwrap_or(0.0),
                scale: Vec2::from(extension.numbers("scale")?.unwrap_or([1.0; 2])),
            };
        }
        let slot = self.uv_sets.iter().position(|set| *set as usize == uv_set);
        if slot.is_none() {
            let [first, second] = self.uv_sets;
            let message = format!("a material has two UV sets, here {first} and {second}; set {first} is used");
            self.document.warn(&info.at("texCoord"), &message);
        }
        let uv_set = slot.unwrap_or(0);
        let has_image = self.has_image.get(texture).copied().unwrap_or(false);
        Ok(has_image.then_some(TextureRef { texture, uv_set: uv_set as u32, transform }))
    }
}
