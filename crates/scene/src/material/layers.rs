//! What materials have beyond metallic-roughness: the layers and the transmission of glTF's ratified extensions.

use super::texture::TextureRef;
use glam::Vec3;

/// A factor, and the texture that multiplies it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexturedFactor<T> {
    /// Linear.
    pub factor: T,
    /// Which of its channels counts is said where it is used.
    pub texture: Option<TextureRef>,
}

impl<T> TexturedFactor<T> {
    /// A factor without a texture.
    pub const fn new(factor: T) -> Self {
        Self { factor, texture: None }
    }
}

/// How strongly and in what colour a dielectric reflects (`KHR_materials_specular`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specular {
    /// Multiplies all specular reflection of the dielectric, at grazing angles, too; the texture's alpha.
    pub weight: TexturedFactor<f32>,
    /// Multiplies its reflection at normal incidence, which ends at 1; sRGB texture.
    pub color: TexturedFactor<Vec3>,
    /// If there is one, this times the alpha of the colour's texture is 1 − roughness, in place of all else that says
    /// how rough the surface is. Materials of `KHR_materials_pbrSpecularGlossiness` are read so.
    pub glossiness: Option<f32>,
}

impl Default for Specular {
    fn default() -> Self {
        Self { weight: TexturedFactor::new(1.0), color: TexturedFactor::new(Vec3::ONE), glossiness: None }
    }
}

/// A clear layer over all else, with the refractive index 1.5 (`KHR_materials_clearcoat`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearcoat {
    /// How much of the surface it covers, 0 to 1; the texture's red.
    pub weight: TexturedFactor<f32>,
    /// Its perceptual roughness; the texture's green.
    pub roughness: TexturedFactor<f32>,
    /// Its own tangent-space normals. Without them it is as smooth as the mesh, whatever the normals below it are.
    pub normal_texture: Option<TextureRef>,
    /// Scales x and y of its normal texture.
    pub normal_scale: f32,
}

impl Default for Clearcoat {
    fn default() -> Self {
        Self {
            weight: TexturedFactor::new(0.0),
            roughness: TexturedFactor::new(0.0),
            normal_texture: None,
            normal_scale: 1.0,
        }
    }
}

/// The soft light of fibres (`KHR_materials_sheen`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sheen {
    /// Its colour; sRGB texture.
    pub color: TexturedFactor<Vec3>,
    /// Its perceptual roughness; the texture's alpha.
    pub roughness: TexturedFactor<f32>,
}

/// Highlights that are stretched (`KHR_materials_anisotropy`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// From 0 to 1.
    pub strength: f32,
    /// Where along, counter-clockwise from the tangent, in radians.
    pub rotation_rad: f32,
    /// The direction in red and green, from −1 to 1, and the strength in blue.
    pub texture: Option<TextureRef>,
}

/// A thin film whose interference colours reflections (`KHR_materials_iridescence`; Belcour & Barla 2017).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iridescence {
    /// How much of the surface it covers, 0 to 1; the texture's red.
    pub weight: TexturedFactor<f32>,
    /// The refractive index of the film.
    pub ior: f32,
    /// How thick the film is where the texture's green is 0, in nanometres.
    pub thickness_min_nm: f32,
    /// How thick it is where that is 1, or without a texture, in nanometres.
    pub thickness_max_nm: f32,
    /// Linear.
    pub thickness_texture: Option<TextureRef>,
}

impl Default for Iridescence {
    fn default() -> Self {
        Self {
            weight: TexturedFactor::new(0.0),
            ior: 1.3,
            thickness_min_nm: 100.0,
            thickness_max_nm: 400.0,
            thickness_texture: None,
        }
    }
}

/// Light that comes through and is scattered in all directions (`KHR_materials_diffuse_transmission`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    /// How much of what is not reflected specularly comes through, 0 to 1; the texture's alpha.
    pub weight: TexturedFactor<f32>,
    /// What it is multiplied by; sRGB texture.
    pub color: TexturedFactor<Vec3>,
}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        Self { weight: TexturedFactor::new(0.0), color: TexturedFactor::new(Vec3::ONE) }
    }
}

/// What lies below a surface that light comes through (`KHR_materials_volume`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// How thick it is below the surface, in metres of the mesh's own space; the texture's green. At 0 the surface is a
    /// thin wall, which does not refract.
    pub thickness: TexturedFactor<f32>,
    /// After so many metres light has become [`Self::attenuation_color`]; infinite if nothing is absorbed.
    pub attenuation_distance_m: f32,
    /// What is left of white light then.
    pub attenuation_color: Vec3,
}

impl Default for Volume {
    fn default() -> Self {
        Self {
            thickness: TexturedFactor::new(0.0),
            attenuation_distance_m: f32::INFINITY,
            attenuation_color: Vec3::ONE,
        }
    }
}

/// A texture slot of a material's layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LayerMap {
    /// Alpha of [`Specular::weight`].
    Specular,
    /// Colour of [`Specular::color`].
    SpecularColor,
    /// Red of [`Clearcoat::weight`].
    Clearcoat,
    /// Green of [`Clearcoat::roughness`].
    ClearcoatRoughness,
    /// [`Clearcoat::normal_texture`].
    ClearcoatNormal,
    /// Colour of [`Sheen::color`].
    SheenColor,
    /// Alpha of [`Sheen::roughness`].
    SheenRoughness,
    /// [`Anisotropy::texture`].
    Anisotropy,
    /// Red of [`Iridescence::weight`].
    Iridescence,
    /// Green of [`Iridescence::thickness_texture`].
    IridescenceThickness,
    /// Red of [`crate::Material::transmission`].
    Transmission,
    /// Green of [`Volume::thickness`].
    Thickness,
    /// Alpha of [`DiffuseTransmission::weight`].
    DiffuseTransmission,
    /// Colour of [`DiffuseTransmission::color`].
    DiffuseTransmissionColor,
    /// [`super::HeightMap::texture`].
    Height,
    /// [`super::DetailMaps::normal_texture`].
    DetailNormal,
    /// [`super::DetailMaps::base_color_texture`].
    DetailColor,
}

impl LayerMap {
    /// All, in the order of `layers.wgsl`.
    pub const ALL: [Self; 17] = [
        Self::Specular,
        Self::SpecularColor,
        Self::Clearcoat,
        Self::ClearcoatRoughness,
        Self::ClearcoatNormal,
        Self::SheenColor,
        Self::SheenRoughness,
        Self::Anisotropy,
        Self::Iridescence,
        Self::IridescenceThickness,
        Self::Transmission,
        Self::Thickness,
        Self::DiffuseTransmission,
        Self::DiffuseTransmissionColor,
        Self::Height,
        Self::DetailNormal,
        Self::DetailColor,
    ];

    /// Whether its texels are sRGB colours.
    pub const fn is_srgb(self) -> bool {
        matches!(self, Self::SpecularColor | Self::SheenColor | Self::DiffuseTransmissionColor | Self::DetailColor)
    }
}
