//! The extensions of materials.

use super::slots::Slots;
use crate::TextureRef;
use crate::gltf_file::error::LoadError;
use crate::gltf_file::json::Json;
use crate::material::{
    Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, LightEncoding, LightMap, Material, Sheen, Specular,
    TexturedFactor, Volume,
};
use glam::{Vec3, Vec4};

impl Slots<'_, '_> {
    /// A number from 0 to 1 and its texture.
    fn share(
        &mut self,
        json: &Json,
        factor: &str,
        texture: &str,
        default: f32,
    ) -> Result<TexturedFactor<f32>, LoadError> {
        let factor = self.document.clamped_number(json, factor, default, 1.0)?;
        Ok(TexturedFactor { factor, texture: self.read(json, texture)? })
    }

    fn color(
        &mut self,
        json: &Json,
        factor: &str,
        texture: &str,
        (default, max): (f32, f32),
    ) -> Result<TexturedFactor<Vec3>, LoadError> {
        let factor = Vec3::from(self.document.clamped(json, factor, [default; 3], max)?);
        Ok(TexturedFactor { factor, texture: self.read(json, texture)? })
    }
}

/// Reads them into `material`. A layer whose factor is 0 is none.
pub(super) fn read(json: &Json, slots: &mut Slots, material: &mut Material) -> Result<(), LoadError> {
    if let Some(ior) = json.extension("KHR_materials_ior")? {
        material.ior = read_ior(&ior, "ior", 1.5, slots)?;
    }
    if let Some(specular) = json.extension("KHR_materials_specular")? {
        material.specular = Some(Specular {
            weight: slots.share(&specular, "specularFactor", "specularTexture", 1.0)?,
            color: slots.color(&specular, "specularColorFactor", "specularColorTexture", (1.0, f32::MAX))?,
            glossiness: None,
        });
    }
    if let Some(coat) = json.extension("KHR_materials_clearcoat")? {
        let weight = slots.share(&coat, "clearcoatFactor", "clearcoatTexture", 0.0)?;
        let roughness = slots.share(&coat, "clearcoatRoughnessFactor", "clearcoatRoughnessTexture", 0.0)?;
        let normal_scale = match coat.object("clearcoatNormalTexture")? {
            Some(normal) => normal.number("scale")?.unwrap_or(1.0),
            None => 1.0,
        };
        let normal_texture = slots.read(&coat, "clearcoatNormalTexture")?;
        let coat = Clearcoat { weight, roughness, normal_texture, normal_scale };
        material.clearcoat = slots.keeps(weight.factor > 0.0).then_some(coat);
    }
    if let Some(sheen) = json.extension("KHR_materials_sheen")? {
        let color = slots.color(&sheen, "sheenColorFactor", "sheenColorTexture", (0.0, 1.0))?;
        let roughness = slots.share(&sheen, "sheenRoughnessFactor", "sheenRoughnessTexture", 0.0)?;
        material.sheen = slots.keeps(color.factor != Vec3::ZERO).then_some(Sheen { color, roughness });
    }
    if let Some(anisotropy) = json.extension("KHR_materials_anisotropy")? {
        let strength = slots.document.clamped_number(&anisotropy, "anisotropyStrength", 0.0, 1.0)?;
        let rotation_rad = anisotropy.number("anisotropyRotation")?.unwrap_or(0.0);
        let texture = slots.read(&anisotropy, "anisotropyTexture")?;
        material.anisotropy = slots.keeps(strength > 0.0).then_some(Anisotropy { strength, rotation_rad, texture });
    }
    if let Some(film) = json.extension("KHR_materials_iridescence")? {
        let defaults = Iridescence::default();
        let weight = slots.share(&film, "iridescenceFactor", "iridescenceTexture", 0.0)?;
        let mut thickness = |key: &str, default| slots.document.clamped_number(&film, key, default, f32::MAX);
        let thickness_min_nm = thickness("iridescenceThicknessMinimum", defaults.thickness_min_nm)?;
        let thickness_max_nm = thickness("iridescenceThicknessMaximum", defaults.thickness_max_nm)?;
        let ior = read_ior(&film, "iridescenceIor", defaults.ior, slots)?.max(1.0);
        let thickness_texture = slots.read(&film, "iridescenceThicknessTexture")?;
        let film = Iridescence { weight, ior, thickness_min_nm, thickness_max_nm, thickness_texture };
        material.iridescence = slots.keeps(weight.factor > 0.0).then_some(film);
    }
    read_transmission(json, slots, material)?;
    if let Some(baked) = json.extension("MOZ_lightmap")? {
        // Hubs, whose extension it is, samples it as it is and on the second UV set.
        let factor = slots.document.clamped_number(&baked, "intensity", 1.0, f32::MAX)?;
        let encoding = baked.extra("encoding").and_then(LightEncoding::named).unwrap_or_default();
        if let Some(texture) = slots.read_info(&baked, 1)? {
            let direction = read_direction(&baked, &texture, slots);
            material.light_map =
                Some(LightMap { light: TexturedFactor { factor, texture: Some(texture) }, encoding, direction });
        }
    }
    if let Some(gloss) = json.extension("KHR_materials_pbrSpecularGlossiness")? {
        read_specular_glossiness(&gloss, slots, material)?;
    }
    Ok(())
}

/// Where the light of a map comes from, on the UV set of `light` unless it says another one. What is wrong with it is told,
/// and the map has no directions then.
fn read_direction(baked: &Json, light: &TextureRef, slots: &mut Slots) -> Option<TextureRef> {
    const EXTENSION: &str = "MANYPASS_light_direction";
    let mut read = || -> Result<Option<TextureRef>, LoadError> {
        let Some(extension) = baked.extension(EXTENSION)? else { return Ok(None) };
        slots.read_info(&extension.require_object("directionTexture")?, slots.uv_set_of(light.uv_set))
    };
    let message = match read() {
        Ok(Some(found)) if (found.uv_set, found.transform) != (light.uv_set, light.transform) => {
            "it lies on another UV set than the light, or is transformed otherwise".to_owned()
        }
        Ok(found) => return found,
        Err(error) => error.into_message(),
    };
    let place = format!("{}/{EXTENSION}/directionTexture", baked.at("extensions"));
    slots.document.warn(&place, &format!("{message}; normal maps do not change baked light"));
    None
}

fn read_transmission(json: &Json, slots: &mut Slots, material: &mut Material) -> Result<(), LoadError> {
    if let Some(transmission) = json.extension("KHR_materials_transmission")? {
        let share = slots.share(&transmission, "transmissionFactor", "transmissionTexture", 0.0)?;
        material.transmission = slots.keeps(share.factor > 0.0).then_some(share);
    }
    if let Some(diffuse) = json.extension("KHR_materials_diffuse_transmission")? {
        let weight = slots.share(&diffuse, "diffuseTransmissionFactor", "diffuseTransmissionTexture", 0.0)?;
        let (factor, texture) = ("diffuseTransmissionColorFactor", "diffuseTransmissionColorTexture");
        let color = slots.color(&diffuse, factor, texture, (1.0, 1.0))?;
        material.diffuse_transmission =
            slots.keeps(weight.factor > 0.0).then_some(DiffuseTransmission { weight, color });
    }
    if let Some(volume) = json.extension("KHR_materials_volume")? {
        let thickness = slots.document.clamped_number(&volume, "thicknessFactor", 0.0, f32::MAX)?;
        let thickness = TexturedFactor { factor: thickness, texture: slots.read(&volume, "thicknessTexture")? };
        let distance = volume.number("attenuationDistance")?.unwrap_or(f32::INFINITY);
        if distance <= 0.0 {
            let message = format!("expected more than 0, found {distance}; nothing is absorbed");
            slots.document.warn(&volume.at("attenuationDistance"), &message);
        }
        let attenuation_distance_m = if distance > 0.0 { distance } else { f32::INFINITY };
        let attenuation_color = Vec3::from(slots.document.clamped(&volume, "attenuationColor", [1.0; 3], 1.0)?);
        let is_there = slots.keeps(thickness.factor > 0.0);
        material.volume = is_there.then_some(Volume { thickness, attenuation_distance_m, attenuation_color });
    }
    if let Some(dispersion) = json.extension("KHR_materials_dispersion")? {
        material.dispersion = slots.document.clamped_number(&dispersion, "dispersion", 0.0, f32::MAX)?;
    }
    Ok(())
}

/// A refractive index: 0, which stands for total reflection, or at least 1.
fn read_ior(json: &Json, key: &str, default: f32, slots: &mut Slots) -> Result<f32, LoadError> {
    let given = json.number(key)?.unwrap_or(default);
    if given == 0.0 || given >= 1.0 {
        return Ok(given);
    }
    slots.document.warn(&json.at(key), &format!("expected 0 or at least 1, found {given}; 1 is used"));
    Ok(1.0)
}

/// The archived model of diffuse and specular colour. It takes the place of metallic-roughness: a dielectric whose
/// reflectance is its specular colour (`KHR_materials_specular` has this conversion), and 1 − roughness its glossiness.
fn read_specular_glossiness(json: &Json, slots: &mut Slots, material: &mut Material) -> Result<(), LoadError> {
    material.base_color_factor = Vec4::from(slots.document.clamped(json, "diffuseFactor", [1.0; 4], 1.0)?);
    material.base_color_texture = slots.read(json, "diffuseTexture")?;
    material.metallic_factor = 0.0;
    material.metallic_roughness_texture = None;
    let glossiness = slots.document.clamped_number(json, "glossinessFactor", 1.0, 1.0)?;
    material.roughness_factor = 1.0 - glossiness;
    material.ior = 0.0;
    let color = slots.color(json, "specularFactor", "specularGlossinessTexture", (1.0, 1.0))?;
    let glossiness = color.texture.is_some().then_some(glossiness);
    material.specular = Some(Specular { weight: TexturedFactor::new(1.0), color, glossiness });
    Ok(())
}
