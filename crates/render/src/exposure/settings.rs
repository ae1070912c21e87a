//! Settings of exposure, and how it is written.

use super::Exposure;
use crate::setting::{SettingField, SettingType, SettingValue, Written, settings};
use std::fmt::{self, Display, Formatter};

settings! {
    /// Settings of exposure.
    pub struct ExposureSettings {
        /// What radiance is multiplied by, as a power of 2: stops, or `auto` (metered), or `scene`: what the scene
        /// states, else auto where it brings its own lights, else 0.
        stops: Exposure = Exposure::Scene, unit "stops";
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
