//! Exposure under the sky and in a picture: that of the environment, which the surfaces move within bounds.
//!
//! # The rule
//! M is the mean luminance of the environment over all directions, its sun included. A white matte ball has it on the
//! average of its surface. A surface of twice mid grey has 0.36 M there, x = log2(0.36 M / 0.18) stops above mid
//! grey. The curve of [`super`] turns x into A stops, the exposure of the environment. The surfaces alone ask for d
//! stops more than A. Of these d / (1 + 2 |d|) remain: half a stop at most. So all models have about the same
//! backdrop.
//!
//! - The sky: its unit has full daylight near x = 0, where the curve leaves it as dark as mid grey. The curve takes
//!   x + 0.5 there: by day that is half a stop more, at night next to nothing.
//! - Rooms: where less than a tenth of the picture shows the environment, more of d remains; where nothing shows it,
//!   all.
//! - Lamps at night: x is then below −4, and surfaces that outshine the environment have a d below −2. More of d
//!   remains, and all of it from x = −8 and d = −4 on. By day lamps count as other surfaces and as highlights do.
//! - Saturated colours: the tone curve makes them pale where their largest component passes white. A pixel asks for
//!   as many stops less as its largest component exceeds 1 by, but for no more than it exceeds the pixel's luminance
//!   by, less half a stop: what is nearly grey asks for none. The mean over the surfaces is taken off, down to A − 1.
//! - Highlights: where more than 3 % of the surfaces would be above white, the exposure is lower. Each pixel of the band
//!   that follows, from the brightest 3 % to the brightest 6 % of the surfaces, asks for as many stops less as its
//!   luminance exceeds 1 by, 1.5 at most. The mean over the band is taken off. In rooms, and for lamps at night, less
//!   of it is, by the share that the environment counts by.

use super::{MID_GREY, picture_level_stops};
use glam::Vec3;

/// The reflectance whose luminance in the mean light of the environment is its level: twice mid grey.
const REFLECTANCE: f64 = 2.0 * MID_GREY;

/// The environment counts in full where so large a share of the picture shows it.
const SEEN_SHARE: f64 = 0.1;

/// The levels of the environment between which it becomes night.
const NIGHT_STOPS: [f64; 2] = [-4.0, -8.0];

/// The differences between which surfaces are lit by lamps rather than by the environment.
const LAMP_STOPS: [f64; 2] = [-2.0, -4.0];

/// The largest component of a pale colour exceeds its luminance by so many stops at most.
const PALE_STOPS: f64 = 0.5;

/// The shares of the surfaces, from the brightest on, between which highlights lower the exposure: sparks and small
/// lamps take up less than the first. A band and not one place, so that a highlight that grows slowly moves it slowly.
pub(crate) const HIGHLIGHT_SHARES: [f64; 2] = [0.03, 0.06];

/// A pixel that is brighter than white asks for so many stops less at most.
const HIGHLIGHT_STOPS_MAX: f64 = 1.5;

/// By so many stops the curve takes the sky for brighter than mid grey.
const DAYLIGHT_STOPS: f64 = 0.5;

/// Saturated colours lower the exposure to so many stops from that of the environment.
const COLOR_STOPS_MIN: f64 = -1.0;

/// Rec. 709 luminance.
pub(crate) fn luminance(radiance: Vec3) -> f64 {
    let [r, g, b] = radiance.to_array().map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// A smooth step from 0 at the first to 1 at the second.
fn smooth([from, to]: [f64; 2], at: f64) -> f64 {
    let along = ((at - from) / (to - from)).clamp(0.0, 1.0);
    along * along * (3.0 - 2.0 * along)
}

/// The level of the environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Anchor {
    /// In stops above mid grey.
    level_stops: f64,
    /// By how much more the curve takes it for.
    lift_stops: f64,
}

impl Anchor {
    /// Of the mean radiance over all directions; none where that is no light.
    pub fn new(mean_radiance: Vec3, intensity: f32) -> Option<Self> {
        let level_stops = (luminance(mean_radiance) * f64::from(intensity) * REFLECTANCE / MID_GREY).log2();
        level_stops.is_finite().then_some(Self { level_stops, lift_stops: 0.0 })
    }

    /// The same where it is the sky's.
    pub fn of_sky(self) -> Self {
        Self { lift_stops: DAYLIGHT_STOPS, ..self }
    }

    /// The exposure of the environment.
    fn stops(self) -> f64 {
        picture_level_stops(self.level_stops + self.lift_stops) - self.level_stops
    }

    /// How far it counts for surfaces that ask for so many stops more.
    fn share(self, difference: f64, surface_share: f64) -> f64 {
        let seen = smooth([0.0, SEEN_SHARE], 1.0 - surface_share);
        seen * (1.0 - smooth(NIGHT_STOPS, self.level_stops) * smooth(LAMP_STOPS, difference))
    }

    /// How many stops more surfaces ask for that ask for `stops`, if any light is seen of them.
    fn difference(self, stops: Option<f64>) -> f64 {
        stops.map_or(0.0, |stops| stops - self.stops())
    }

    /// The exposure with surfaces that ask for `stops`, if any light is seen of them, before their colours count.
    pub fn moved(self, stops: Option<f64>, surface_share: f64) -> f64 {
        let difference = self.difference(stops);
        let least = difference / (1.0 + 2.0 * difference.abs());
        self.stops() + difference + (least - difference) * self.share(difference, surface_share)
    }

    /// The share of the stops that highlights ask for by which surfaces are darkened that ask for `stops`.
    pub fn highlight_share(self, stops: Option<f64>, surface_share: f64) -> f64 {
        self.share(self.difference(stops), surface_share)
    }

    /// An exposure with the mean of [`color_excess_stops`] taken off.
    pub fn lowered(self, stops: f64, excess_stops: f64) -> f64 {
        (stops - excess_stops).max(stops.min(self.stops() + COLOR_STOPS_MIN))
    }
}

/// The stops less that a pixel of this luminance and largest component asks for, where white is 1.
pub(crate) fn color_excess_stops(luminance: f64, largest: f64) -> f64 {
    if luminance > 0.0 { ((largest / luminance).log2() - PALE_STOPS).min(largest.log2()).max(0.0) } else { 0.0 }
}

/// The stops less that a pixel of this luminance asks for, where white is 1.
pub(crate) fn highlight_excess_stops(luminance: f64) -> f64 {
    if luminance > 1.0 { luminance.log2().min(HIGHLIGHT_STOPS_MAX) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    /// An environment whose level is so many stops.
    fn at(level_stops: f64) -> Anchor {
        Anchor { level_stops, lift_stops: 0.0 }
    }

    #[test]
    fn an_environment_has_the_level_of_twice_mid_grey() {
        // White of 0.5: the surface has 0.18.
        let anchor = |radiance: f32, intensity: f32| Anchor::new(Vec3::splat(radiance), intensity);
        assert!(anchor(0.5, 1.0).unwrap().level_stops.abs() < 1e-6);
        assert!((anchor(0.5, 8.0).unwrap().level_stops - 3.0).abs() < 1e-6);
        assert!((anchor(2.0, 1.0).unwrap().stops() - (0.5 + 1.5 / 2.5 - 2.0)).abs() < 1e-6);
        assert_eq!([anchor(0.0, 1.0), anchor(1.0, 0.0), anchor(f32::INFINITY, 1.0)], [None; 3]);
        // Day is brighter than night.
        let shown = |x: f64| at(x).stops() + x;
        assert!(shown(-10.0) < shown(-3.0) && shown(-3.0) < shown(0.0) && shown(0.0) < shown(2.0));
    }

    #[test]
    fn daylight_is_half_a_stop_brighter_and_night_stays_night() {
        for level in [-0.9, -0.3, 0.0] {
            assert!((at(level).of_sky().stops() - 0.5).abs() < 1e-9, "{level}");
        }
        assert!(at(-12.0).of_sky().stops() - at(-12.0).stops() < 0.005);
        let mut last = f64::NEG_INFINITY;
        for i in -240..=40 {
            let level = f64::from(i) / 10.0;
            let shown = at(level).of_sky().stops() + level;
            assert!(shown > last && shown < 1.5, "{level}: {last} to {shown}");
            last = shown;
        }
    }

    #[test]
    fn surfaces_move_the_exposure_by_half_a_stop() {
        for (stops, expected) in [(0.0, 0.0), (-0.5, -0.25), (-2.0, -0.4), (2.0, 0.4), (-6.0, -6.0 / 13.0)] {
            assert!((at(0.0).moved(Some(stops), 0.4) - expected).abs() < 1e-9, "{stops}");
        }
        let mut last = f64::NEG_INFINITY;
        for i in -300..=300 {
            let moved = at(1.5).moved(Some(f64::from(i) / 10.0), 0.9);
            assert!(moved > last && (moved - at(1.5).stops()).abs() < 0.5, "{i}: {last} to {moved}");
            last = moved;
        }
    }

    #[test]
    fn rooms_are_exposed_by_what_is_seen_of_them() {
        assert!((at(0.0).moved(Some(1.3), 1.0) - 1.3).abs() < 1e-9);
        // A smooth step: half way at a twentieth.
        let (least, most) = (1.3 / 3.6, 1.3);
        assert!((at(0.0).moved(Some(1.3), 0.95) - 0.5 * (least + most)).abs() < 1e-9);
        assert!((at(0.0).moved(Some(1.3), 0.9) - least).abs() < 1e-9);
        assert_eq!(at(2.0).moved(None, 1.0), at(2.0).stops(), "no light is seen");
    }

    #[test]
    fn lamps_count_at_night_alone() {
        for level in [3.0, 0.0, -4.0] {
            assert!(at(level).moved(Some(at(level).stops() - 6.0), 0.3) > at(level).stops() - 0.5, "{level}");
        }
        let night = at(-12.0);
        assert!((night.moved(Some(-3.0), 0.3) + 3.0).abs() < 1e-9, "as without an environment");
        // What moonlight lights differs by little, and is no lamp.
        assert!(night.moved(Some(night.stops() - 1.5), 0.3) > night.stops() - 0.5);
    }

    #[test]
    fn bright_saturated_colours_take_stops_off_and_grey_takes_none() {
        let excess = |r: f64, g: f64, b: f64| color_excess_stops(0.2126 * r + 0.7152 * g + 0.0722 * b, r.max(g).max(b));
        assert_eq!([excess(8.0, 8.0, 8.0), excess(0.0, 0.0, 0.0), excess(1.0, 0.0, 0.0)], [0.0; 3]);
        assert!((excess(2.0, 0.0, 0.0) - 1.0).abs() < 1e-9, "its largest component comes to 1");
        assert!((excess(1e6, 0.0, 0.0) - ((1.0f64 / 0.2126).log2() - 0.5)).abs() < 1e-9);
        assert_eq!(excess(5.0, 4.0, 1.0), 0.0, "yellow is pale");
        let anchor = at(0.0);
        assert!((anchor.lowered(-0.2, 0.5) + 0.7).abs() < 1e-9);
        assert!((anchor.lowered(-0.2, 3.0) + 1.0).abs() < 1e-9);
        assert!((anchor.lowered(-1.5, 3.0) + 1.5).abs() < 1e-9, "what is lower stays");
    }

    #[test]
    fn highlights_ask_for_what_they_exceed_white_by() {
        let excess = [0.0, 0.18, 1.0, 1e9, f64::INFINITY].map(highlight_excess_stops);
        assert_eq!(excess, [0.0, 0.0, 0.0, 1.5, 1.5]);
        assert!((highlight_excess_stops(2.0) - 1.0).abs() < 1e-9);
        // Day counts, rooms and lamps at night do not.
        assert_eq!(at(1.0).highlight_share(Some(-6.0), 0.4), 1.0);
        assert_eq!(at(1.0).highlight_share(Some(-1.0), 1.0), 0.0);
        assert_eq!(at(-12.0).highlight_share(Some(-3.0), 0.4), 0.0);
        assert_eq!(at(-12.0).highlight_share(None, 0.4), 1.0);
    }
}
