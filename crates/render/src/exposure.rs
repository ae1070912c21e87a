//! Exposure: what a picture's radiance is multiplied by, given in stops or found by metering.
//!
//! # The curve
//! Let x be the log-average luminance of what is metered, in stops above mid grey (0.18). Within half a stop nothing
//! changes. Beyond, of the t = |x| − 0.5 stops that exceed it, t / (1 + t) remain: the level of the picture rises with
//! the level of the light, so that night stays darker than day, and ends at 1.5 stops from mid grey: surfaces of the
//! mean reflectance can be told from black and from white. It is continuous, and so is its slope.
//!
//! Under the sky and in a picture x is that of the environment, and the surfaces move the exposure by half a stop, or by
//! more where the environment is hardly seen: `exposure/anchor.rs` has the rule.

mod adaptation;
mod anchor;
mod settings;

pub(crate) use anchor::{Anchor, HIGHLIGHT_SHARES, color_excess_stops, highlight_excess_stops, luminance};

pub use adaptation::{Adaptation, MeteringPattern};
pub use settings::ExposureSettings;

use crate::environment::Environment;
use manypass_scene::Scene;
use std::str::FromStr;

/// The luminance of mid grey: what reflects 18 % of the light reads as halfway between black and white.
pub const MID_GREY: f64 = 0.18;

/// So many stops from mid grey nothing changes.
const UNCHANGED_STOPS: f64 = 0.5;

/// So many stops from mid grey half floats need no other scale.
const UNSCALED_STOPS: f64 = 2.0;

/// The shares of dark surfaces between which the faint studio becomes the whole one.
const UNLIT_SHARES: [f32; 2] = [0.5, 0.85];

/// The exposure of a picture: in stops, metered, or from the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Exposure {
    /// As [`Self::of_scene`] says.
    #[default]
    Scene,
    /// Radiance is multiplied by 2 to the power of this; 0 leaves it as it is.
    Stops(f32),
    /// By metering ([`crate::Renderer::meter`]).
    Auto {
        /// Stops on top of what was metered.
        compensation_stops: f32,
    },
}

impl Exposure {
    /// Metering without compensation.
    pub const AUTO: Self = Self::Auto { compensation_stops: 0.0 };

    /// The exposure of `scene` where nobody says: what it states, else metered where it brings its own lights, else 0.
    pub fn of_scene(scene: &Scene) -> Self {
        match (scene.exposure_stops, Environment::of_scene(scene)) {
            (Some(stops), _) => Self::Stops(stops),
            (None, Environment::Fill) => Self::AUTO,
            (None, _) => Self::Stops(0.0),
        }
    }

    /// With [`Self::Scene`] as it is for `scene` in an environment: under the sky, whose light is many times as bright
    /// at noon as in the evening, and in a picture, whose unit is whatever its maker took, it is metered, too, unless the
    /// scene states one.
    pub fn resolved(self, scene: &Scene, environment: Environment) -> Self {
        match (self, scene.exposure_stops, environment.resolved(scene)) {
            (Self::Scene, None, Environment::Sky | Environment::File) => Self::AUTO,
            (Self::Scene, ..) => Self::of_scene(scene),
            _ => self,
        }
    }

    /// The stops that it comes to; one that was not resolved with its scene, or is no number, comes to 0.
    pub fn stops(self, metering: Option<&Metering>) -> f32 {
        let stops = match self {
            Self::Scene => 0.0,
            Self::Stops(stops) => stops,
            Self::Auto { compensation_stops } => metering.map_or(0.0, |metering| metering.stops) + compensation_stops,
        };
        if stops.is_nan() { 0.0 } else { stops }
    }

    /// `auto` or `stops`; `scene` if it was not resolved.
    pub fn mode(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Stops(_) => "stops",
            Self::Auto { .. } => "auto",
        }
    }
}

/// A text is no exposure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "`{0}` is not an exposure: expected stops from -64 to 64, scene, auto, or auto with stops such as auto+1 or auto-0.5"
)]
#[non_exhaustive]
pub struct ExposureError(String);

impl FromStr for Exposure {
    type Err = ExposureError;

    fn from_str(text: &str) -> Result<Self, ExposureError> {
        let in_range = |stops: &f64| stops.abs() <= 64.0;
        let stops = |text: &str| text.parse().ok().filter(in_range).map(|stops| stops as f32);
        // As the schema of settings says it: digits, with a dot or without.
        let is_plain = |text: &str| text.bytes().all(|letter| letter.is_ascii_digit() || letter == b'.');
        let exposure = match text.trim().strip_prefix("auto") {
            None if text.trim() == "scene" => Some(Self::Scene),
            None => stops(text.trim()).map(Self::Stops),
            Some("") => Some(Self::AUTO),
            Some(rest) if rest.strip_prefix(['+', '-']).is_some_and(is_plain) => {
                stops(rest).map(|compensation_stops| Self::Auto { compensation_stops })
            }
            Some(_) => None,
        };
        exposure.ok_or_else(|| ExposureError(text.to_owned()))
    }
}

/// The result of metering by [`crate::Renderer::meter`].
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Metering {
    /// The log-average luminance of the surfaces, in the unit of radiance (Rec. 709 weights). Pixels count by their
    /// coverage, and by L / (L + A / 64) with their luminance L and the mean A of all: surfaces that no light reaches
    /// do not count. In A a pixel counts up to four times what 99 % of them do not exceed, so that mirrored lamps of a
    /// pixel change nothing. None if no light is seen at all.
    pub log_average_luminance: Option<f64>,
    /// The largest component of radiance that was seen.
    pub peak: f64,
    /// The share of the pixels that show a surface.
    pub surface_share: f64,
    /// The share of the surfaces that is darker than 16 of 255 in the picture that automatic exposure makes: so dark
    /// that nothing can be told apart.
    pub dark_share: f64,
    /// What automatic exposure multiplies by, in stops. Under the sky and in a picture it is that of the environment,
    /// which the surfaces move within bounds.
    pub stops: f32,
    /// What radiance is multiplied by, in stops, while it is in half floats, and divided by afterwards. A whole number,
    /// so that nothing is lost.
    pub pre_exposure_stops: i32,
    /// What lights of the scene are multiplied by, in stops: below 0 for lamps of a model file by day, which are in
    /// candela where 1 stands for thousands of cd/m² (docs/exposure.md).
    pub lamp_stops: f32,
}

/// The level of the picture, in stops above mid grey, of light that is `stops` above it.
pub fn picture_level_stops(stops: f64) -> f64 {
    let excess = stops.abs() - UNCHANGED_STOPS;
    if excess <= 0.0 { stops } else { stops.signum() * (UNCHANGED_STOPS + excess / (1.0 + excess)) }
}

/// Above this the metered peak is brought down, so that sparks that metering missed have room: ten times below the
/// limit.
const PRE_EXPOSED_PEAK: f64 = 2048.0;

/// At most so many stops below what the average asks for: mid grey is then 7e-4, and what is three stops darker is
/// still held with all bits of a half float.
const PEAK_STOPS_MAX: i32 = 8;

impl Metering {
    /// From the log-average luminance, if there is light, the largest component of radiance and the share of surfaces.
    pub(crate) fn new(log_average_luminance: Option<f64>, peak: f64, surface_share: f64) -> Self {
        let level = log_average_luminance.map_or(0.0, |average| (average / MID_GREY).log2());
        let wanted = if level.abs() <= UNSCALED_STOPS { 0 } else { -level.round() as i32 };
        let room = if peak > 0.0 { (PRE_EXPOSED_PEAK / peak).log2().floor() as i32 } else { wanted };
        Self {
            log_average_luminance,
            peak,
            surface_share,
            dark_share: 0.0,
            stops: (picture_level_stops(level) - level) as f32,
            pre_exposure_stops: wanted.min(room.max(wanted - PEAK_STOPS_MAX)).clamp(-100, 100),
            lamp_stops: 0.0,
        }
    }
}

impl Metering {
    /// What is darker than this in the picture counts as dark: 16 of 255 in sRGB, as luminance.
    pub(crate) const DARK: f64 = 0.005_182;

    /// How far lamps leave a scene unlit: 0 where they light half of it or more, 1 where nearly nothing.
    pub(crate) fn unlit(&self) -> f32 {
        let [some, most] = UNLIT_SHARES;
        let along = ((self.dark_share as f32 - some) / (most - some)).clamp(0.0, 1.0);
        along * along * (3.0 - 2.0 * along)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    #[test]
    fn the_curve_is_as_stated() {
        for stops in [-0.5, -0.3, 0.0, 0.4, 0.5] {
            assert_eq!(picture_level_stops(stops), stops);
        }
        let mut last = f64::NEG_INFINITY;
        for i in -4000..=4000 {
            let (x, step) = (f64::from(i) / 100.0, 0.01);
            let level = picture_level_stops(x);
            assert!(level > last && level - last <= 1.0001 * step || i == -4000, "{x}: {last} to {level}");
            assert_eq!(picture_level_stops(-x), -level);
            last = level;
        }
        // Ten stops over come to 0.5 + 9.5 / 10.5.
        assert!((picture_level_stops(10.0) - 1.404_762).abs() < 1e-6);
        assert!(picture_level_stops(40.0) < 1.5);
    }

    #[test]
    fn exposures_are_read() {
        assert_eq!("auto".parse(), Ok(Exposure::AUTO));
        assert_eq!("auto+1".parse(), Ok(Exposure::Auto { compensation_stops: 1.0 }));
        assert_eq!("auto-0.5".parse(), Ok(Exposure::Auto { compensation_stops: -0.5 }));
        assert_eq!("-2".parse(), Ok(Exposure::Stops(-2.0)));
        assert_eq!("scene".parse(), Ok(Exposure::Scene));
        for exposure in
            [Exposure::Scene, Exposure::AUTO, Exposure::Stops(0.1), Exposure::Auto { compensation_stops: -0.7 }]
        {
            assert_eq!(exposure.to_string().parse(), Ok(exposure));
        }
        for wrong in ["", "auto1", "auto+", "nan", "auto+nan", "65", "automatic", "auto+-1x"] {
            assert!(wrong.parse::<Exposure>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_the_sky_or_a_picture_lights_is_metered_unless_the_scene_states_an_exposure() {
        let plain = Scene::default();
        let stated = Scene { exposure_stops: Some(1.5), ..Scene::default() };
        for environment in [Environment::Sky, Environment::File] {
            assert_eq!(Exposure::Scene.resolved(&plain, environment), Exposure::AUTO);
            assert_eq!(Exposure::Scene.resolved(&stated, environment), Exposure::Stops(1.5));
            assert_eq!(Exposure::Stops(2.0).resolved(&plain, environment), Exposure::Stops(2.0));
        }
        assert_eq!(Exposure::Scene.resolved(&plain, Environment::Studio), Exposure::Stops(0.0));
    }

    #[test]
    fn what_lamps_leave_dark_is_lit_by_the_studio() {
        let unlit = |dark_share| Metering { dark_share, ..Metering::default() }.unlit();
        assert_eq!([0.0, 0.3, 0.5].map(unlit), [0.0; 3], "as faint as stated where lamps light half of it");
        assert_eq!([0.85, 1.0].map(unlit), [1.0; 2]);
        assert!(unlit(0.6) > 0.0 && unlit(0.6) < unlit(0.7));
    }

    #[test]
    fn pre_exposure_brings_the_average_to_grey_and_leaves_room_for_the_peak() {
        let stops = |average: f64, peak: f64| Metering::new(Some(average), peak, 1.0).pre_exposure_stops;
        assert_eq!(stops(0.18, 1.0), 0, "nothing changes where half floats do");
        assert_eq!(stops(0.18 * 1024.0, 500.0), -10);
        assert_eq!(stops(0.18 / 1024.0, 0.01), 10);
        // A peak of 2^13 pulls down by 2, and one beyond reach by no more than 8.
        assert_eq!(stops(0.18, 8192.0), -2);
        assert_eq!(stops(0.18, 1e9), -8);
        let nothing = Metering::new(None, 0.0, 0.3);
        assert_eq!((nothing.stops, nothing.pre_exposure_stops), (0.0, 0));
    }
}
