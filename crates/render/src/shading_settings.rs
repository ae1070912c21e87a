//! Settings of how surfaces reflect the light of lamps.

use crate::setting::{choices, settings};

choices! {
    /// How surfaces reflect the light of lamps.
    pub enum ReflectanceModel {
        /// GGX, as glTF asks.
        #[default]
        Pbr = "pbr",
        /// Phong's lobe around the direction of reflection.
        Phong = "phong",
        /// Blinn's lobe around the half vector.
        BlinnPhong = "blinn-phong",
    }
}

settings! {
    /// Settings of how surfaces reflect light.
    pub struct ShadingSettings {
        /// How surfaces reflect the light of lamps: the physically based model, or for comparison Phong's or
        /// Blinn–Phong's lobe with the exponent of the same roughness (docs/lighting.md). Light from the environment is
        /// the same under all.
        model: ReflectanceModel = ReflectanceModel::Pbr;
    }
}

impl ReflectanceModel {
    /// The `override` constants that shaders take for it.
    pub(crate) fn constants(self) -> Vec<(&'static str, u32)> {
        match self {
            Self::Pbr => Vec::new(),
            Self::Phong => vec![("reflectance_model", 1)],
            Self::BlinnPhong => vec![("reflectance_model", 2)],
        }
    }
}
