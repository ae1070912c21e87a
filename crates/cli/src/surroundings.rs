//! What settings add to a scene before it is drawn: the picture of the light around it, and coarser levels of its
//! meshes.

use crate::failure::{Failure, Kind};
use manypass::{Cache, Environment, Settings};
use manypass_scene::environment::{BrdfTable, files_of, prefiltered_files};
use manypass_scene::{EnvironmentError, EnvironmentMap, Scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What was read last: a batch has one for all of its inputs.
#[derive(Debug)]
pub struct Surroundings {
    known: Option<(EnvironmentFiles, Arc<EnvironmentMap>)>,
    known_table: Option<(PathBuf, Arc<BrdfTable>)>,
    /// Where coarser levels of meshes are looked for, and kept.
    cache: Option<Arc<dyn Cache>>,
}

/// What settings name of the light around a scene, if anything is lit by it.
#[derive(Clone, Debug, Default, PartialEq)]
struct EnvironmentFiles {
    picture: Option<PathBuf>,
    irradiance: Option<PathBuf>,
    prefiltered: Option<PathBuf>,
}

fn named(path: &Path) -> Option<PathBuf> {
    (!path.as_os_str().is_empty()).then(|| path.to_owned())
}

impl EnvironmentFiles {
    fn of(settings: &Settings) -> Self {
        let environment = &settings.environment;
        if !matches!(environment.source, Environment::Auto | Environment::File) {
            return Self::default();
        }
        Self {
            picture: named(&environment.file),
            irradiance: named(&environment.irradiance_file),
            prefiltered: named(&environment.prefiltered_file),
        }
    }

    /// Whether a map is that, as stages bring it with the model.
    fn is_of(&self, map: &EnvironmentMap) -> bool {
        let is = |path: &Option<PathBuf>, name: Option<&str>| path.as_deref() == name.map(Path::new);
        let irradiance = map.irradiance.as_ref().map(|of| of.name.as_str());
        // Levels of the picture's own file are not named.
        let levels = map.prefiltered.as_ref().map(|of| of.name.as_str());
        let levels = levels.filter(|name| self.prefiltered.is_some() || *name != map.name);
        let is_picture = self.picture.is_none() || is(&self.picture, Some(map.name.as_str()));
        is_picture && is(&self.irradiance, irradiance) && is(&self.prefiltered, levels)
    }

    /// The picture with what is named of its light; none where that alone is named.
    fn read(&self) -> Result<Option<EnvironmentMap>, EnvironmentError> {
        let prefiltered = self.prefiltered.as_deref().map(EnvironmentMap::load_prefiltered).transpose()?;
        let picture = self.picture.as_deref().map(EnvironmentMap::load_path).transpose()?;
        let irradiance = self.irradiance.as_deref().map(EnvironmentMap::load_path).transpose()?;
        let map = match (picture, prefiltered) {
            (Some(picture), Some(prefiltered)) => Some(picture.with_prefiltered(prefiltered)),
            (picture, prefiltered) => picture.or(prefiltered),
        };
        Ok(map.map(|map| match irradiance {
            Some(irradiance) => map.with_irradiance(&irradiance),
            None => map.with_sun_as_light(),
        }))
    }
}

/// The files that `settings` name of what lights a scene, as far as they are read.
pub fn files(settings: &Settings) -> Vec<PathBuf> {
    let EnvironmentFiles { picture, irradiance, prefiltered } = EnvironmentFiles::of(settings);
    let pictures = [picture, irradiance].into_iter().flatten().flat_map(|path| files_of(&path));
    let levels = prefiltered.into_iter().flat_map(|path| prefiltered_files(&path));
    pictures.chain(levels).chain(named(&settings.environment.brdf_file)).collect()
}

impl Surroundings {
    /// Nothing read yet.
    pub fn new(cache: Option<Arc<dyn Cache>>) -> Self {
        Self { known: None, known_table: None, cache }
    }

    /// Gives `scene` the picture that `settings` name, if they name one, with what they name of its light, and coarser
    /// levels of meshes where they ask for some. Says what was changed, and what could not be done.
    ///
    /// # Errors
    /// No picture is named where one is wanted, or a file cannot be read.
    pub fn prepare(&mut self, scene: &mut Scene, settings: &Settings) -> Result<Vec<String>, Failure> {
        let mut notes = self.surround(scene, settings)?;
        let of_stage = scene.brdf.take();
        scene.brdf = named(&settings.environment.brdf_file).map(|path| self.table(&path, of_stage)).transpose()?;
        if settings.lod.simplify {
            notes.extend(scene.simplify_with(self.cache.as_deref()));
        }
        Ok(notes)
    }

    fn surround(&mut self, scene: &mut Scene, settings: &Settings) -> Result<Vec<String>, Failure> {
        let named = EnvironmentFiles::of(settings);
        if named == EnvironmentFiles::default() {
            if settings.environment.source == Environment::File && scene.environment.is_none() {
                let hint = "write --environment FILE.hdr, or --set environment.file=FILE.hdr";
                return Err(Failure::usage("the environment is a file, and none is named", hint));
            }
            return Ok(Vec::new());
        }
        if scene.environment.as_ref().is_some_and(|map| named.is_of(map)) {
            return Ok(Vec::new());
        }
        let map = match &self.known {
            Some((known, map)) if *known == named => map.clone(),
            _ => {
                let Some(map) = named.read().map_err(unread)? else {
                    let message = "environment.irradiance_file is the diffuse light of a picture, and none is named";
                    return Err(Failure::usage(message, "name the picture as well: --environment FILE.hdr"));
                };
                let map = Arc::new(map);
                self.known = Some((named, map.clone()));
                map
            }
        };
        let notes = map.notes.clone();
        scene.environment = Some(map);
        Ok(notes)
    }

    /// The table of a file: as a stage brings it with the model, else as it was read last. Equal ones are one table, so
    /// that it stays on the device from input to input.
    fn table(&mut self, path: &Path, of_stage: Option<Arc<BrdfTable>>) -> Result<Arc<BrdfTable>, Failure> {
        let of_stage = of_stage.filter(|table| Path::new(&table.name) == path);
        let known = self.known_table.as_ref().filter(|(known, _)| known == path).map(|(_, table)| table);
        let is_known = |table: &Arc<BrdfTable>| of_stage.as_ref().is_none_or(|brought| brought == table);
        if let Some(table) = known.filter(|table| is_known(table)) {
            return Ok(table.clone());
        }
        let hint = "name a .png, .hdr or .exr file: red and green over n·v to the right and roughness downwards";
        let read = || BrdfTable::load_path(path).map_err(|error| Failure::new(Kind::Failed, error, hint));
        let table = of_stage.map_or_else(|| read().map(Arc::new), Ok)?;
        self.known_table = Some((path.to_owned(), table.clone()));
        Ok(table)
    }
}

fn unread(error: EnvironmentError) -> Failure {
    let hint = "name an equirectangular .hdr or .exr file, a cube map in a .ktx2 file, or a folder with the six faces of a cube";
    Failure::new(Kind::Failed, error, hint)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    /// A table of one texel in a Radiance file.
    fn table(name: &str, rgbe: [u8; 4]) -> Arc<BrdfTable> {
        let bytes = [&b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n"[..], &rgbe].concat();
        Arc::new(BrdfTable::decode(name, &bytes).unwrap())
    }

    #[test]
    fn a_table_that_a_stage_brings_is_not_read_again_and_shared() {
        // There is no such file: whoever reads it fails.
        let mut settings = Settings::default();
        settings.environment.brdf_file = "no_folder/table.hdr".into();
        let mut surroundings = Surroundings::new(None);
        let mut prepared = |brdf: Option<Arc<BrdfTable>>| {
            let mut scene = Scene { brdf, ..Scene::default() };
            surroundings.prepare(&mut scene, &settings).map(|_| scene.brdf)
        };
        assert!(prepared(None).is_err());
        assert!(prepared(Some(table("other.hdr", [64, 32, 0, 129]))).is_err());
        let brought = || Some(table("no_folder/table.hdr", [64, 32, 0, 129]));
        let first = prepared(brought()).unwrap().unwrap();
        for second in [brought(), None] {
            assert!(Arc::ptr_eq(&prepared(second).unwrap().unwrap(), &first));
        }
        // The file has changed.
        let changed = Some(table("no_folder/table.hdr", [32, 64, 0, 129]));
        assert_eq!(prepared(changed.clone()).unwrap(), changed);
    }
}
