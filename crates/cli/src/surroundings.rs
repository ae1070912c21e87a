//! What settings add to a scene before it is drawn: the picture of the light around it, and coarser levels of its
//! meshes.

use crate::failure::{Failure, Kind};
use manypass::{Cache, Environment, Settings};
use manypass_scene::{EnvironmentMap, Scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The picture that was read last: a batch has one for all of its inputs.
#[derive(Debug)]
pub struct Surroundings {
    known: Option<(PathBuf, Arc<EnvironmentMap>)>,
    /// Where coarser levels of meshes are looked for, and kept.
    cache: Option<Arc<dyn Cache>>,
}

/// The picture that `settings` name, if anything is lit by it.
pub fn file(settings: &Settings) -> Option<&Path> {
    let environment = &settings.environment;
    let is_wanted = matches!(environment.source, Environment::Auto | Environment::File);
    (is_wanted && !environment.file.as_os_str().is_empty()).then_some(&*environment.file)
}

impl Surroundings {
    /// Nothing read yet.
    pub fn new(cache: Option<Arc<dyn Cache>>) -> Self {
        Self { known: None, cache }
    }

    /// Gives `scene` the picture that `settings` name, if they name one, and coarser levels of meshes where they ask
    /// for some. Says what was changed, and what could not be done.
    ///
    /// # Errors
    /// No picture is named where one is wanted, or it cannot be read.
    pub fn prepare(&mut self, scene: &mut Scene, settings: &Settings) -> Result<Vec<String>, Failure> {
        let mut notes = self.surround(scene, settings)?;
        if settings.lod.simplify {
            notes.extend(scene.simplify_with(self.cache.as_deref()));
        }
        Ok(notes)
    }

    fn surround(&mut self, scene: &mut Scene, settings: &Settings) -> Result<Vec<String>, Failure> {
        let Some(path) = file(settings) else {
            if settings.environment.source == Environment::File && scene.environment.is_none() {
                let hint = "write --environment FILE.hdr, or --set environment.file=FILE.hdr";
                return Err(Failure::usage("the environment is a file, and none is named", hint));
            }
            return Ok(Vec::new());
        };
        // Stages bring theirs with the model.
        if scene.environment.as_ref().is_some_and(|map| Path::new(&map.name) == path) {
            return Ok(Vec::new());
        }
        let map = match &self.known {
            Some((known, map)) if known == path => map.clone(),
            _ => {
                let map = Arc::new(read(path)?);
                self.known = Some((path.to_owned(), map.clone()));
                map
            }
        };
        let notes = map.notes.clone();
        scene.environment = Some(map);
        Ok(notes)
    }
}

fn read(path: &Path) -> Result<EnvironmentMap, Failure> {
    EnvironmentMap::load_path(path).map(EnvironmentMap::with_sun_as_light).map_err(|error| {
        let hint = "name an equirectangular .hdr or .exr file, a cube map in a .ktx2 file, or a folder with the six faces of a cube";
        Failure::new(Kind::Failed, error, hint)
    })
}
