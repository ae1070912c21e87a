//! What a pointer of `KHR_animation_pointer` names.

use crate::animation::{CameraProperty, LightProperty, MaterialFactor, Property, TextureSlot, TransformPart};
use crate::material::LayerMap;
use crate::{NodeId, Scene};

/// What a channel of a node may change.
pub(super) const NODE_PATHS: [&str; 4] = ["translation", "rotation", "scale", "weights"];

/// What is animated.
pub(super) enum Target {
    /// A node, by the path that a channel without a pointer would have.
    Node(usize, &'static str),
    /// Anything else.
    Property(Property),
}

const FACTORS: [(&str, MaterialFactor); 29] = [
    ("extensions/KHR_materials_emissive_strength/emissiveStrength", MaterialFactor::EmissiveStrength),
    ("pbrMetallicRoughness/baseColorFactor", MaterialFactor::BaseColor),
    ("pbrMetallicRoughness/metallicFactor", MaterialFactor::Metallic),
    ("pbrMetallicRoughness/roughnessFactor", MaterialFactor::Roughness),
    ("normalTexture/scale", MaterialFactor::NormalScale),
    ("occlusionTexture/strength", MaterialFactor::OcclusionStrength),
    ("emissiveFactor", MaterialFactor::Emissive),
    ("alphaCutoff", MaterialFactor::AlphaCutoff),
    ("extensions/KHR_materials_ior/ior", MaterialFactor::Ior),
    ("extensions/KHR_materials_dispersion/dispersion", MaterialFactor::Dispersion),
    ("extensions/KHR_materials_specular/specularFactor", MaterialFactor::SpecularWeight),
    ("extensions/KHR_materials_specular/specularColorFactor", MaterialFactor::SpecularColor),
    ("extensions/KHR_materials_clearcoat/clearcoatFactor", MaterialFactor::Clearcoat),
    ("extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", MaterialFactor::ClearcoatRoughness),
    ("extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", MaterialFactor::ClearcoatNormalScale),
    ("extensions/KHR_materials_sheen/sheenColorFactor", MaterialFactor::SheenColor),
    ("extensions/KHR_materials_sheen/sheenRoughnessFactor", MaterialFactor::SheenRoughness),
    ("extensions/KHR_materials_anisotropy/anisotropyStrength", MaterialFactor::AnisotropyStrength),
    ("extensions/KHR_materials_anisotropy/anisotropyRotation", MaterialFactor::AnisotropyRotation),
    ("extensions/KHR_materials_iridescence/iridescenceFactor", MaterialFactor::Iridescence),
    ("extensions/KHR_materials_iridescence/iridescenceIor", MaterialFactor::IridescenceIor),
    ("extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", MaterialFactor::IridescenceThicknessMin),
    ("extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", MaterialFactor::IridescenceThicknessMax),
    ("extensions/KHR_materials_transmission/transmissionFactor", MaterialFactor::Transmission),
    ("extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", MaterialFactor::DiffuseTransmission),
    (
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
        MaterialFactor::DiffuseTransmissionColor,
    ),
    ("extensions/KHR_materials_volume/thicknessFactor", MaterialFactor::Thickness),
    ("extensions/KHR_materials_volume/attenuationDistance", MaterialFactor::AttenuationDistance),
    ("extensions/KHR_materials_volume/attenuationColor", MaterialFactor::AttenuationColor),
];

const SLOTS: [(&str, TextureSlot); 19] = [
    ("pbrMetallicRoughness/baseColorTexture", TextureSlot::BaseColor),
    ("pbrMetallicRoughness/metallicRoughnessTexture", TextureSlot::MetallicRoughness),
    ("normalTexture", TextureSlot::Normal),
    ("occlusionTexture", TextureSlot::Occlusion),
    ("emissiveTexture", TextureSlot::Emissive),
    ("extensions/KHR_materials_specular/specularTexture", TextureSlot::Layer(LayerMap::Specular)),
    ("extensions/KHR_materials_specular/specularColorTexture", TextureSlot::Layer(LayerMap::SpecularColor)),
    ("extensions/KHR_materials_clearcoat/clearcoatTexture", TextureSlot::Layer(LayerMap::Clearcoat)),
    ("extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture", TextureSlot::Layer(LayerMap::ClearcoatRoughness)),
    ("extensions/KHR_materials_clearcoat/clearcoatNormalTexture", TextureSlot::Layer(LayerMap::ClearcoatNormal)),
    ("extensions/KHR_materials_sheen/sheenColorTexture", TextureSlot::Layer(LayerMap::SheenColor)),
    ("extensions/KHR_materials_sheen/sheenRoughnessTexture", TextureSlot::Layer(LayerMap::SheenRoughness)),
    ("extensions/KHR_materials_anisotropy/anisotropyTexture", TextureSlot::Layer(LayerMap::Anisotropy)),
    ("extensions/KHR_materials_iridescence/iridescenceTexture", TextureSlot::Layer(LayerMap::Iridescence)),
    (
        "extensions/KHR_materials_iridescence/iridescenceThicknessTexture",
        TextureSlot::Layer(LayerMap::IridescenceThickness),
    ),
    ("extensions/KHR_materials_transmission/transmissionTexture", TextureSlot::Layer(LayerMap::Transmission)),
    (
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionTexture",
        TextureSlot::Layer(LayerMap::DiffuseTransmission),
    ),
    (
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorTexture",
        TextureSlot::Layer(LayerMap::DiffuseTransmissionColor),
    ),
    ("extensions/KHR_materials_volume/thicknessTexture", TextureSlot::Layer(LayerMap::Thickness)),
];

const LIGHTS: [(&str, LightProperty); 5] = [
    ("color", LightProperty::Color),
    ("intensity", LightProperty::Intensity),
    ("range", LightProperty::Range),
    ("spot/innerConeAngle", LightProperty::InnerCone),
    ("spot/outerConeAngle", LightProperty::OuterCone),
];

const CAMERAS: [(&str, CameraProperty); 6] = [
    ("perspective/yfov", CameraProperty::FovY),
    ("perspective/znear", CameraProperty::Near),
    ("perspective/zfar", CameraProperty::Far),
    ("orthographic/ymag", CameraProperty::YMag),
    ("orthographic/znear", CameraProperty::Near),
    ("orthographic/zfar", CameraProperty::Far),
];

fn found<T: Copy>(table: &[(&str, T)], path: &str) -> Option<T> {
    table.iter().find(|(known, _)| *known == path).map(|(_, what)| *what)
}

/// An index below `count`, and the rest of the path behind it.
fn indexed<'p>(pointer: &'p str, array: &str, count: usize) -> Option<(usize, &'p str)> {
    let (index, rest) = pointer.strip_prefix(array)?.split_once('/')?;
    let index = index.parse().ok().filter(|index| *index < count)?;
    Some((index, rest))
}

/// What `pointer` names in `scene`, if that can be animated.
pub(super) fn target(pointer: &str, scene: &Scene) -> Option<Target> {
    if let Some((index, path)) = indexed(pointer, "/nodes/", scene.nodes.len()) {
        if path == "extensions/KHR_node_visibility/visible" {
            return Some(Target::Property(Property::Visible(NodeId(index as u32))));
        }
        return NODE_PATHS.into_iter().find(|known| *known == path).map(|path| Target::Node(index, path));
    }
    if let Some((index, path)) = indexed(pointer, "/materials/", scene.materials.len()) {
        if let Some((slot, part)) = path.split_once("/extensions/KHR_texture_transform/") {
            let part = match part {
                "offset" => TransformPart::Offset,
                "rotation" => TransformPart::Rotation,
                "scale" => TransformPart::Scale,
                _ => return None,
            };
            return Some(Target::Property(Property::TextureTransform(index, found(&SLOTS, slot)?, part)));
        }
        return Some(Target::Property(Property::Material(index, found(&FACTORS, path)?)));
    }
    let lights = "/extensions/KHR_lights_punctual/lights/";
    if let Some((index, path)) = indexed(pointer, lights, scene.lights.len()) {
        return Some(Target::Property(Property::Light(index, found(&LIGHTS, path)?)));
    }
    let (index, path) = indexed(pointer, "/cameras/", scene.cameras.len())?;
    Some(Target::Property(Property::Camera(index, found(&CAMERAS, path)?)))
}
