//! What a triangle is made of at a place: glTF 2.0's metallic-roughness model with its textures.

use super::Surface;
use super::textures::{Images, Texture};
use glam::{DVec2, DVec3, DVec4};
use manypass_scene::{AlphaMode, Scene, ShadingModel};

/// A material of a scene.
#[derive(Clone, Debug)]
pub(super) struct Material {
    base_color: DVec4,
    base_color_texture: Option<Texture>,
    metallic: f64,
    roughness: f64,
    metallic_roughness_texture: Option<Texture>,
    emission: DVec3,
    emission_texture: Option<Texture>,
    normal_texture: Option<Texture>,
    normal_scale: f64,
    alpha_mode: AlphaMode,
    is_unlit: bool,
    /// Whether back faces are seen, with their normal turned.
    pub is_double_sided: bool,
    /// Whether it keeps light off.
    pub casts_shadow: bool,
}

/// Attributes of a triangle at a place. Normal and tangent need not have length 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attributes {
    pub normal_world: DVec3,
    /// xyz, and in w the sign of the bitangent.
    pub tangent_world: DVec4,
    pub uvs: [DVec2; 2],
    pub color: DVec4,
}

impl Material {
    pub fn new(scene: &Scene, material: &manypass_scene::Material, images: &mut Images) -> Self {
        let mut texture = |used, is_srgb| images.texture(scene, used, is_srgb);
        Self {
            base_color: material.base_color_factor.as_dvec4(),
            base_color_texture: texture(material.base_color_texture, true),
            metallic: material.metallic_factor.into(),
            roughness: material.roughness_factor.into(),
            metallic_roughness_texture: texture(material.metallic_roughness_texture, false),
            emission: material.emissive_factor.as_dvec3(),
            emission_texture: texture(material.emissive_texture, true),
            normal_texture: texture(material.normal_texture, false),
            normal_scale: material.normal_scale.into(),
            alpha_mode: material.alpha_mode,
            is_unlit: material.shading_model == ShadingModel::Unlit,
            is_double_sided: material.double_sided,
            casts_shadow: material.casts_shadow,
        }
    }

    /// Whether any of it glows.
    pub fn emits(&self) -> bool {
        self.emission != DVec3::ZERO
    }

    /// The roughness that all of it has; none where a texture says.
    pub fn constant_roughness(&self) -> Option<f64> {
        self.metallic_roughness_texture.is_none().then(|| self.roughness.clamp(0.0, 1.0))
    }

    fn base_color(&self, attributes: &Attributes) -> DVec4 {
        let texel = self.base_color_texture.as_ref().map_or(DVec4::ONE, |texture| texture.at(&attributes.uvs));
        self.base_color * attributes.color * texel
    }

    /// How much of what lies behind is covered: 1 of opaque and 0 of cut-out surfaces.
    pub fn coverage(&self, attributes: &Attributes) -> f64 {
        match self.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask { cutoff } => f64::from(self.base_color(attributes).w >= f64::from(cutoff)),
            AlphaMode::Blend => self.base_color(attributes).w.clamp(0.0, 1.0),
        }
    }

    /// Whether it covers in part.
    pub fn is_blended(&self) -> bool {
        self.alpha_mode == AlphaMode::Blend
    }

    /// Whether coverage is 1 wherever it is.
    pub fn is_opaque(&self) -> bool {
        self.alpha_mode == AlphaMode::Opaque
    }

    /// The surface, and whether light makes any difference to it.
    pub fn surface(&self, attributes: &Attributes) -> (Surface, bool) {
        let base_color = self.base_color(attributes).truncate();
        let texel = |texture: &Option<Texture>| texture.as_ref().map_or(DVec4::ONE, |found| found.at(&attributes.uvs));
        let metallic_roughness = texel(&self.metallic_roughness_texture);
        let emission = match self.is_unlit {
            true => base_color,
            false => self.emission * texel(&self.emission_texture).truncate(),
        };
        let surface = Surface {
            base_color: base_color.clamp(DVec3::ZERO, DVec3::ONE),
            metallic: (self.metallic * metallic_roughness.z).clamp(0.0, 1.0),
            roughness_perceptual: (self.roughness * metallic_roughness.y).clamp(0.0, 1.0),
            emission,
        };
        (surface, !self.is_unlit)
    }

    /// The unit normal for shading on the front of the triangle, whose own unit normal is `normal_of_triangle`.
    pub fn shading_normal(&self, attributes: &Attributes, normal_of_triangle: DVec3) -> DVec3 {
        let normal = attributes.normal_world.normalize_or(normal_of_triangle);
        let Some(texture) = &self.normal_texture else { return normal };
        let texel = texture.at(&attributes.uvs).truncate() * 2.0 - 1.0;
        let tangent = attributes.tangent_world.truncate();
        let bitangent = normal.cross(tangent) * attributes.tangent_world.w;
        let bent = (tangent * texel.x + bitangent * texel.y) * self.normal_scale + normal * texel.z;
        bent.normalize_or(normal)
    }
}
