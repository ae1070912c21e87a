//! Settings of exposure, and how it is written.

use super::{Exposure, MeteringPattern};
use crate::environment::Environment;
use crate::setting::{SettingField, SettingInput, SettingType, SettingValue, SettingsError, settings};
use manypass_scene::Scene;
use std::fmt::{self, Display, Formatter};

settings! {
    /// Settings of exposure.
    pub struct ExposureSettings {
        /// The exposure: radiance is multiplied by 2 to the power of it. `auto` is metered. `scene` is what the scene
        /// states; else `auto` if the scene has lights, under the sky and in a picture; else 0.
        stops: Exposure = Exposure::Scene, unit "stops";
        /// The metering pattern: `average` counts all parts of the picture alike, `centre` by a bell curve around the
        /// middle, `spot` in a small disc there.
        metering: MeteringPattern = MeteringPattern::Average;
        /// Eye adaptation: the exposure of live views and sequences follows the average of each frame towards mid grey.
        /// A first frame begins adapted. Stills are metered as usual. `scene` then means `auto`.
        adapt: bool = false;
        /// The time constant of adaptation to stronger light: 1 / e of a difference is left after it.
        adapt_to_light_s: f32 = 0.4, in 0.01..=3600.0, unit "s", needs "exposure.adapt=true";
        /// The time constant of adaptation to weaker light.
        adapt_to_dark_s: f32 = 1.2, in 0.01..=3600.0, unit "s", needs "exposure.adapt=true";
        /// The lowest exposure of adaptation, before the stops that `auto` adds. Strong light stays brighter.
        adapt_min_stops: f32 = -24.0, in -48.0..=48.0, unit "stops", needs "exposure.adapt=true";
        /// The highest exposure of adaptation, before the stops that `auto` adds. Night stays darker.
        adapt_max_stops: f32 = 24.0, in -48.0..=48.0, unit "stops", needs "exposure.adapt=true";
    }
}

impl ExposureSettings {
    /// As [`Exposure::resolved`]; what adapts is metered.
    pub fn resolved(&self, scene: &Scene, environment: Environment) -> Exposure {
        match self.stops {
            Exposure::Scene if self.adapt => Exposure::AUTO,
            stops => stops.resolved(scene, environment),
        }
    }

    /// Checks whether they go together.
    ///
    /// # Errors
    /// An exposure that is given and shall adapt; limits the wrong way round.
    pub(crate) fn check(&self) -> Result<(), SettingsError> {
        if self.adapt && matches!(self.stops, Exposure::Stops(_)) {
            let key = "exposure.adapt=true".into();
            return Err(SettingsError::Needs { key, needs: "exposure.stops=auto", found: "a number of stops" });
        }
        if self.adapt && self.adapt_min_stops > self.adapt_max_stops {
            let (key, value) = ("exposure.adapt_min_stops".into(), self.adapt_min_stops.to_string());
            let expected = format!("no more than exposure.adapt_max_stops, which is {}", self.adapt_max_stops);
            return Err(SettingsError::BadValue { key, value, expected });
        }
        Ok(())
    }
}

/// As it is written: `auto+1`, `-2`.
impl Display for Exposure {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene => f.write_str("scene"),
            Self::Stops(stops) => stops.fmt(f),
            Self::Auto { compensation_stops } if *compensation_stops == 0.0 => f.write_str("auto"),
            Self::Auto { compensation_stops } => write!(f, "auto{compensation_stops:+}"),
        }
    }
}

impl SettingField for Exposure {
    fn kind() -> SettingType {
        SettingType::Exposure
    }

    fn choices() -> &'static [&'static str] {
        &["scene", "auto"]
    }

    fn read(written: &SettingInput) -> Option<Self> {
        written.text()?.parse().ok()
    }

    fn value(&self) -> SettingValue {
        if let Self::Stops(stops) = self { stops.value() } else { SettingValue::Text(self.to_string()) }
    }
}
