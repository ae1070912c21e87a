//! Settings of the whole frame, composed from those that each pass declares.

use serde::{Deserialize, Serialize};

/// A setting's description, for `--set`, panels and documentation.
#[derive(Clone, Debug, Serialize)]
pub struct SettingInfo {
    /// The dotted key.
    pub key: &'static str,
    /// What it does, with its unit.
    pub doc: &'static str,
    /// The smallest and the largest value.
    pub range: (f64, f64),
    /// The value without any setting.
    pub default: f64,
}

/// A setting was refused.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum SettingsError {
    /// No setting has that key.
    #[error("no setting is called `{key}`; did you mean `{nearest}`?")]
    UnknownKey {
        /// The key that was given.
        key: String,
        /// The key most like it.
        nearest: &'static str,
    },
    /// The value is no number or outside its range.
    #[error("`{value}` is no value of `{key}`, which takes a number from {min} to {max}")]
    BadValue {
        /// The key.
        key: String,
        /// The value that was given.
        value: String,
        /// The smallest value.
        min: f64,
        /// The largest value.
        max: f64,
    },
    /// A settings file is not valid TOML.
    #[error("the settings are not valid TOML: {0}")]
    Toml(String),
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

/// Every setting there is.
pub const SETTINGS: &[SettingInfo] = &[
    SettingInfo {
        key: "render.scale",
        doc: "Shading happens at this many times the output's width and height.",
        range: (0.25, 2.0),
        default: 1.0,
    },
    SettingInfo {
        key: "clusters.tile_px",
        doc: "The side of a tile of the light lists, in pixels.",
        range: (8.0, 128.0),
        default: 16.0,
    },
    SettingInfo {
        key: "clusters.slices",
        doc: "The number of slices of the light lists along the view axis.",
        range: (1.0, 64.0),
        default: 32.0,
    },
    SettingInfo {
        key: "tone_map.dither",
        doc: "The amplitude of the dither in steps of 1/255.",
        range: (0.0, 2.0),
        default: 1.0,
    },
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
            return Err(SettingsError::UnknownKey { key: key.into(), nearest: nearest_key(key) });
        };
        let bad =
            || SettingsError::BadValue { key: key.into(), value: value.into(), min: info.range.0, max: info.range.1 };
        let number: f64 = value.trim().parse().map_err(|_| bad())?;
        if !(info.range.0..=info.range.1).contains(&number) {
            return Err(bad());
        }
        match self.slot(key) {
            Some(Slot::Float(slot)) => *slot = number as f32,
            Some(Slot::Integer(slot)) if number.fract() == 0.0 => *slot = number as u32,
            _ => return Err(bad()),
        }
        Ok(())
    }

    /// Reads settings from TOML; what it does not name keeps its default.
    ///
    /// # Errors
    /// Text that is not TOML, an unknown key, or a value outside its range.
    pub fn from_toml(text: &str) -> Result<Self, SettingsError> {
        let table: toml::Table = toml::from_str(text).map_err(|error| SettingsError::Toml(error.to_string()))?;
        let mut settings = Self::default();
        for (group, values) in table {
            let toml::Value::Table(values) = values else {
                return Err(SettingsError::UnknownKey { nearest: nearest_key(&group), key: group });
            };
            for (name, value) in values {
                settings.set(&format!("{group}.{name}"), &value.to_string())?;
            }
        }
        Ok(settings)
    }
}

enum Slot<'a> {
    Float(&'a mut f32),
    Integer(&'a mut u32),
}

/// The key with the smallest edit distance (Levenshtein 1966).
fn nearest_key(key: &str) -> &'static str {
    SETTINGS.iter().map(|info| info.key).min_by_key(|known| edit_distance(key, known)).unwrap_or("")
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
            settings.set(info.key, &info.default.to_string()).unwrap();
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
        let error = settings.set("render.scale", "9").unwrap_err().to_string();
        assert!(error.contains("from 0.25 to 2"), "{error}");
        assert!(settings.set("clusters.slices", "1.5").is_err());
        assert!(Settings::from_toml("[render]\nscale = 0.5").unwrap().render.scale == 0.5);
        assert!(Settings::from_toml("[render]\nscael = 0.5").is_err());
    }
}
