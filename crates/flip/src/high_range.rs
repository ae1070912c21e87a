//! HDR-FLIP: the largest LDR-FLIP over the exposures at which somebody would look at the reference.

use crate::colour::luminance;
use crate::error_map::ErrorMap;
use crate::filters::Filters;
use crate::picture::{FlipError, Picture, check};
use crate::rows::ldr_as;

/// The tone curve of the paper, (k₀x² + k₁x + k₂) / (k₃x² + k₄x + k₅): Narkowicz' fit of ACES, with its exposure of 0.6
/// taken in.
const CURVE: [f32; 6] = [0.9036, 0.018, 0.0, 0.8748, 0.354, 0.14];
/// What the brightest pixel is shown as at the lowest exposure, and the median one at the highest.
const SHOWN_AS: f64 = 0.85;
/// The most exposures. Radiance of half floats needs 40 at most; beyond, steps are wider than a stop.
const MAX_COUNT: usize = 64;

/// The exposures at which two pictures are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// The lowest in stops: the brightest pixel of the reference is just not burnt out.
    pub start_ev: f64,
    /// The highest in stops: the median pixel of the reference is just not burnt out.
    pub stop_ev: f64,
    /// How many there are, at equal steps, both ends included; at least 2.
    pub count: usize,
}

impl Exposures {
    /// The exposures for a reference, as the paper chooses them. Black pixels have no exposure: where the median pixel
    /// is black, the median of the others is taken, and in a picture that is all black, exposure 0.
    pub fn of_reference(reference: &Picture) -> Self {
        let shown = |rgb: &[f32; 3]| luminance(rgb.map(|value| value.max(0.0)));
        let mut luminances: Vec<f32> = reference.rgb_linear().iter().map(shown).collect();
        let brightest = luminances.iter().copied().fold(0.0, f32::max);
        if brightest <= 0.0 {
            return Self { start_ev: 0.0, stop_ev: 0.0, count: 2 };
        }
        let mut middle = median(&mut luminances);
        if middle <= 0.0 {
            luminances.retain(|&value| value > 0.0);
            middle = median(&mut luminances);
        }
        let white = white();
        let (start_ev, stop_ev) = ((white / f64::from(brightest)).log2(), (white / middle).log2());
        let count = ((stop_ev - start_ev).ceil() as usize).clamp(2, MAX_COUNT);
        Self { start_ev, stop_ev, count }
    }

    /// All of them, in stops, from the lowest.
    pub fn all_ev(&self) -> impl Iterator<Item = f64> {
        let Self { start_ev, stop_ev, count } = *self;
        let step_ev = (stop_ev - start_ev) / count.saturating_sub(1).max(1) as f64;
        (0..count).map(move |index| start_ev + step_ev * index as f64)
    }
}

/// HDR-FLIP (Andersson et al. 2021) of two pictures of radiance: of every pixel the largest LDR-FLIP over `Exposures`,
/// chosen from the reference, which therefore cannot change places with the other. Negative values count as 0. It takes
/// as long as [`crate::ldr`] as many times as there are exposures.
///
/// # Errors
/// As [`crate::ldr`].
pub fn hdr(reference: &Picture, test: &Picture, pixels_per_degree: f32) -> Result<(ErrorMap, Exposures), FlipError> {
    check(reference, test, pixels_per_degree)?;
    let exposures = Exposures::of_reference(reference);
    let filters = Filters::new(f64::from(pixels_per_degree));
    let mut largest: Option<ErrorMap> = None;
    for exposure_ev in exposures.all_ev() {
        let factor = exposure_ev.exp2() as f32;
        let map = ldr_as(reference, test, &filters, |rgb| rgb.map(|value| shown(value * factor)));
        match &mut largest {
            None => largest = Some(map),
            Some(largest) => largest.errors.iter_mut().zip(map.errors).for_each(|(a, b)| *a = a.max(b)),
        }
    }
    let (width, height) = reference.size();
    Ok((largest.unwrap_or_else(|| ErrorMap { width, height, errors: vec![0.0; width * height] }), exposures))
}

/// The tone curve; what is above 1 is clamped by the comparison.
fn shown(radiance: f32) -> f32 {
    // From here on the curve is above 1, and squares of far larger values would be infinite.
    let x = radiance.clamp(0.0, 1e6);
    let [k0, k1, k2, k3, k4, k5] = CURVE;
    ((k0 * x + k1) * x + k2) / ((k3 * x + k4) * x + k5)
}

/// The radiance that the tone curve shows as [`SHOWN_AS`]: the positive root of a quadratic.
fn white() -> f64 {
    let [k0, k1, k2, k3, k4, k5] = CURVE.map(f64::from);
    let (a, b, c) = (k0 - SHOWN_AS * k3, k1 - SHOWN_AS * k4, k2 - SHOWN_AS * k5);
    (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
}

/// The median of at least one value, the mean of the middle two of an even number.
fn median(values: &mut [f32]) -> f64 {
    let middle = values.len() / 2;
    let is_even = values.len().is_multiple_of(2);
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
    let lower = below.iter().copied().max_by(f32::total_cmp).filter(|_| is_even).unwrap_or(upper);
    (f64::from(lower) + f64::from(upper)) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposures_are_where_the_curve_shows_the_brightest_and_the_median() {
        assert!((shown(white() as f32) - 0.85).abs() < 1e-6, "{}", shown(white() as f32));
        let values = [0.0, 0.5, 1.0, 2.0, 60.0];
        let picture = Picture::from_linear(5, 1, values.map(|value| [value; 3]).to_vec()).expect("a picture");
        let exposures = Exposures::of_reference(&picture);
        assert!((exposures.stop_ev - white().log2()).abs() < 1e-5, "{exposures:?}");
        assert!((exposures.stop_ev - exposures.start_ev - 60f64.log2()).abs() < 1e-5, "{exposures:?}");
        assert!(exposures.count == 6 && exposures.all_ev().count() == 6);
        assert_eq!(exposures.all_ev().next(), Some(exposures.start_ev));
        assert!((exposures.all_ev().last().expect("two") - exposures.stop_ev).abs() < 1e-12);
    }

    #[test]
    fn black_and_extreme_pictures_have_finite_exposures() {
        let of = |values: &[f32]| {
            let pixels = values.iter().map(|&value| [value; 3]).collect();
            Exposures::of_reference(&Picture::from_linear(values.len(), 1, pixels).expect("a picture"))
        };
        assert_eq!(of(&[0.0, -1.0]), Exposures { start_ev: 0.0, stop_ev: 0.0, count: 2 });
        assert_eq!(of(&[0.0, 0.0, 0.0, 0.0, 4.0, 2.0, 1.0]).stop_ev, of(&[1.0, 2.0, 4.0]).stop_ev);
        let widest = of(&[f32::MIN_POSITIVE, f32::MIN_POSITIVE, f32::MAX / 4.0]);
        assert!(widest.count == MAX_COUNT && widest.all_ev().all(f64::is_finite), "{widest:?}");
        assert!((shown(f32::MAX) - 1.0329).abs() < 1e-3 && shown(-1.0) == 0.0);
        assert_eq!(median(&mut [3.0, 1.0, 2.0, 10.0]), 2.5);
    }
}
