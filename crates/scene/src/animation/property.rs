//! What is animated beside nodes: factors of materials, where their textures lie, lights, cameras, whether a node is
//! shown (`KHR_animation_pointer`).

use super::{Interpolation, sample_weights, span};
use crate::material::{LayerMap, TextureRef, TexturedFactor};
use crate::{AlphaMode, LightKind, Material, NodeId, Projection, Scene};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// A factor of a material, as [`Material`] and its layers have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are those of the fields")]
pub enum MaterialFactor {
    BaseColor,
    Metallic,
    Roughness,
    NormalScale,
    OcclusionStrength,
    /// Its colour times its strength, or without it where [`Self::EmissiveStrength`] is animated as well.
    Emissive,
    /// What multiplies [`Self::Emissive`] of the same animation; nothing without that.
    EmissiveStrength,
    /// Of [`AlphaMode::Mask`].
    AlphaCutoff,
    Ior,
    Dispersion,
    SpecularWeight,
    SpecularColor,
    Clearcoat,
    ClearcoatRoughness,
    ClearcoatNormalScale,
    SheenColor,
    SheenRoughness,
    AnisotropyStrength,
    AnisotropyRotation,
    Iridescence,
    IridescenceIor,
    IridescenceThicknessMin,
    IridescenceThicknessMax,
    Transmission,
    DiffuseTransmission,
    DiffuseTransmissionColor,
    Thickness,
    AttenuationDistance,
    AttenuationColor,
}

/// A place of a material where a texture may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are those of the fields")]
pub enum TextureSlot {
    BaseColor,
    MetallicRoughness,
    Normal,
    Occlusion,
    Emissive,
    Layer(LayerMap),
}

/// A part of [`crate::TextureTransform`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are those of the fields")]
pub enum TransformPart {
    Offset,
    Rotation,
    Scale,
}

/// A number of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are those of the fields")]
pub enum LightProperty {
    Color,
    Intensity,
    Range,
    InnerCone,
    OuterCone,
}

/// A number of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are those of the fields")]
pub enum CameraProperty {
    FovY,
    /// Half of the height, as files have it.
    YMag,
    Near,
    Far,
}

/// Something that is animated, and not by a node's transform or weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Property {
    /// A factor of a material.
    Material(usize, MaterialFactor),
    /// Where a texture of a material lies.
    TextureTransform(usize, TextureSlot, TransformPart),
    /// A number of a light.
    Light(usize, LightProperty),
    /// A number of a camera.
    Camera(usize, CameraProperty),
    /// Whether a node is shown: not 0.
    Visible(NodeId),
}

/// One animated property.
#[derive(Clone, Debug, PartialEq)]
pub struct PropertyChannel {
    /// What changes.
    pub property: Property,
    /// The times of the keyframes in seconds, ascending.
    pub times_secs: Vec<f32>,
    /// What happens between keyframes.
    pub interpolation: Interpolation,
    /// The values: [`Property::components`] a keyframe, or three times as many with [`Interpolation::CubicSpline`].
    pub values: Vec<f32>,
}

impl MaterialFactor {
    fn components(self) -> usize {
        match self {
            Self::BaseColor => 4,
            Self::Emissive
            | Self::SpecularColor
            | Self::SheenColor
            | Self::DiffuseTransmissionColor
            | Self::AttenuationColor => 3,
            _ => 1,
        }
    }

    /// Sets it, within its range. A layer that is not there is made.
    fn set(self, material: &mut Material, values: Vec4) {
        let x = values.x;
        let share = x.clamp(0.0, 1.0);
        let color = values.truncate().max(Vec3::ZERO);
        let ior = if x <= 0.0 { 0.0 } else { x.max(1.0) };
        let m = material;
        match self {
            Self::BaseColor => m.base_color_factor = values.clamp(Vec4::ZERO, Vec4::ONE),
            Self::Metallic => m.metallic_factor = share,
            Self::Roughness => m.roughness_factor = share,
            Self::NormalScale => m.normal_scale = x,
            Self::OcclusionStrength => m.occlusion_strength = share,
            Self::Emissive => m.emissive_factor = color,
            Self::EmissiveStrength => {}
            Self::AlphaCutoff => {
                if let AlphaMode::Mask { cutoff } = &mut m.alpha_mode {
                    *cutoff = x.max(0.0);
                }
            }
            Self::Ior => m.ior = ior,
            Self::Dispersion => m.dispersion = x.max(0.0),
            Self::SpecularWeight => m.specular.get_or_insert_default().weight.factor = share,
            Self::SpecularColor => m.specular.get_or_insert_default().color.factor = color,
            Self::Clearcoat => m.clearcoat.get_or_insert_default().weight.factor = share,
            Self::ClearcoatRoughness => m.clearcoat.get_or_insert_default().roughness.factor = share,
            Self::ClearcoatNormalScale => m.clearcoat.get_or_insert_default().normal_scale = x,
            Self::SheenColor => m.sheen.get_or_insert_default().color.factor = color.min(Vec3::ONE),
            Self::SheenRoughness => m.sheen.get_or_insert_default().roughness.factor = share,
            Self::AnisotropyStrength => m.anisotropy.get_or_insert_default().strength = share,
            Self::AnisotropyRotation => m.anisotropy.get_or_insert_default().rotation_rad = x,
            Self::Iridescence => m.iridescence.get_or_insert_default().weight.factor = share,
            Self::IridescenceIor => m.iridescence.get_or_insert_default().ior = x.max(1.0),
            Self::IridescenceThicknessMin => m.iridescence.get_or_insert_default().thickness_min_nm = x.max(0.0),
            Self::IridescenceThicknessMax => m.iridescence.get_or_insert_default().thickness_max_nm = x.max(0.0),
            Self::Transmission => m.transmission.get_or_insert_default().factor = share,
            Self::DiffuseTransmission => m.diffuse_transmission.get_or_insert_default().weight.factor = share,
            Self::DiffuseTransmissionColor => {
                m.diffuse_transmission.get_or_insert_default().color.factor = color.min(Vec3::ONE);
            }
            Self::Thickness => m.volume.get_or_insert_default().thickness.factor = x.max(0.0),
            Self::AttenuationDistance => {
                m.volume.get_or_insert_default().attenuation_distance_m = if x > 0.0 { x } else { f32::INFINITY };
            }
            Self::AttenuationColor => m.volume.get_or_insert_default().attenuation_color = color.min(Vec3::ONE),
        }
    }
}

impl TextureSlot {
    fn texture(self, material: &mut Material) -> Option<&mut TextureRef> {
        fn of<T>(mapped: &mut TexturedFactor<T>) -> Option<&mut TextureRef> {
            mapped.texture.as_mut()
        }
        match self {
            Self::BaseColor => material.base_color_texture.as_mut(),
            Self::MetallicRoughness => material.metallic_roughness_texture.as_mut(),
            Self::Normal => material.normal_texture.as_mut(),
            Self::Occlusion => material.occlusion_texture.as_mut(),
            Self::Emissive => material.emissive_texture.as_mut(),
            Self::Layer(map) => match map {
                LayerMap::Specular => of(&mut material.specular.as_mut()?.weight),
                LayerMap::SpecularColor => of(&mut material.specular.as_mut()?.color),
                LayerMap::Clearcoat => of(&mut material.clearcoat.as_mut()?.weight),
                LayerMap::ClearcoatRoughness => of(&mut material.clearcoat.as_mut()?.roughness),
                LayerMap::ClearcoatNormal => material.clearcoat.as_mut()?.normal_texture.as_mut(),
                LayerMap::SheenColor => of(&mut material.sheen.as_mut()?.color),
                LayerMap::SheenRoughness => of(&mut material.sheen.as_mut()?.roughness),
                LayerMap::Anisotropy => material.anisotropy.as_mut()?.texture.as_mut(),
                LayerMap::Iridescence => of(&mut material.iridescence.as_mut()?.weight),
                LayerMap::IridescenceThickness => material.iridescence.as_mut()?.thickness_texture.as_mut(),
                LayerMap::Transmission => of(material.transmission.as_mut()?),
                LayerMap::Thickness => of(&mut material.volume.as_mut()?.thickness),
                LayerMap::DiffuseTransmission => of(&mut material.diffuse_transmission.as_mut()?.weight),
                LayerMap::DiffuseTransmissionColor => of(&mut material.diffuse_transmission.as_mut()?.color),
                // No file has them.
                LayerMap::Height | LayerMap::DetailNormal | LayerMap::DetailColor => None,
            },
        }
    }
}

impl Property {
    /// How many numbers a keyframe has.
    pub fn components(self) -> usize {
        match self {
            Self::Material(_, factor) => factor.components(),
            Self::TextureTransform(_, _, part) => 1 + usize::from(part != TransformPart::Rotation),
            Self::Light(_, LightProperty::Color) => 3,
            Self::Light(..) | Self::Camera(..) | Self::Visible(_) => 1,
        }
    }

    /// The material whose emission it multiplies, and by how much.
    fn strength(self, value: f32) -> Option<(usize, f32)> {
        match self {
            Self::Material(material, MaterialFactor::EmissiveStrength) => Some((material, value.max(0.0))),
            _ => None,
        }
    }

    /// Sets it in a scene; values that are not used are 0.
    fn set(self, scene: &mut Scene, values: Vec4) {
        match self {
            Self::Material(index, factor) => {
                if let Some(material) = scene.materials.get_mut(index) {
                    factor.set(material, values);
                }
            }
            Self::TextureTransform(index, slot, part) => {
                let texture = scene.materials.get_mut(index).and_then(|material| slot.texture(material));
                let Some(TextureRef { transform, .. }) = texture else { return };
                match part {
                    TransformPart::Offset => transform.offset = Vec2::new(values.x, values.y),
                    TransformPart::Rotation => transform.rotation_rad = values.x,
                    TransformPart::Scale => transform.scale = Vec2::new(values.x, values.y),
                }
            }
            Self::Light(index, property) => {
                let Some(light) = scene.lights.get_mut(index) else { return };
                match (property, &mut light.kind) {
                    (LightProperty::Color, _) => light.color_linear = values.truncate().max(Vec3::ZERO),
                    (LightProperty::Intensity, _) => light.intensity = values.x.max(0.0),
                    (LightProperty::Range, _) => light.range_m = (values.x > 0.0).then_some(values.x),
                    (LightProperty::InnerCone, LightKind::Spot { inner_cone_rad, .. }) => *inner_cone_rad = values.x,
                    (LightProperty::OuterCone, LightKind::Spot { outer_cone_rad, .. }) => *outer_cone_rad = values.x,
                    _ => {}
                }
                if let LightKind::Spot { inner_cone_rad, outer_cone_rad } = &mut light.kind {
                    *outer_cone_rad = outer_cone_rad.clamp(crate::light::CONE_MIN_RAD, std::f32::consts::FRAC_PI_2);
                    *inner_cone_rad = inner_cone_rad.clamp(0.0, *outer_cone_rad);
                }
            }
            Self::Camera(index, property) => {
                let Some(camera) = scene.cameras.get_mut(index) else { return };
                // What would be no projection is left as it is.
                if values.x <= 0.0 {
                    return;
                }
                match (property, &mut camera.projection) {
                    (CameraProperty::FovY, Projection::Perspective { fov_y_rad, .. }) if values.x < 3.1 => {
                        *fov_y_rad = values.x;
                    }
                    (CameraProperty::Near, Projection::Perspective { near_m, far_m, .. })
                        if far_m.is_none_or(|far_m| values.x < far_m) =>
                    {
                        *near_m = values.x;
                    }
                    (CameraProperty::Far, Projection::Perspective { near_m, far_m, .. }) if values.x > *near_m => {
                        *far_m = Some(values.x);
                    }
                    (CameraProperty::YMag, Projection::Orthographic { height_m, .. }) => {
                        // The width stays.
                        let aspect = &mut camera.aspect;
                        *aspect = aspect.map(|aspect| aspect * *height_m / (2.0 * values.x));
                        *height_m = 2.0 * values.x;
                    }
                    (CameraProperty::Near, Projection::Orthographic { near_m, far_m, .. }) if values.x < *far_m => {
                        *near_m = values.x;
                    }
                    (CameraProperty::Far, Projection::Orthographic { near_m, far_m, .. }) if values.x > *near_m => {
                        *far_m = values.x;
                    }
                    _ => {}
                }
            }
            Self::Visible(id) => {
                if let Some(node) = scene.nodes.get_mut(id.0 as usize) {
                    node.is_visible = values.x != 0.0;
                }
            }
        }
    }
}

impl Scene {
    /// Sets the animated properties that are none of [`super::Channel`]'s to their values at a time.
    pub(super) fn pose_properties(&mut self, animation: usize, time_secs: f32) {
        let mut set: Vec<(Property, Vec4)> = self
            .animations
            .get(animation)
            .into_iter()
            .flat_map(|animation| &animation.properties)
            .filter_map(|channel| {
                let span = span(&channel.times_secs, time_secs)?;
                let count = channel.property.components();
                let sampled = sample_weights(&channel.values, count, channel.interpolation, &span)?;
                // Splines of huge numbers may be none.
                if !sampled.iter().all(|value| value.is_finite()) {
                    return None;
                }
                let mut values = [0.0; 4];
                values.iter_mut().zip(sampled).for_each(|(value, sampled)| *value = sampled);
                Some((channel.property, Vec4::from(values)))
            })
            .collect();
        // Of two that are animated at once the first counts.
        let strengths: HashMap<usize, f32> =
            set.iter().rev().filter_map(|(property, values)| property.strength(values.x)).collect();
        for (property, values) in &mut set {
            if let Property::Material(material, MaterialFactor::Emissive) = *property {
                *values *= strengths.get(&material).copied().unwrap_or(1.0);
            }
        }
        set.into_iter().for_each(|(property, values)| property.set(self, values));
    }
}
