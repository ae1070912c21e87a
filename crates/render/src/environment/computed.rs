//! Pictures of the environment that are computed, and come from no file. They are kept while the settings that they are
//! made of stay.

use super::mean::PerMap;
use super::{Environment, EnvironmentSettings};
use glam::Vec3;
use manypass_scene::{EnvironmentLight, EnvironmentMap, Sky};
use std::sync::Arc;

impl EnvironmentSettings {
    /// What the sky is computed from, if that is the environment.
    pub(super) fn sky(&self) -> Option<Sky> {
        let Self { sun_elevation_deg, sun_azimuth_deg, turbidity, ground_albedo, .. } = *self;
        let is_sky = self.source == Environment::Sky;
        is_sky.then_some(Sky { sun_elevation_deg, sun_azimuth_deg, turbidity, ground_albedo })
    }
}

/// Skies that were computed, how bright maps are, and where most of their light comes from.
#[derive(Debug, Default)]
pub(crate) struct ComputedEnvironments {
    skies: Vec<(Sky, Arc<EnvironmentMap>)>,
    means: PerMap<Vec3>,
    broad_sources: PerMap<Option<EnvironmentLight>>,
}

impl ComputedEnvironments {
    /// Computes the skies of the views of a frame. Those of the frame before stay where no view has one.
    pub fn follow<'s>(&mut self, views: impl Iterator<Item = &'s EnvironmentSettings>) {
        let wanted: Vec<Sky> = views.filter_map(EnvironmentSettings::sky).collect();
        if wanted.is_empty() {
            return;
        }
        self.skies.retain(|(sky, _)| wanted.contains(sky));
        for sky in wanted {
            if !self.skies.iter().any(|(known, _)| *known == sky) {
                self.skies.push((sky, Arc::new(sky.map())));
            }
        }
    }

    /// The one that settings ask for.
    pub fn of(&self, settings: &EnvironmentSettings) -> Option<Arc<EnvironmentMap>> {
        let wanted = settings.sky()?;
        self.skies.iter().find(|(sky, _)| *sky == wanted).map(|(_, map)| map.clone())
    }

    /// The mean radiance of a map over all directions, whether it is one of these or a file's.
    pub fn mean_radiance(&mut self, map: &Arc<EnvironmentMap>) -> Vec3 {
        self.means.of(map, EnvironmentMap::mean_radiance)
    }

    /// The broad source of a map, if it has one ([`EnvironmentMap::broad_source`]).
    pub fn broad_source(&mut self, map: &Arc<EnvironmentMap>) -> Option<EnvironmentLight> {
        self.broad_sources.of(map, EnvironmentMap::broad_source)
    }

    /// All of them.
    pub fn maps(&self) -> impl Iterator<Item = &Arc<EnvironmentMap>> + Clone {
        self.skies.iter().map(|(_, map)| map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_those_of_the_sky() {
        let settings = EnvironmentSettings { source: Environment::Sky, ..EnvironmentSettings::default() };
        assert_eq!(settings.sky(), Some(Sky::default()));
        assert_eq!(EnvironmentSettings::default().sky(), None);
    }

    #[test]
    fn a_sky_is_computed_once() {
        let noon = EnvironmentSettings { source: Environment::Sky, ..EnvironmentSettings::default() };
        let evening = EnvironmentSettings { sun_elevation_deg: 3.0, ..noon.clone() };
        let mut computed = ComputedEnvironments::default();
        computed.follow([&noon].into_iter());
        let first = computed.of(&noon);
        computed.follow([&noon, &EnvironmentSettings::default()].into_iter());
        computed.follow([&EnvironmentSettings::default()].into_iter());
        assert!(first.is_some_and(|map| computed.of(&noon).is_some_and(|same| Arc::ptr_eq(&map, &same))));
        computed.follow([&evening].into_iter());
        assert!(computed.of(&noon).is_none() && computed.of(&evening).is_some() && computed.maps().count() == 1);
    }
}
