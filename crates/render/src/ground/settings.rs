//! Settings of the ground, and how it is written.

use super::Ground;
use crate::setting::{SettingField, SettingType, SettingValue, Written, read_word_or_color, settings, word_or_color};

settings! {
    /// Settings of the ground.
    pub struct GroundSettings {
        /// What is under the scene, at its lowest point: a plane that is seen by the shadow on it alone, nothing, or a
        /// floor of a colour; `auto` is shadow where the environment is the studio, be it faint, the sky or a picture,
        /// and the background is not transparent, else none. Its shadow is that of the environment's light, else of the
        /// scene's first directional one.
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

    fn read(written: &Written) -> Option<Self> {
        read_word_or_color(&GROUNDS, Self::Color, written)
    }

    fn value(&self) -> SettingValue {
        let color = if let Self::Color(linear) = self { Some(*linear) } else { None };
        word_or_color(&GROUNDS, self, color)
    }
}
