//! `--preset`: whole sets of settings of light, by what a picture is for.

use manypass::{Environment, Settings};
use manypass_scene::Scene;

/// What a picture is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// To show a thing: the studio and the ground, without lights of the file.
    Product,
    /// As the file says: its lights or its picture of the environment, and no other light.
    Scene,
    /// Raw radiance.
    Data,
}

impl Preset {
    /// The names of all.
    pub const NAMES: [&str; 3] = ["product", "scene", "data"];

    /// The one of a name.
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::Product, Self::Scene, Self::Data];
        all.into_iter().zip(Self::NAMES).find(|(_, known)| *known == name).map(|(preset, _)| preset)
    }

    /// Keys and values. They come after the stage's, and before files of settings and flags.
    pub fn table(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Product => &[("environment.source", "studio"), ("ground.mode", "shadow"), ("exposure.stops", "0")],
            Self::Scene => &[("environment.source", "auto"), ("ground.mode", "none"), ("exposure.stops", "scene")],
            Self::Data => &[
                ("environment.source", "none"),
                ("ground.mode", "none"),
                ("exposure.stops", "0"),
                ("exposure.adapt", "false"),
                ("effects.enabled", "false"),
                ("tone_map.curve", "none"),
                ("transparency.masks", "cutoff"),
            ],
        }
    }

    /// What it changes that is known with the scene alone: a product has no lights of the file; and a scene as its file
    /// says has no light around it but a picture of its own, unless flags say another.
    pub fn prepare(self, scene: &mut Scene, settings: &mut Settings) {
        match self {
            Self::Product => scene.nodes.iter_mut().for_each(|node| node.light = None),
            Self::Scene if settings.environment.source == Environment::Auto => {
                let has_picture = scene.environment.is_some();
                settings.environment.source = if has_picture { Environment::File } else { Environment::None };
            }
            Self::Scene | Self::Data => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn their_settings_are_known_and_they_do_what_they_say() {
        for (name, preset) in Preset::NAMES.into_iter().zip([Preset::Product, Preset::Scene, Preset::Data]) {
            assert_eq!(Preset::named(name), Some(preset));
            let mut settings = Settings::default();
            for (key, value) in preset.table() {
                settings.set(key, value).expect("a key of a preset is a setting");
            }
            assert!(settings.check().is_ok(), "{name}");
        }
        assert_eq!(Preset::named("Product"), None);
    }
}
