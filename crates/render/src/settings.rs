//! Settings of the whole frame, composed from those that each pass declares.

mod file;
mod info;

pub use file::SettingsFile;
pub use info::{Scalar, SettingInfo, SettingType, SettingValue};

use crate::diagnostic::Diagnostic;
use serde::{Deserialize, Serialize};

/// A setting was refused.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum SettingsError {
    /// No setting has that key.
    #[error("no setting is called `{key}`; did you mean `{nearest}`?")]
    UnknownKey {
        /// The key that was given.
        key: String,
        /// The key most like it.
        nearest: String,
    },
    /// The value has another type or lies outside its range.
    #[error("`{value}` is no value of `{key}`, which takes {expected}")]
    BadValue {
        /// The key.
        key: String,
        /// The value that was given.
        value: String,
        /// The type and the range, in words.
        expected: String,
    },
    /// A file of settings is wrong.
    #[error(transparent)]
    File(#[from] Box<Diagnostic>),
}

/// Every setting, with its value.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Of the frame as a whole.
    pub render: RenderSettings,
    /// Of the lists of lights.
    pub clusters: crate::passes::lights::ClusterSettings,
    /// Of the display transform.
    pub tone_map: crate::passes::tone_map::ToneMapSettings,
}

/// Of the frame as a whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RenderSettings {
    /// Shading happens at this many times the output's width and height (0.25 to 2), each rounded to whole pixels; the
    /// output keeps its size.
    pub scale: f32,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self { scale: 1.0 }
    }
}

/// Every setting there is, beside those of effects.
pub const SETTINGS: &[SettingInfo] = &[
    SettingInfo::f32(
        "render.scale",
        "Shading happens at this many times the output's width and height.",
        Some("factor"),
        1.0,
        (0.25, 2.0),
    ),
    SettingInfo::u32("clusters.tile_px", "The side of a tile of the light lists.", Some("px"), 16, (8, 128)),
    SettingInfo::u32(
        "clusters.slices",
        "The number of slices of the light lists along the view axis.",
        None,
        32,
        (1, 64),
    ),
    SettingInfo::f32("tone_map.dither", "The amplitude of the dither.", Some("1/255"), 1.0, (0.0, 2.0)),
];

impl Settings {
    fn slot(&mut self, key: &str) -> Option<Slot<'_>> {
        Some(match key {
            "render.scale" => Slot::Float(&mut self.render.scale),
            "clusters.tile_px" => Slot::Integer(&mut self.clusters.tile_px),
            "clusters.slices" => Slot::Integer(&mut self.clusters.slices),
            "tone_map.dither" => Slot::Float(&mut self.tone_map.dither),
            _ => return None,
        })
    }

    /// Sets `key` to `value`, both as text.
    ///
    /// # Errors
    /// An unknown key, or a value that is no number or outside its range.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), SettingsError> {
        let Some(info) = SETTINGS.iter().find(|info| info.key == key) else {
            return Err(unknown_key(key, SETTINGS.iter().map(|info| &*info.key)));
        };
        let numbers = info.parse(value)?;
        match (self.slot(key), numbers.as_slice()) {
            (Some(Slot::Float(slot)), [number]) => *slot = *number as f32,
            (Some(Slot::Integer(slot)), [number]) => *slot = *number as u32,
            _ => return Err(info.refuse(value)),
        }
        Ok(())
    }

    /// Reads settings from TOML; what it does not name keeps its default. `file` appears in errors.
    ///
    /// # Errors
    /// Text that is not TOML, an unknown key, or a value outside its range; with file, line and column.
    pub fn from_toml(file: &str, text: &str) -> Result<Self, SettingsError> {
        let mut settings = Self::default();
        SettingsFile::parse(file, text)?.apply(|key, value| settings.set(key, value))?;
        Ok(settings)
    }
}

enum Slot<'a> {
    Float(&'a mut f32),
    Integer(&'a mut u32),
}

/// The error of a key that is not among `known`.
pub(crate) fn unknown_key<'k>(key: &str, known: impl Iterator<Item = &'k str>) -> SettingsError {
    SettingsError::UnknownKey { key: key.into(), nearest: nearest_key(key, known).unwrap_or_default().into() }
}

/// The known key with the smallest edit distance (Levenshtein 1966); where the key's last part is that of known keys, among
/// those.
fn nearest_key<'k>(key: &str, known: impl Iterator<Item = &'k str>) -> Option<&'k str> {
    let last = |key: &str| key.rsplit('.').next().map(str::to_owned);
    known.min_by_key(|known| (last(known) != last(key), edit_distance(key, known)))
}

fn edit_distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.bytes().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.bytes().enumerate() {
            let above = row[j + 1];
            row[j + 1] = (above + 1).min(row[j] + 1).min(diagonal + usize::from(x != y));
            diagonal = above;
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    #[test]
    fn every_setting_has_a_slot_and_its_default() {
        let mut settings = Settings::default();
        for info in SETTINGS {
            let default = info.default.as_ref().unwrap().to_string();
            settings.set(&info.key, &default).unwrap();
        }
        assert_eq!(settings, Settings::default());
    }

    #[test]
    fn refusals_name_the_nearest_key_and_the_range() {
        let mut settings = Settings::default();
        assert_eq!(
            settings.set("cluster.slice", "4").unwrap_err().to_string(),
            "no setting is called `cluster.slice`; did you mean `clusters.slices`?"
        );
        let nearest = settings.set("dither", "1").unwrap_err().to_string();
        assert!(nearest.contains("`tone_map.dither`?"), "{nearest}");
        let error = settings.set("render.scale", "9").unwrap_err().to_string();
        assert!(error.contains("takes a number from 0.25 to 2"), "{error}");
        let error = settings.set("clusters.slices", "1.5").unwrap_err().to_string();
        assert!(error.contains("takes a whole number from 1 to 64"), "{error}");
    }

    #[test]
    fn files_are_refused_with_the_place() {
        let read = |text| Settings::from_toml("my.toml", text).map_err(|error| error.to_string());
        assert!(read("[render]\nscale = 0.5").unwrap().render.scale == 0.5);
        assert!(read("render.scale = 0.5").unwrap().render.scale == 0.5);
        for (text, expected) in [
            (
                "[render]\nscael = 0.5",
                "my.toml:2:1: error: no setting is called `render.scael`; did you mean `render.scale`?",
            ),
            (
                "\n[render]\n  scale = 9",
                "my.toml:3:11: error: `9` is no value of `render.scale`, which takes a number from",
            ),
            ("scale = 1", "my.toml:1:1: error: no setting is called `scale`; did you mean `render.scale`?"),
            ("[render]\nscale = [1, 2]", "my.toml:2:9: error: `1,2` is no value of `render.scale`"),
            ("[render]\nscale = 1979-05-27", "my.toml:2:9: error: `1979-05-27` is no value of"),
            ("[tone_map]\ndither = 1\n[render]\nscale = ", "my.toml:4:"),
            ("[clusters]\nslices = 4\nslices = 5", "my.toml:3:"),
            ("[clusters]\ntile_px = 1\nslices = 99", "my.toml:2:11: error: `1` is no value"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(expected), "{text}\n{error}\nshould begin {expected}");
        }
    }
}
