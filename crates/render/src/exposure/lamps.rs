//! Lamps of a model file by day.
//!
//! `KHR_lights_punctual` is in candela and lux. Under the sky 1 stands for [`SKY_UNIT_NIT`], and a picture in which a
//! sun was found is taken for daylight in the same unit: lamps that were added as they are would be brighter than the
//! sun. So they are divided by that unit. An environment of more than 1 times its own brightness is in a unit so much nearer
//! to theirs, and at [`SKY_UNIT_NIT`] they are added as they are. One of less is dimmed beside them.
//!
//! Lamps stay as they are:
//! - of stages and of scenes made by code, which are set by eye in the picture;
//! - where the file states an exposure, or holds light that was baked of them;
//! - where the exposure of the picture is given in stops;
//! - where all are directional and none is brighter than the sun: such files are not in lux.

use super::Exposure;
use crate::environment::Environment;
use crate::request::FrameRequest;
use manypass_scene::sky::{SKY_UNIT_NIT, SUN_LUX};
use manypass_scene::{LightKind, Scene};

/// Whether lights of a scene are lamps in candela, or brighter than the sun would be in the unit of the sky.
fn has_lamps(scene: &Scene) -> bool {
    let sun = SUN_LUX as f32 / SKY_UNIT_NIT;
    scene.lights.iter().any(|light| light.kind != LightKind::Directional || light.intensity > sun)
}

/// Whether the environment is in the unit of daylight: the sky by day and by night, or a picture with a sun.
fn is_daylight(scene: &Scene, environment: Environment) -> bool {
    match environment {
        Environment::Sky => true,
        Environment::File => scene.environment.as_ref().is_some_and(|map| map.light.is_some()),
        _ => false,
    }
}

impl FrameRequest {
    /// What lights of `scene` are multiplied by where this request is metered, in stops.
    pub(crate) fn metered_lamp_stops(&self, scene: &Scene) -> f32 {
        let environment = &self.settings.environment;
        let source = environment.source.resolved(scene);
        let is_metered = matches!(self.settings.exposure.resolved(scene, source), Exposure::Auto { .. });
        let is_meant_so = scene.exposure_stops.is_some() || scene.holds_baked_light;
        let is_in_candela = scene.lights_are_photometric && has_lamps(scene);
        if !is_metered || is_meant_so || !is_in_candela || !is_daylight(scene, source) {
            return 0.0;
        }
        (environment.intensity.max(1.0) / SKY_UNIT_NIT).log2().min(0.0)
    }

    /// What lights of the scene are multiplied by.
    pub(crate) fn lamp_scale(&self) -> f32 {
        self.metering.map_or(1.0, |metering| metering.lamp_stops.exp2())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use manypass_scene::{EnvironmentLight, EnvironmentMap, Light};

    fn stops(scene: &Scene, source: Environment, intensity: f32, exposure: Exposure) -> f32 {
        let request = FrameRequest::of_scene(scene, 8, 8).with(|settings| {
            (settings.environment.source, settings.environment.intensity) = (source, intensity);
            settings.exposure.stops = exposure;
        });
        request.metered_lamp_stops(scene)
    }

    fn scene_with(kind: LightKind, intensity: f32) -> Scene {
        let lights = vec![Light { kind, intensity, ..Light::default() }];
        Scene { lights, lights_are_photometric: true, ..Scene::default() }
    }

    #[test]
    fn lamps_of_files_are_in_the_unit_of_daylight() {
        let lamp = scene_with(LightKind::Point, 100.0);
        let of_sky = |intensity: f32| stops(&lamp, Environment::Sky, intensity, Exposure::Scene);
        assert_eq!([0.0, 0.001, 1.0, 4.0, 32_768.0, 1e9].map(of_sky), [-15.0, -15.0, -15.0, -13.0, 0.0, 0.0]);
        let others = [Environment::None, Environment::Studio, Environment::Fill, Environment::File];
        assert_eq!(others.map(|source| stops(&lamp, source, 1.0, Exposure::Scene)), [0.0; 4]);
        let light = EnvironmentLight { direction: Vec3::Y, irradiance: Vec3::ONE, half_angle_tan: 0.005 };
        let sunny = EnvironmentMap { light: Some(light), ..EnvironmentMap::from_fn("sunny", 8, 4, |_| Vec3::ONE) };
        let sunny = Scene { environment: Some(sunny.into()), ..lamp.clone() };
        assert_eq!(stops(&sunny, Environment::File, 1.0, Exposure::Scene), -15.0);
        assert_eq!(stops(&sunny, Environment::Auto, 1.0, Exposure::Scene), -15.0);
    }

    #[test]
    fn what_is_meant_as_it_is_stays() {
        let lamp = scene_with(LightKind::Point, 100.0);
        let of = |scene: &Scene| stops(scene, Environment::Sky, 1.0, Exposure::AUTO);
        assert_eq!(of(&lamp), -15.0);
        assert_eq!(of(&Scene { lights_are_photometric: false, ..lamp.clone() }), 0.0);
        assert_eq!(of(&Scene { exposure_stops: Some(0.0), ..lamp.clone() }), 0.0);
        assert_eq!(of(&Scene { holds_baked_light: true, ..lamp.clone() }), 0.0);
        assert_eq!(stops(&lamp, Environment::Sky, 1.0, Exposure::Stops(0.0)), 0.0);
        // Sunlight is 3.9 in the unit of the sky.
        assert_eq!([3.0, 1366.0].map(|lux| of(&scene_with(LightKind::Directional, lux))), [0.0, -15.0]);
        assert_eq!(of(&Scene { lights_are_photometric: true, ..Scene::default() }), 0.0);
    }
}
