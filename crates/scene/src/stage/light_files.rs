//! The files that `[environment]` names: the picture, and what is known of its light. Settings are checked by whoever
//! draws, but files are read with the scene.

use super::older::value;
use super::table::{Source, SpannedValue};
use crate::environment::{BrdfTable, LEVEL};
use crate::{Diagnostic, EnvironmentMap};
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// The names of the files, with where they stand.
#[derive(Clone, Debug, Default)]
pub(super) struct LightFiles {
    pub picture: Option<SpannedValue<String>>,
    irradiance: Option<SpannedValue<String>>,
    prefiltered: Option<SpannedValue<String>>,
    brdf: Option<SpannedValue<String>>,
}

/// What they hold.
#[derive(Debug, Default)]
pub(super) struct Light {
    pub environment: Option<EnvironmentMap>,
    pub brdf: Option<BrdfTable>,
}

/// What reads each kind of file by its name.
pub(super) trait ReadLight {
    fn picture(&mut self, name: &str) -> Result<EnvironmentMap, String>;
    fn prefiltered(&mut self, name: &str) -> Result<EnvironmentMap, String>;
    fn brdf(&mut self, name: &str) -> Result<BrdfTable, String>;
}

impl LightFiles {
    /// Those of a stage.
    pub fn of(root: &DeTable<'_>) -> Self {
        let Some(DeValue::Table(table)) = value(root, "environment").map(|table| table.get_ref()) else {
            return Self::default();
        };
        let name = |key: &str| {
            let file = value(table, key)?;
            match file.get_ref() {
                DeValue::String(name) if !name.is_empty() => {
                    Some(SpannedValue { value: name.to_string(), range: file.span() })
                }
                _ => None,
            }
        };
        Self {
            picture: name("file"),
            irradiance: name("irradiance_file"),
            prefiltered: name("prefiltered_file"),
            brdf: name("brdf_file"),
        }
    }

    /// All names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.picture.iter().chain(self.beside_picture()).map(|name| name.value.as_str())
    }

    fn beside_picture(&self) -> impl Iterator<Item = &SpannedValue<String>> {
        [&self.irradiance, &self.prefiltered, &self.brdf].into_iter().flatten()
    }

    /// Those beside the picture that are one file each.
    pub fn single_files(&self) -> impl Iterator<Item = &str> {
        self.beside_picture().map(|name| name.value.as_str()).filter(|name| !name.contains(LEVEL))
    }

    /// Reads the files.
    ///
    /// # Errors
    /// One cannot be read; or there is irradiance of no picture.
    pub fn read(&self, source: &Source, files: &mut impl ReadLight) -> Result<Light, Box<Diagnostic>> {
        let fault = |name: &SpannedValue<String>, message: String| source.fault(name.range.clone(), message);
        let mut light = Light::default();
        if let Some(name) = &self.picture {
            light.environment = Some(files.picture(&name.value).map_err(|message| fault(name, message))?);
        }
        if let Some(name) = &self.prefiltered {
            let prefiltered = files.prefiltered(&name.value).map_err(|message| fault(name, message))?;
            light.environment = Some(match light.environment.take() {
                Some(picture) => picture.with_prefiltered(prefiltered),
                None => prefiltered,
            });
        }
        if let Some(name) = &self.irradiance {
            let Some(picture) = light.environment.take() else {
                let message = "it is the diffuse light of a picture: name that as well, file = \"FILE.hdr\"";
                return Err(fault(name, message.into()));
            };
            let irradiance = files.picture(&name.value).map_err(|message| fault(name, message))?;
            light.environment = Some(picture.with_irradiance(&irradiance));
        }
        if let Some(name) = &self.brdf {
            light.brdf = Some(files.brdf(&name.value).map_err(|message| fault(name, message))?);
        }
        light.environment = light.environment.map(EnvironmentMap::with_sun_as_light);
        Ok(light)
    }
}

/// Files in a folder.
pub(super) struct InFolder<'f>(pub &'f Path);

impl InFolder<'_> {
    fn check(path: &Path) -> Result<(), String> {
        let metadata = std::fs::metadata(path);
        metadata.map(|_| ()).map_err(|error| format!("cannot read the environment {}: {error}", path.display()))
    }
}

impl ReadLight for InFolder<'_> {
    fn picture(&mut self, name: &str) -> Result<EnvironmentMap, String> {
        let path = self.0.join(name);
        Self::check(&path)?;
        EnvironmentMap::load_path(&path).map_err(|error| error.to_string())
    }

    fn prefiltered(&mut self, name: &str) -> Result<EnvironmentMap, String> {
        let path = self.0.join(name);
        if !name.contains(LEVEL) {
            Self::check(&path)?;
        }
        EnvironmentMap::load_prefiltered(&path).map_err(|error| error.to_string())
    }

    fn brdf(&mut self, name: &str) -> Result<BrdfTable, String> {
        let path = self.0.join(name);
        Self::check(&path)?;
        BrdfTable::load_path(&path).map_err(|error| error.to_string())
    }
}

/// Bytes that are found by the names of files; messages name them as seen from a folder.
pub(super) struct ResolvedFiles<'f, 'r> {
    pub folder: &'f Path,
    pub resolve: &'r mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
}

impl ResolvedFiles<'_, '_> {
    fn path(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }
}

impl ReadLight for ResolvedFiles<'_, '_> {
    fn picture(&mut self, name: &str) -> Result<EnvironmentMap, String> {
        let bytes = (self.resolve)(name)?;
        EnvironmentMap::decode(&self.path(name), &bytes).map_err(|error| error.to_string())
    }

    fn prefiltered(&mut self, name: &str) -> Result<EnvironmentMap, String> {
        if name.contains(LEVEL) {
            return Err("pictures of levels are found in folders alone: name a cube map with levels (.ktx2)".into());
        }
        let bytes = (self.resolve)(name)?;
        EnvironmentMap::decode_prefiltered(&self.path(name), &bytes).map_err(|error| error.to_string())
    }

    fn brdf(&mut self, name: &str) -> Result<BrdfTable, String> {
        let bytes = (self.resolve)(name)?;
        BrdfTable::decode(&self.path(name), &bytes).map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use crate::stage::{Stage, load_bytes};
    use glam::Vec3;

    /// A Radiance file of one texel.
    fn texel(rgbe: [u8; 4]) -> Vec<u8> {
        [&b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n"[..], &rgbe].concat()
    }

    fn resolve(name: &str) -> Result<Vec<u8>, String> {
        match name {
            "room.hdr" => Ok(texel([128, 0, 0, 129])),
            "light.hdr" => Ok(texel([0, 0, 128, 130])),
            "table.hdr" => Ok(texel([64, 32, 0, 129])),
            _ => Err(format!("`{name}` is not there")),
        }
    }

    #[test]
    fn a_stage_brings_the_light_of_its_picture() {
        let text = "model = \"demo:hall\"\n[environment]\nfile = \"room.hdr\"\nirradiance_file = \"light.hdr\"\n\
                    brdf_file = \"table.hdr\"\n";
        let stage = Stage::parse("a/b.stage.toml", text).unwrap();
        assert_eq!((stage.environment(), stage.images()), (Some("room.hdr"), vec!["light.hdr", "table.hdr"]));
        let scene = load_bytes(text.as_bytes(), &mut resolve, "a/b.stage.toml").unwrap().scene;
        let irradiance = scene.environment.as_ref().unwrap().irradiance.as_ref().unwrap();
        assert_eq!((irradiance.name.as_str(), irradiance.seen(Vec3::Y)), ("a/light.hdr", 2.0 * Vec3::Z));
        assert_eq!(scene.brdf.unwrap().at(0.5, 0.5), [0.5, 0.25]);
    }

    #[test]
    fn what_cannot_be_read_is_told_with_its_place() {
        for (lines, expected) in [
            ("irradiance_file = \"light.hdr\"", "3:19: error: it is the diffuse light of a picture"),
            ("file = \"room.hdr\"\nirradiance_file = \"no.hdr\"", "4:19: error: `no.hdr` is not there"),
            ("prefiltered_file = \"room.hdr\"", "3:20: error: environment \"room.hdr\": it has one level"),
            ("prefiltered_file = \"room_{level}.hdr\"", "3:20: error: pictures of levels are found in folders alone"),
            ("brdf_file = \"no.png\"", "3:13: error: `no.png` is not there"),
        ] {
            let text = format!("model = \"demo:hall\"\n[environment]\n{lines}\n");
            let error = load_bytes(text.as_bytes(), &mut resolve, "b.stage.toml").unwrap_err().to_string();
            assert!(error.starts_with(&format!("b.stage.toml:{expected}")), "{error}");
        }
    }
}
