//! Materials: the metallic-roughness model of glTF 2.0, and the layers of its extensions.

mod detail;
mod layers;
mod texture;

pub use detail::{DetailMaps, HeightMap, HeightMethod, LightEncoding, LightMap};
pub use layers::{
    Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, LayerMap, Sheen, Specular, TexturedFactor, Volume,
};
pub use texture::{TextureRef, TextureTransform};

use crate::Levels;
use glam::{Vec3, Vec4};

/// The alpha mode: opaque, masked or blended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Nothing: the surface is opaque.
    Opaque,
    /// The surface is there where alpha ≥ cutoff.
    Mask {
        /// The smallest alpha that is kept.
        cutoff: f32,
    },
    /// The surface covers what lies behind it in proportion to alpha.
    Blend,
}

/// The shading model of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadingModel {
    /// GGX and diffuse, lit.
    Standard,
    /// The base colour as it is (`KHR_materials_unlit`).
    Unlit,
}

/// A surface. All factors are linear; textures multiply them.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the file; empty if it has none.
    pub name: String,
    /// How light is turned into radiance.
    pub shading_model: ShadingModel,
    /// Base colour (linear Rec. 709) and alpha.
    pub base_color_factor: Vec4,
    /// sRGB colour and linear alpha.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric, 1 metal.
    pub metallic_factor: f32,
    /// Perceptual roughness, 0 to 1.
    pub roughness_factor: f32,
    /// Roughness in green, metallic in blue, linear.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normals, +Y up.
    pub normal_texture: Option<TextureRef>,
    /// Scales x and y of the normal texture.
    pub normal_scale: f32,
    /// Whether green of all its normal maps points down, as DirectX has it; glTF and OpenGL have it up.
    pub has_normals_down: bool,
    /// Occlusion in red, linear.
    pub occlusion_texture: Option<TextureRef>,
    /// 0: no occlusion; 1: the texture in full.
    pub occlusion_strength: f32,
    /// Linear colour times `KHR_materials_emissive_strength`; may exceed 1.
    pub emissive_factor: Vec3,
    /// sRGB.
    pub emissive_texture: Option<TextureRef>,
    /// What alpha means.
    pub alpha_mode: AlphaMode,
    /// Whether back faces are drawn, with their normal turned.
    pub double_sided: bool,
    /// Whether its surfaces keep light from what lies behind them.
    pub casts_shadow: bool,
    /// The refractive index of what is not metal (`KHR_materials_ior`), at least 1; or 0, of which all light is
    /// reflected as [`Specular::color`] says.
    pub ior: f32,
    /// Reflection that is not as the refractive index alone makes it.
    pub specular: Option<Specular>,
    /// A clear layer over all else.
    pub clearcoat: Option<Clearcoat>,
    /// The soft light of fibres, over all but the clear layer.
    pub sheen: Option<Sheen>,
    /// Highlights that are stretched.
    pub anisotropy: Option<Anisotropy>,
    /// A thin film on the surface.
    pub iridescence: Option<Iridescence>,
    /// How much of the light that enters a dielectric comes through, 0 to 1; the texture's red
    /// (`KHR_materials_transmission`).
    pub transmission: Option<TexturedFactor<f32>>,
    /// Light that comes through and is scattered.
    pub diffuse_transmission: Option<DiffuseTransmission>,
    /// What light goes through below the surface; without it the surface is a thin wall.
    pub volume: Option<Volume>,
    /// How far colours are refracted apart: 20 divided by the Abbe number (`KHR_materials_dispersion`).
    pub dispersion: f32,
    /// What takes its place where a surface is seen small: indices into [`crate::Scene::materials`].
    pub levels: Option<Levels<usize>>,
    /// Heights below the triangles.
    pub height: Option<HeightMap>,
    /// Finer maps over the others.
    pub detail: Option<DetailMaps>,
    /// Light that was computed beforehand (`MOZ_lightmap`).
    pub light_map: Option<LightMap>,
}

impl Material {
    /// The UV set along which the tangents of its surfaces lie, if it needs any.
    pub fn tangent_uv_set(&self) -> Option<u32> {
        let of_coat = self.clearcoat.and_then(|coat| coat.normal_texture);
        let of_anisotropy = self.anisotropy.map(|anisotropy| anisotropy.texture.map_or(0, |texture| texture.uv_set));
        self.normal_texture.or(of_coat).map(|texture| texture.uv_set).or(of_anisotropy)
    }
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            shading_model: ShadingModel::Standard,
            base_color_factor: Vec4::ONE,
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            has_normals_down: false,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive_factor: Vec3::ZERO,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            casts_shadow: true,
            ior: 1.5,
            specular: None,
            clearcoat: None,
            sheen: None,
            anisotropy: None,
            iridescence: None,
            transmission: None,
            diffuse_transmission: None,
            volume: None,
            dispersion: 0.0,
            levels: None,
            height: None,
            detail: None,
            light_map: None,
        }
    }
}

impl Material {
    /// The texture at a place of its layers.
    pub fn layer_texture(&self, map: LayerMap) -> Option<TextureRef> {
        match map {
            LayerMap::Specular => self.specular?.weight.texture,
            LayerMap::SpecularColor => self.specular?.color.texture,
            LayerMap::Clearcoat => self.clearcoat?.weight.texture,
            LayerMap::ClearcoatRoughness => self.clearcoat?.roughness.texture,
            LayerMap::ClearcoatNormal => self.clearcoat?.normal_texture,
            LayerMap::SheenColor => self.sheen?.color.texture,
            LayerMap::SheenRoughness => self.sheen?.roughness.texture,
            LayerMap::Anisotropy => self.anisotropy?.texture,
            LayerMap::Iridescence => self.iridescence?.weight.texture,
            LayerMap::IridescenceThickness => self.iridescence?.thickness_texture,
            LayerMap::Transmission => self.transmission?.texture,
            LayerMap::Thickness => self.volume?.thickness.texture,
            LayerMap::DiffuseTransmission => self.diffuse_transmission?.weight.texture,
            LayerMap::DiffuseTransmissionColor => self.diffuse_transmission?.color.texture,
            LayerMap::Height => Some(self.height?.texture),
            LayerMap::DetailNormal => self.detail?.normal_texture,
            LayerMap::DetailColor => self.detail?.base_color_texture,
        }
    }
}
