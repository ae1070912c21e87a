//! Colours, which people write in sRGB and shaders read in linear light.

use super::{SettingField, SettingInput, SettingType, SettingValue};
use crate::colour::{linear_from_srgb, srgb_from_linear};

/// A colour in linear Rec. 709.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearColor(pub [f32; 3]);

impl LinearColor {
    /// The pattern of six hexadecimal digits, as JSON Schema writes it.
    pub(crate) const PATTERN: &'static str = "^#?[0-9a-fA-F]{6}$";

    /// The pattern of two such colours with a comma between.
    pub(crate) const PAIR_PATTERN: &'static str = "^#?[0-9a-fA-F]{6},#?[0-9a-fA-F]{6}$";

    /// The colour of six hexadecimal digits, `#` optional, in sRGB.
    pub(crate) fn of_hex(text: &str) -> Option<Self> {
        let hex = text.strip_prefix('#').unwrap_or(text);
        if hex.len() != 6 || !hex.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return None;
        }
        let value = u32::from_str_radix(hex, 16).ok()?;
        Some(Self([16, 8, 0].map(|shift| linear_from_srgb((value >> shift & 255) as f32 / 255.0))))
    }

    /// The six digits of the nearest colour.
    pub(crate) fn hex(self) -> String {
        let byte = |linear: f32| (srgb_from_linear(linear.clamp(0.0, 1.0)) * 255.0).round() as u8;
        let [r, g, b] = self.0.map(byte);
        format!("{r:02x}{g:02x}{b:02x}")
    }
}

/// `rrggbb` or `#rrggbb` in sRGB, or three numbers of at least 0 in linear light.
impl SettingField for LinearColor {
    fn kind() -> SettingType {
        SettingType::Color
    }

    fn read(written: &SettingInput) -> Option<Self> {
        if let Some(color) = written.text().and_then(|text| Self::of_hex(&text)) {
            return Some(color);
        }
        <[f32; 3]>::read(written).filter(|linear| linear.iter().all(|value| *value >= 0.0)).map(Self)
    }

    /// In sRGB where that is the same colour again, else in linear light.
    fn value(&self) -> SettingValue {
        let hex = self.hex();
        if Self::of_hex(&hex).as_ref() == Some(self) { SettingValue::Text(hex) } else { self.0.value() }
    }
}

/// One of `words`, else the value of a colour.
pub(crate) fn read_word_or_color<T: Copy>(
    words: &[(&str, T)],
    of_color: fn([f32; 3]) -> T,
    written: &SettingInput,
) -> Option<T> {
    let word = written.text().and_then(|text| words.iter().find(|(word, _)| *word == &*text));
    word.map(|(_, value)| *value).or_else(|| LinearColor::read(written).map(|LinearColor(linear)| of_color(linear)))
}

/// As [`read_word_or_color`] reads it: the colour if it is one, else its word.
pub(crate) fn word_or_color<T: PartialEq>(words: &[(&str, T)], value: &T, color: Option<[f32; 3]>) -> SettingValue {
    let word = || words.iter().find(|(_, known)| known == value).map_or("", |(word, _)| word);
    color.map_or_else(|| SettingValue::Text(word().into()), |linear| LinearColor(linear).value())
}
