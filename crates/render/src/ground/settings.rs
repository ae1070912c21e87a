//! Settings of the ground, and how it is written.

use super::Ground;
use crate::setting::{
    SettingField, SettingInput, SettingType, SettingValue, read_word_or_color, settings, word_or_color,
};

settings! {
    /// Settings of the ground.
    pub struct GroundSettings {
        /// The plane under the scene, at its lowest point. `shadow` is a shadow catcher, `none` no plane, and a colour
        /// a floor. `auto` is `shadow` if the environment is the studio, fill, the sky or a picture, and the background
        /// is not transparent; else `none`. The shadow comes from the environment's light, else from the scene's first
        /// directional light.
        mode: Ground = Ground::Auto;
    }
}

const GROUNDS: [(&str, Ground); 3] = [("auto", Ground::Auto), ("shadow", Ground::Shadow), ("none", Ground::None)];

impl SettingField for Ground {
    fn kind() -> SettingType {
        SettingType::ChoiceOrColor
    }

    fn choices() -> &'static [&'static str] {
        const { &[GROUNDS[0].0, GROUNDS[1].0, GROUNDS[2].0] }
    }

    fn read(written: &SettingInput) -> Option<Self> {
        read_word_or_color(&GROUNDS, Self::Color, written)
    }

    fn value(&self) -> SettingValue {
        let color = if let Self::Color(linear) = self { Some(*linear) } else { None };
        word_or_color(&GROUNDS, self, color)
    }
}
