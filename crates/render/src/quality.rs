//! Tiers of quality: tables of settings, and which of them keeps to a budget of time.

mod budget;
mod controller;

pub use budget::QualityBudget;

use crate::setting::{SettingsError, choices};
use crate::settings::Settings;

choices! {
    /// A quality tier, from low to ultra. Each is a table of settings.
    pub enum Quality {
        /// Fewer pixels are shaded, surfaces neither occlude nor reflect each other, shadows have hard edges, and what is
        /// seen small is drawn with less.
        Low = "low",
        /// What settings are without a tier.
        #[default]
        Medium = "medium",
        /// Surfaces occlude and reflect each other by what is found of each pixel, not of four.
        High = "high",
        /// The same with more of occlusion, soft shadows, glass behind glass, and all samples of all pixels.
        Ultra = "ultra",
    }
}

impl Quality {
    /// The settings of the tier: keys and values. Those that it shares with what there is without one are in it where
    /// `bench` begins with others.
    pub fn table(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Low => &[
                ("render.scale", "0.67"),
                ("occlusion.enabled", "false"),
                ("reflections.enabled", "false"),
                ("shadows.filter", "hard"),
                ("shadows.cascades", "2"),
                ("shadows.atlas_px", "2048"),
                ("shadows.min_px", "16"),
                ("lights.min_px", "4"),
                ("fog.steps", "8"),
                ("lod.materials", "true"),
                ("lod.error_px", "2"),
                ("textures.max_px", "1024"),
                ("effects.fallbacks", "true"),
            ],
            Self::Medium => &[("occlusion.enabled", "auto"), ("reflections.enabled", "auto")],
            Self::High => &[
                ("occlusion.enabled", "auto"),
                ("occlusion.resolution", "full"),
                ("occlusion.slices", "3"),
                ("reflections.enabled", "auto"),
                ("reflections.resolution", "full"),
            ],
            Self::Ultra => &[
                ("occlusion.enabled", "auto"),
                ("occlusion.resolution", "full"),
                ("occlusion.slices", "8"),
                ("reflections.enabled", "auto"),
                ("reflections.resolution", "full"),
                ("shadows.filter", "pcss"),
                ("transparency.refractive_layers", "8"),
                ("fog.half", "false"),
                ("adaptive.threshold", "0"),
                ("lod.bias", "1"),
            ],
        }
    }
}

impl Settings {
    /// Takes the settings of a tier.
    ///
    /// # Errors
    /// None: a test takes all of them.
    pub fn apply_quality(&mut self, quality: Quality) -> Result<(), SettingsError> {
        quality.table().iter().try_for_each(|(key, value)| self.set(key, value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiers_are_settings() {
        for name in Quality::NAMES {
            let quality = Quality::named(name).expect("a tier's name");
            let mut settings = Settings::default();
            settings.apply_quality(quality).expect("known keys and values");
            settings.check().expect("they go together");
            assert_eq!(settings == Settings::default(), quality == Quality::default(), "{name}");
            for (key, value) in quality.table() {
                let mut without = settings.clone();
                let default = Settings::declared().iter().find(|info| info.key == *key).expect("a setting");
                let default = default.default.as_ref().expect("a default").to_string();
                without.set(key, &default).expect("its default");
                assert!(without != settings || *value == default, "{key}={value} is what it is without the tier");
            }
        }
    }
}
