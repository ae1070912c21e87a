//! How far a picture is from a reference, as numbers that others state: PSNR and SSIM.

use super::Picture;

/// The standard deviation of the window of SSIM, in pixels, and how far it reaches.
const SIGMA_PX: f64 = 1.5;
const REACH_PX: usize = 5;
/// The constants of SSIM that keep it from dividing by nothing, of values from 0 to 255.
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// The peak signal-to-noise ratio of red, green and blue, in decibels; infinite for the same picture.
///
/// # Panics
/// If the sizes differ.
pub fn psnr_db(reference: &Picture, test: &Picture) -> f64 {
    assert_eq!((reference.width, reference.height), (test.width, test.height), "pictures of one size");
    let squared = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).map(|c| f64::from(a[c].abs_diff(b[c])).powi(2)).sum::<f64>();
    let sum: f64 = reference.pixels.iter().zip(&test.pixels).map(squared).sum();
    10.0 * (255.0 * 255.0 * 3.0 * reference.pixels.len() as f64 / sum).log10()
}

/// The mean structural similarity of luma, 1 for the same picture: Wang, Bovik, Sheikh and Simoncelli 2004, "Image Quality
/// Assessment: From Error Visibility to Structural Similarity", with its Gaussian window of 11 × 11 pixels, cut at the
/// borders of the picture.
///
/// # Panics
/// If the sizes differ.
pub fn ssim(reference: &Picture, test: &Picture) -> f64 {
    assert_eq!((reference.width, reference.height), (test.width, test.height), "pictures of one size");
    let size = (reference.width, reference.height);
    let luma = |picture: &Picture| -> Vec<f64> {
        let of = |p: &[u8; 4]| 0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2]);
        picture.pixels.iter().map(of).collect()
    };
    let (a, b) = (luma(reference), luma(test));
    let product = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
    let mean = |values: &[f64]| windowed(values, size);
    let (mean_a, mean_b) = (mean(&a), mean(&b));
    let (aa, bb, ab) = (mean(&product(&a, &a)), mean(&product(&b, &b)), mean(&product(&a, &b)));
    let of = |at: usize| {
        let (ma, mb) = (mean_a[at], mean_b[at]);
        let (variance_a, variance_b, covariance) = (aa[at] - ma * ma, bb[at] - mb * mb, ab[at] - ma * mb);
        (2.0 * ma * mb + C1) * (2.0 * covariance + C2) / ((ma * ma + mb * mb + C1) * (variance_a + variance_b + C2))
    };
    (0..a.len()).map(of).sum::<f64>() / a.len() as f64
}

/// The mean around every pixel, in rows and then in columns.
fn windowed(values: &[f64], (width, height): (usize, usize)) -> Vec<f64> {
    let weight = |distance: usize| (-0.5 * (distance as f64 / SIGMA_PX).powi(2)).exp();
    let along = |at: usize, count: usize, value: &dyn Fn(usize) -> f64| {
        let near = at.saturating_sub(REACH_PX)..(at + REACH_PX + 1).min(count);
        let sums = near.map(|other| (weight(other.abs_diff(at)) * value(other), weight(other.abs_diff(at))));
        let (sum, weights) = sums.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
        sum / weights
    };
    let rows: Vec<f64> =
        (0..values.len()).map(|i| along(i % width, width, &|x| values[i / width * width + x])).collect();
    (0..values.len()).map(|i| along(i / width, height, &|y| rows[y * width + i % width])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stripes(offset: u8) -> Picture {
        let pixels = (0..48 * 32).map(|i| [if i % 48 / 6 % 2 == 0 { 200 } else { 60 } + offset, 90, 40, 255]).collect();
        Picture { width: 48, height: 32, pixels }
    }

    #[test]
    fn the_same_picture_is_without_error() {
        assert!(psnr_db(&stripes(0), &stripes(0)).is_infinite());
        assert!((ssim(&stripes(0), &stripes(0)) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn errors_have_the_numbers_of_their_formulas() {
        // One of three channels is off by 6.
        let expected = 10.0 * (255.0f64 * 255.0 * 3.0 / 36.0).log10();
        assert!((psnr_db(&stripes(0), &stripes(6)) - expected).abs() < 1e-9);
        // A constant more changes no structure, and another structure does.
        let (brighter, turned) = (ssim(&stripes(0), &stripes(6)), {
            let mut turned = stripes(0);
            turned.pixels.iter_mut().for_each(|pixel| pixel[0] = 4 * (pixel[0] == 60) as u8 * 35 + 60);
            ssim(&stripes(0), &turned)
        });
        assert!(brighter > 0.98 && turned < 0.3, "{brighter} {turned}");
        // Of flat pictures the first of the two factors alone is left.
        let flat = |value: u8| Picture { width: 20, height: 9, pixels: vec![[value; 4]; 180] };
        let expected = (2.0 * 100.0 * 120.0 + C1) / (100.0 * 100.0 + 120.0 * 120.0 + C1);
        assert!((ssim(&flat(100), &flat(120)) - expected).abs() < 1e-9);
    }
}
