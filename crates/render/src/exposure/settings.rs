//! Settings of exposure, and how it is written.

use super::{Exposure, MeteringPattern};
use crate::environment::Environment;
use crate::setting::{SettingField, SettingType, SettingValue, SettingsError, Written, settings};
use manypass_scene::Scene;
use std::fmt::{self, Display, Formatter};

settings! {
    /// Settings of exposure.
    pub struct ExposureSettings {
        /// What radiance is multiplied by, as a power of 2: stops, or `auto` (metered), or `scene`: what the scene
        /// states, else auto where it brings its own lights, under the sky and in a picture, else 0.
        stops: Exposure = Exposure::Scene, unit "stops";
        /// Which parts of the picture count for an exposure that is metered: average is all alike, centre a bell curve
        /// around the middle, spot a small disc there.
        metering: MeteringPattern = MeteringPattern::Average;
        /// Whether the exposure of live views and sequences goes on from frame to frame, as eyes adapt: it approaches what
        /// brings the average of each frame to mid grey. A first frame begins adapted; a still is metered as ever. `scene`
        /// is then auto.
        adapt: bool = false;
        /// The time in which all but 1 / e of a difference is made up for where the light becomes stronger.
        adapt_to_light_s: f32 = 0.4, in 0.01..=3600.0, unit "s", needs "exposure.adapt=true";
        /// The same where it becomes weaker.
        adapt_to_dark_s: f32 = 1.2, in 0.01..=3600.0, unit "s", needs "exposure.adapt=true";
        /// The least that exposure adapts to, before the stops that `auto` has on top: strong light stays brighter.
        adapt_min_stops: f32 = -24.0, in -48.0..=48.0, unit "stops", needs "exposure.adapt=true";
        /// The most that it adapts to: night stays darker.
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

    fn read(written: &Written) -> Option<Self> {
        written.text()?.parse().ok()
    }

    fn value(&self) -> SettingValue {
        if let Self::Stops(stops) = self { stops.value() } else { SettingValue::Text(self.to_string()) }
    }
}
