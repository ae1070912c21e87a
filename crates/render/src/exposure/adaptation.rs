//! Exposure that goes on from frame to frame.

use crate::passes::meter::radius_px;
use crate::setting::choices;

choices! {
    /// The metering pattern: how much each part of the picture counts for its exposure.
    pub enum MeteringPattern {
        /// All alike.
        #[default]
        Average = "average",
        /// The more, the nearer to the middle: a bell curve, whose standard deviation is a quarter of the shorter side.
        Centre = "centre",
        /// A disc in the middle alone, whose radius is a tenth of the shorter side.
        Spot = "spot",
    }
}

impl MeteringPattern {
    /// Its standard deviation or radius as a share of the shorter side.
    pub(crate) fn radius(self) -> f32 {
        if self == Self::Spot { 0.1 } else { 0.25 }
    }

    /// How much the pixel `index`, counted in rows, of a picture of this size counts. The shader `meter` says the same.
    pub(crate) fn weight(self, index: usize, size: (u32, u32)) -> f64 {
        let columns = size.0.max(1) as usize;
        let place_px = [(index % columns) as f64 + 0.5, (index / columns) as f64 + 0.5];
        let radius_px = f64::from(radius_px(self.radius(), size));
        let from_middle = [(place_px[0], size.0), (place_px[1], size.1)].map(|(at, side)| at - 0.5 * f64::from(side));
        let distance_squared = from_middle.iter().map(|at| (at / radius_px).powi(2)).sum::<f64>();
        match self {
            Self::Average => 1.0,
            Self::Centre => (-0.5 * distance_squared).exp(),
            Self::Spot => f64::from(u8::from(distance_squared <= 1.0)),
        }
    }
}

/// Eye adaptation: how exposure follows from that of the view's last picture (`exposure.adapt`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Adaptation {
    /// It does not: the picture is one of its own, and exposed as it was metered.
    #[default]
    Still,
    /// The picture begins a sequence, and is adapted to what it shows.
    Begins,
    /// The last picture of the view was so many seconds before. If there is none, this one begins.
    After {
        /// Seconds; what is no number, or below 0, is none.
        secs: f32,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_weigh_the_middle() {
        let size = (40, 20);
        let at = |x: usize, y: usize| y * 40 + x;
        for pattern in [MeteringPattern::Average, MeteringPattern::Centre, MeteringPattern::Spot] {
            let weights: Vec<f64> = (0..800).map(|index| pattern.weight(index, size)).collect();
            assert_eq!(weights[at(19, 9)], weights[at(20, 10)], "the middle is between the two");
            assert_eq!(weights[at(0, 0)], weights[at(39, 19)]);
            let total: f64 = weights.iter().sum();
            let expected = match pattern {
                MeteringPattern::Average => 800.0,
                // 2 π σ², of which what lies above and below two standard deviations is missing; a disc of radius 2.
                MeteringPattern::Centre => 2.0 * std::f64::consts::PI * 25.0 * 0.9545,
                MeteringPattern::Spot => 12.0,
            };
            assert!((total / expected - 1.0).abs() < 0.01, "{pattern:?}: {total}, not {expected}");
        }
        // Something counts in every picture.
        for size in [(1, 1), (2, 2), (1, 4096), (4096, 1), (3, 2)] {
            let weigh = |pattern: MeteringPattern| {
                (0..(size.0 * size.1) as usize).map(|index| pattern.weight(index, size)).sum::<f64>()
            };
            assert!(weigh(MeteringPattern::Centre) > 0.3 && weigh(MeteringPattern::Spot) >= 1.0, "{size:?}");
        }
    }
}
