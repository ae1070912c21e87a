//! What a request says of exposure and of the level of the environment.

use super::FrameRequest;
use crate::colour::finite_product;
use crate::environment::picture::EnvironmentTiles;
use crate::environment::studio::WITHOUT_KEY_LIGHT;
use crate::environment::{Background, Environment, EnvironmentUniform, FILL_BACKDROP_SHARE, FILL_SHARE, PlacedPicture};
use crate::exposure::{Adaptation, Exposure, Metering};
use crate::passes::meter::AdaptationStep;
use glam::Quat;
use manypass_scene::EnvironmentLight;

impl FrameRequest {
    /// Whether [`Self::metering`] decides anything: automatic exposure, the faint studio beside the scene's own lights,
    /// and radiance that will be read go by it.
    pub fn needs_metering(&self, exposure: Exposure) -> bool {
        let has_fill = self.settings.environment.source == Environment::Fill;
        matches!(exposure, Exposure::Auto { .. }) || has_fill || self.averages_radiance()
    }

    /// Puts `exposure` and what was metered into the request. Under a given exposure lamps are as they are.
    pub fn expose(&mut self, exposure: Exposure, metering: Option<Metering>) {
        let is_auto = matches!(exposure, Exposure::Auto { .. });
        let lamps = |metering: Metering| if is_auto { metering.lamp_stops } else { 0.0 };
        self.settings.exposure.stops = exposure;
        self.metering = metering.map(|metering| Metering { lamp_stops: lamps(metering), ..metering });
    }

    /// Radiance is multiplied by 2 to the power of this for the picture; 0 leaves it as it is.
    pub fn exposure_stops(&self) -> f32 {
        self.settings.exposure.stops.stops(self.metering.as_ref())
    }

    /// Radiance in the frame is multiplied by this.
    pub fn pre_exposure(&self) -> f32 {
        let stops = self.metering.map_or(self.exposure_stops(), |metering| metering.pre_exposure_stops as f32);
        stops.clamp(-100.0, 100.0).exp2()
    }

    /// From pre-exposed radiance to what the tone curve takes.
    pub(crate) fn display_exposure(&self) -> f32 {
        match self.metering {
            None => 1.0,
            Some(metering) => (self.exposure_stops() - metering.pre_exposure_stops as f32).clamp(-120.0, 120.0).exp2(),
        }
    }

    /// The background, and what a colour of it is multiplied by to be the radiance that this exposure shows with its
    /// value.
    pub(crate) fn background_radiance(&self) -> (Background, f32) {
        (self.settings.background.source, (-self.exposure_stops()).clamp(-120.0, 120.0).exp2())
    }

    /// What light of the environment and what the camera sees of it are multiplied by: its intensity, and what makes it
    /// faint where it is a fill.
    fn environment_scales(&self) -> [f32; 2] {
        let environment = &self.settings.environment;
        let (light, backdrop) = match (environment.source, self.metering) {
            (Environment::Fill, Some(Metering { log_average_luminance: None, .. })) => (WITHOUT_KEY_LIGHT, 1.0),
            (Environment::Fill, metering) => {
                let level = metering.map_or(1.0, |metering| (-metering.stops).exp2());
                let unlit = metering.map_or(0.0, |metering| metering.unlit());
                let share = |least: f32| least + (1.0 - least) * unlit;
                (WITHOUT_KEY_LIGHT * share(FILL_SHARE) * level, share(FILL_BACKDROP_SHARE) * level)
            }
            _ => (1.0, 1.0),
        };
        [light, backdrop].map(|scale| scale * environment.intensity)
    }

    /// The light that an environment brings, turned and scaled as that is; none where it gives no light.
    pub(crate) fn environment_light(&self, light: &EnvironmentLight) -> Option<EnvironmentLight> {
        let [scale, _] = self.environment_scales();
        let irradiance = light.irradiance.map(|value| finite_product(value, scale));
        let direction = Quat::from_rotation_y(self.settings.environment.rotation_deg.to_radians()) * light.direction;
        (irradiance.max_element() > 0.0).then_some(EnvironmentLight { direction, irradiance, ..*light })
    }

    /// The uniform of the environment: pre-exposed, and faint where it is a fill.
    pub(crate) fn environment_uniform(&self, tiles: Option<&EnvironmentTiles>) -> EnvironmentUniform {
        let environment = &self.settings.environment;
        let [light, backdrop] = self.environment_scales().map(|scale| scale * self.pre_exposure());
        let (rotation_deg, blur) = (environment.rotation_deg, self.settings.background.blur);
        let mut uniform = EnvironmentUniform::new(environment.source, light, backdrop);
        if let Some(tiles) = tiles {
            PlacedPicture { tiles, rotation_deg, blur }.place(&mut uniform, light, backdrop);
        }
        uniform
    }

    /// Whether exposure goes on from that of the view's last picture.
    pub fn adapts(&self) -> bool {
        let exposure = &self.settings.exposure;
        let is_asked = exposure.adapt && self.adaptation != Adaptation::Still;
        is_asked && matches!(exposure.stops, Exposure::Auto { .. })
    }

    /// How it does, after a frame of the view that did, if there was one. Samples of a still have one exposure, that of
    /// the first; those of a live view are frames that follow each other.
    pub(crate) fn adapting(&self, is_after_another: bool) -> Option<AdaptationStep> {
        let exposure = &self.settings.exposure;
        let secs = match self.adaptation {
            Adaptation::After { secs } => secs.max(0.0),
            Adaptation::Still | Adaptation::Begins => 0.0,
        };
        let is_held = is_after_another && self.sample_index > 0 && !self.goes_on;
        let keep = [exposure.adapt_to_light_s, exposure.adapt_to_dark_s].map(|time_s| (-secs / time_s).exp());
        let is_first = self.adaptation == Adaptation::Begins && self.sample_index == 0;
        self.adapts().then(|| AdaptationStep {
            pattern: exposure.metering as u32,
            radius: exposure.metering.radius(),
            pre_exposure_stops: self.pre_exposure().log2(),
            stops: [exposure.adapt_min_stops, exposure.adapt_max_stops],
            keep: (!is_held).then_some(keep),
            begins: is_first || !is_after_another,
        })
    }

    /// From pre-exposed radiance to what the tone curve takes: all of it, or where exposure adapts all but what the
    /// frame finds by itself.
    pub(crate) fn known_exposure(&self) -> f32 {
        match self.settings.exposure.stops {
            compensation @ Exposure::Auto { .. } if self.adapts() => {
                (compensation.stops(None) - self.pre_exposure().log2()).clamp(-120.0, 120.0).exp2()
            }
            _ => self.display_exposure(),
        }
    }
}
