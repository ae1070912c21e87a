//! The light of the environment by direction, for who computes light without a device.

use super::{Environment, EnvironmentSettings, studio};
use glam::Vec3;
use manypass_scene::{EnvironmentLight, EnvironmentMap, Scene};
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::sync::Arc;

/// The radiance of the environment from each direction, as used in frames.
#[derive(Clone, Debug)]
pub struct EnvironmentRadiance {
    from: RadianceSource,
    intensity: f32,
    /// Cosine and sine of the rotation.
    turn: [f32; 2],
}

#[derive(Clone, Debug)]
enum RadianceSource {
    Color(Vec3),
    Studio,
    Picture(Arc<EnvironmentMap>, HashMap<u32, Vec3>),
}

impl EnvironmentRadiance {
    /// That of `settings` for a scene; none where no light comes from it. [`Environment::Fill`], whose level follows the
    /// exposure of a picture, gives none: it is there so that one sees what light leaves dark, and is no light.
    pub fn new(settings: &EnvironmentSettings, scene: &Scene) -> Option<Self> {
        let picture = |map: Arc<EnvironmentMap>| {
            let peaks = map.peaks.iter().copied().collect();
            RadianceSource::Picture(map, peaks)
        };
        let from = match settings.source.resolved(scene) {
            Environment::None | Environment::Fill => return None,
            Environment::Color(color) => RadianceSource::Color(Vec3::from(color)),
            Environment::Sky => picture(Arc::new(settings.sky()?.map())),
            Environment::File => picture(scene.environment.clone()?),
            Environment::Auto | Environment::Studio => RadianceSource::Studio,
        };
        let (sin, cos) = settings.rotation_deg.to_radians().sin_cos();
        let intensity = settings.intensity;
        (intensity > 0.0).then_some(Self { from, intensity, turn: [cos, sin] })
    }

    /// The radiance that comes from a direction of length 1, without that of [`Self::light`].
    pub fn at(&self, direction: Vec3) -> Vec3 {
        let [cos, sin] = self.turn;
        let radiance = match &self.from {
            RadianceSource::Color(color) => *color,
            RadianceSource::Studio => Vec3::splat(studio::radiance(direction)),
            RadianceSource::Picture(map, peaks) => {
                let Vec3 { x, y, z } = direction;
                texel(map, peaks, Vec3::new(cos * x - sin * z, y, sin * x + cos * z))
            }
        };
        radiance * self.intensity
    }

    /// A number that is another one where other light comes from it.
    pub fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        [self.intensity, self.turn[0], self.turn[1]].map(f32::to_bits).hash(&mut hasher);
        match &self.from {
            RadianceSource::Color(color) => color.to_array().map(f32::to_bits).hash(&mut hasher),
            RadianceSource::Studio => hasher.write(b"studio"),
            RadianceSource::Picture(map, _) => {
                (map.width, map.height, map.light.is_some()).hash(&mut hasher);
                hasher.write(bytemuck::cast_slice(&map.texels));
                let peaks = map.peaks.iter();
                peaks.for_each(|(index, beyond)| (index, beyond.to_array().map(f32::to_bits)).hash(&mut hasher));
            }
        }
        hasher.finish()
    }

    /// A light that belongs to it and that frames draw as one, with shadows: of the sky the sun, of the studio its key.
    pub fn light(&self) -> Option<EnvironmentLight> {
        let light = match &self.from {
            RadianceSource::Color(_) => None,
            RadianceSource::Studio => Some(studio::key_light()),
            RadianceSource::Picture(map, _) => map.light,
        }?;
        let is_picture = matches!(self.from, RadianceSource::Picture(..));
        let [cos, sin] = if is_picture { self.turn } else { [1.0, 0.0] };
        let Vec3 { x, y, z } = light.direction;
        let direction = Vec3::new(cos * x + sin * z, y, cos * z - sin * x);
        Some(EnvironmentLight { direction, irradiance: light.irradiance * self.intensity, ..light })
    }
}

/// The texel of an equirectangular picture in a direction, the middle of a sun as bright as it is.
fn texel(map: &EnvironmentMap, peaks: &HashMap<u32, Vec3>, direction: Vec3) -> Vec3 {
    let u = 0.5 + direction.z.atan2(direction.x) / TAU;
    let v = direction.y.clamp(-1.0, 1.0).acos() / PI;
    let x = ((u * map.width as f32) as u32).min(map.width.saturating_sub(1));
    let y = ((v * map.height as f32) as u32).min(map.height.saturating_sub(1));
    let index = y * map.width + x;
    let texel = map.texels.get(index as usize).copied().unwrap_or_default();
    let [r, g, b, _] = texel.map(half::f16::to_f32);
    Vec3::new(r, g, b) + peaks.get(&index).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_turned_as_frames_turn_them() {
        // One texel shines: that of +Z.
        let map = EnvironmentMap::from_fn("z", 64, 32, |to| Vec3::splat(if to.z > 0.99 { 8.0 } else { 0.0 }));
        let scene = Scene { environment: Some(Arc::new(map)), ..Scene::default() };
        let settings = |rotation_deg| EnvironmentSettings { rotation_deg, intensity: 0.5, ..Default::default() };
        let of = |rotation_deg| EnvironmentRadiance::new(&settings(rotation_deg), &scene).unwrap();
        assert_eq!(of(0.0).at(Vec3::Z), Vec3::splat(4.0));
        assert_eq!(of(0.0).at(Vec3::X), Vec3::ZERO);
        // Counter-clockwise seen from above, +Z goes to +X.
        assert_eq!(of(90.0).at(Vec3::X), Vec3::splat(4.0));
        assert_eq!(of(90.0).at(Vec3::Z), Vec3::ZERO);
    }

    #[test]
    fn what_has_no_light_is_none() {
        let none = EnvironmentSettings { source: Environment::None, ..Default::default() };
        assert!(EnvironmentRadiance::new(&none, &Scene::default()).is_none());
        let studio = EnvironmentRadiance::new(&EnvironmentSettings::default(), &Scene::default()).unwrap();
        assert!(studio.at(Vec3::Y).x > 0.0 && studio.light().is_some());
    }
}
