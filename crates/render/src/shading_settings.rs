//! Settings of how surfaces reflect light.

use crate::setting::{choices, settings};

choices! {
    /// The specular model for lamps.
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
        /// The specular model for lamps: GGX (`pbr`), or for comparison the lobe of Phong or Blinn–Phong. Their
        /// exponent follows from the roughness (docs/lighting.md). Light from the environment is the same for all
        /// models.
        model: ReflectanceModel = ReflectanceModel::Pbr;
        /// The exponent of the Phong and Blinn–Phong lobes: the larger, the smaller and brighter the highlight. 0 takes
        /// that of the surface's roughness.
        shininess: u32 = 0, in 0..=10_000, unit "exponent";
        /// Multiplies the Phong and Blinn–Phong lobes; 0 leaves only diffuse light.
        specular_strength: f32 = 1.0, in 0.0..=16.0, unit "factor";
        /// The share of specular reflections that is shown, of the environment and of other surfaces. The rest is
        /// diffuse light. Materials with layers show all reflections.
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
