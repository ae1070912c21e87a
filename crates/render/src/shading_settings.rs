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
        /// The exponent of Phong's and of Blinn–Phong's lobe: the larger, the smaller and brighter the highlight. 0 takes
        /// that of the surface's roughness.
        shininess: u32 = 0, in 0..=10_000, unit "exponent";
        /// What Phong's and Blinn–Phong's lobe is multiplied by; 0 leaves diffuse light alone.
        specular_strength: f32 = 1.0, in 0.0..=16.0, unit "factor";
        /// The share of what surfaces mirror of the environment and of each other that is shown; what it lacks of 1 is
        /// diffuse light instead. Materials with layers mirror all.
        reflectivity: f32 = 1.0, in 0.0..=1.0, unit "share";
    }
}

impl ShadingSettings {
    /// The `override` constants that shaders take for them.
    pub(crate) fn constants(&self) -> Vec<(&'static str, u32)> {
        let model = match self.model {
            ReflectanceModel::Pbr => 0,
            ReflectanceModel::Phong => 1,
            ReflectanceModel::BlinnPhong => 2,
        };
        let mut constants = Vec::new();
        if model > 0 {
            constants.extend([("reflectance_model", model), ("shininess", self.shininess)]);
            constants.push(("lobe_lost", (1.0 - self.specular_strength).to_bits()));
        }
        if self.reflectivity < 1.0 {
            constants.push(("mirrored_lost", (1.0 - self.reflectivity).to_bits()));
        }
        constants
    }
}
