//! Lamps of a model file by day.
//!
//! `KHR_lights_punctual` is in candela and lux. Under the sky 1 stands for [`SKY_UNIT_NIT`], and a picture in which a
//! sun was found is taken for daylight in the same unit: lamps that were added as they are would be brighter than the
//! sun. So they are dimmed until the strongest gives the model half of what the sun does. They are divided by that unit
//! at the most: then they are as weak as such lamps are by day. The more `environment.intensity` is above 1, the nearer
//! both units are, and at [`SKY_UNIT_NIT`] lamps are added as they are.
//!
//! Lamps stay as they are:
//! - of stages and of scenes made by code, which are set by eye in the picture;
//! - where the file states an exposure, or holds light that was baked of them;
//! - where the exposure of the picture is given in stops;
//! - where all are directional and none is brighter than the sun: such files are not in lux.

use super::FrameRequest;
use crate::environment::Environment;
use crate::exposure::{Exposure, luminance};
use manypass_scene::sky::{SKY_UNIT_NIT, SUN_LUX};
use manypass_scene::{LightKind, NodeId, Scene};

/// What the sun gives a surface across its way at noon, in the unit of the sky.
const SUNLIGHT: f32 = SUN_LUX as f32 / SKY_UNIT_NIT;

/// Whether lights of a scene are lamps in candela, or brighter than the sun would be in the unit of the sky.
fn has_lamps(scene: &Scene) -> bool {
    scene.lights.iter().any(|light| light.kind != LightKind::Directional || light.intensity > SUNLIGHT)
}

/// A model is taken to stand at least so far from its lamps, as a share of the diagonal of its box.
const NEAR_SHARE: f32 = 0.25;
/// Of what the sun gives, what the strongest lamp does.
const LAMP_SHARE: f32 = 0.5;

/// What the strongest light gives the model, in lux: of points and spots at the nearest place of its box.
fn strongest_lux(scene: &Scene) -> f32 {
    let bounds = scene.bounds_world();
    let bounds = bounds.min.cmple(bounds.max).all().then_some(bounds);
    let near_m = bounds.map_or(1.0, |bounds| NEAR_SHARE * (bounds.max - bounds.min).length());
    let lux = |id: &NodeId| {
        let node = scene.node(*id);
        let light = scene.lights.get(node.light?)?;
        let strength = light.intensity * luminance(light.color_linear) as f32;
        if light.kind == LightKind::Directional {
            return Some(strength);
        }
        let place = node.world_from_object.w_axis.truncate();
        let nearest = bounds.map_or(place, |bounds| place.max(bounds.min).min(bounds.max));
        let distance_m = place.distance(nearest).max(near_m);
        Some(strength / (distance_m * distance_m))
    };
    scene.lit_nodes().iter().filter_map(lux).filter(|lux| lux.is_finite()).fold(0.0, f32::max)
}

/// What the sun gives a surface across its way, in the unit of the environment: that of noon under the sky.
fn sunlight(scene: &Scene, environment: Environment) -> f32 {
    let of_picture = scene.environment.as_ref().filter(|_| environment == Environment::File);
    let light = of_picture.and_then(|map| map.light.as_ref());
    light.map_or(SUNLIGHT, |light| luminance(light.irradiance) as f32)
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
        let least = (environment.intensity.max(1.0) / SKY_UNIT_NIT).log2().min(0.0);
        let wanted = LAMP_SHARE * sunlight(scene, source) * environment.intensity;
        (wanted / strongest_lux(scene).max(1e-30)).max(1e-30).log2().clamp(least, 0.0)
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
    use manypass_scene::{EnvironmentLight, EnvironmentMap, Light, Node};

    fn stops(scene: &Scene, source: Environment, intensity: f32, exposure: Exposure) -> f32 {
        let request = FrameRequest::of_scene(scene, 8, 8).with(|settings| {
            (settings.environment.source, settings.environment.intensity) = (source, intensity);
            settings.exposure.stops = exposure;
        });
        request.metered_lamp_stops(scene)
    }

    fn scene_with(kind: LightKind, intensity: f32) -> Scene {
        let lights = vec![Light { kind, intensity, ..Light::default() }];
        // Without a model it counts at a metre.
        let nodes = vec![Node { light: Some(0), ..Node::default() }];
        let roots = vec![NodeId(0)];
        let mut scene = Scene { lights, nodes: nodes.into(), roots, lights_are_photometric: true, ..Scene::default() };
        scene.update_transforms();
        scene
    }

    #[test]
    fn lamps_of_files_are_in_the_unit_of_daylight() {
        let lamp = scene_with(LightKind::Point, 125.0);
        let strong = scene_with(LightKind::Point, 1e9);
        let of_sky =
            |intensity: f32| [&lamp, &strong].map(|lamp| stops(lamp, Environment::Sky, intensity, Exposure::Scene));
        // Half of the sun's 3.906 is a 64th of 125.
        for (intensity, expected) in [(0.0, -15.0), (1.0, -6.0), (4.0, -4.0), (64.0, 0.0), (32_768.0, 0.0), (1e9, 0.0)]
        {
            assert!((of_sky(intensity)[0] - expected).abs() < 0.01, "{intensity}: {:?}", of_sky(intensity));
        }
        assert_eq!([1.0, 4.0, 32_768.0].map(|intensity| of_sky(intensity)[1]), [-15.0, -13.0, 0.0]);
        let others = [Environment::None, Environment::Studio, Environment::Fill, Environment::File];
        assert_eq!(others.map(|source| stops(&lamp, source, 1.0, Exposure::Scene)), [0.0; 4]);
        let light = EnvironmentLight { direction: Vec3::Y, irradiance: Vec3::ONE, half_angle_tan: 0.005 };
        let sunny = EnvironmentMap { light: Some(light), ..EnvironmentMap::from_fn("sunny", 8, 4, |_| Vec3::ONE) };
        let sunny = Scene { environment: Some(sunny.into()), ..lamp.clone() };
        // Half of 1 is a 250th.
        for source in [Environment::File, Environment::Auto] {
            assert!((stops(&sunny, source, 1.0, Exposure::Scene) + 250f32.log2()).abs() < 0.01);
        }
    }

    #[test]
    fn what_is_meant_as_it_is_stays() {
        let lamp = scene_with(LightKind::Point, 100.0);
        let of = |scene: &Scene| stops(scene, Environment::Sky, 1.0, Exposure::AUTO);
        assert!(of(&lamp) < -5.0);
        assert_eq!(of(&Scene { lights_are_photometric: false, ..lamp.clone() }), 0.0);
        assert_eq!(of(&Scene { exposure_stops: Some(0.0), ..lamp.clone() }), 0.0);
        assert_eq!(of(&Scene { holds_baked_light: true, ..lamp.clone() }), 0.0);
        assert_eq!(stops(&lamp, Environment::Sky, 1.0, Exposure::Stops(0.0)), 0.0);
        // Sunlight is 3.9 in the unit of the sky.
        let [weak, strong] = [3.0, 1e4].map(|lux| of(&scene_with(LightKind::Directional, lux)));
        assert!(weak == 0.0 && (strong - (1.953f32 / 1e4).log2()).abs() < 0.01, "{weak}, {strong}");
        assert_eq!(of(&Scene { lights_are_photometric: true, ..Scene::default() }), 0.0);
    }
}
