//! Two pictures of radiance, compared in linear light.

use super::source::{GREY_LINEAR, Source};

/// How the radiance of two pictures differs: means over all pixels and red, green and blue. What is transparent sends
/// none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// The mean of the first, in cd/m².
    pub mean_a: f64,
    /// The mean of the second.
    pub mean_b: f64,
    /// The mean of the absolute differences.
    pub mean_absolute: f64,
    /// The root of the mean square difference.
    pub root_mean_square: f64,
}

impl Linear {
    /// Compares two pictures of one size.
    pub fn of(a: &Source, b: &Source) -> Self {
        let mut sums = [0.0_f64; 4];
        let pairs = a.picture.rgb_linear().iter().zip(b.picture.rgb_linear());
        for (a, b) in pairs.flat_map(|(a, b)| a.iter().zip(b)) {
            let (a, b) = (f64::from(*a), f64::from(*b));
            for (sum, value) in sums.iter_mut().zip([a, b, (a - b).abs(), (a - b).powi(2)]) {
                *sum += value;
            }
        }
        let count = (3 * a.picture.rgb_linear().len()).max(1) as f64;
        let [mean_a, mean_b, mean_absolute, mean_square] = sums.map(|sum| sum / count);
        let grey = |source: &Source| f64::from(GREY_LINEAR) * source.transparency;
        let (mean_a, mean_b) = (mean_a - grey(a), mean_b - grey(b));
        Self { mean_a, mean_b, mean_absolute, root_mean_square: mean_square.sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass_flip::Picture;
    use manypass_offline::decode::Light;

    #[test]
    fn means_are_those_counted_by_hand_without_what_is_transparent() {
        let source = |values: [f32; 2], transparency: f64| {
            let picture = Picture::from_linear(2, 1, values.map(|value| [value; 3]).to_vec()).expect("a picture");
            Source { name: String::new(), light: Light::Scene, picture, transparency }
        };
        let found = Linear::of(&source([1.0, 3.0], 0.0), &source([2.0, 1.0], 0.0));
        assert_eq!((found.mean_a, found.mean_b, found.mean_absolute), (2.0, 1.5, 1.5));
        assert!((found.root_mean_square - 2.5_f64.sqrt()).abs() < 1e-12, "{found:?}");
        let found = Linear::of(&source([1.0, GREY_LINEAR], 0.5), &source([2.0, GREY_LINEAR], 0.5));
        assert!((found.mean_a - 0.5).abs() < 1e-7 && (found.mean_b - 1.0).abs() < 1e-7, "{found:?}");
    }
}
