//! The distance between two pictures by which renderers are compared in public: the root of the mean square over mid
//! grey.

use super::Picture;

/// Mid grey of displays: half of what a byte holds.
const GREY: f64 = 127.5;

/// Root mean square differences of red, green and blue, in levels of 255 of the values that displays are given (sRGB,
/// not linear light), after both pictures were laid over mid grey. Nothing is rounded on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rmse {
    /// Over all pixels.
    pub whole: f64,
    /// Over the pixels where either picture is not wholly transparent; 0 if there is none.
    pub covered: f64,
}

/// Compares two pictures with unassociated alpha.
///
/// # Panics
/// If the sizes differ or a picture is empty.
pub fn rmse_over_grey(first: &Picture, second: &Picture) -> Rmse {
    assert_eq!((first.width, first.height), (second.width, second.height), "sizes of the pictures");
    assert!(!first.pixels.is_empty(), "a picture without pixels proves nothing");
    let (mut sum, mut covered) = (0.0, 0_usize);
    for (a, b) in first.pixels.iter().zip(&second.pixels) {
        let difference = |channel| over_grey(a, channel) - over_grey(b, channel);
        // Where both are transparent both are grey.
        sum += (0..3).map(|channel| difference(channel).powi(2)).sum::<f64>();
        covered += usize::from(a[3] > 0 || b[3] > 0);
    }
    let root = |pixels: usize| (sum / (3 * pixels.max(1)) as f64).sqrt();
    Rmse { whole: root(first.pixels.len()), covered: root(covered) }
}

fn over_grey(pixel: &[u8; 4], channel: usize) -> f64 {
    let alpha = f64::from(pixel[3]) / 255.0;
    alpha * f64::from(pixel[channel]) + (1.0 - alpha) * GREY
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transparent_pixels_are_grey_and_count_for_the_whole_alone() {
        let picture = |bytes: &[u8]| Picture::from_rgba8(bytes.len() / 4, 1, bytes);
        let first = picture(&[10, 20, 30, 255, 0, 0, 0, 0, 255, 0, 0, 0, 9, 9, 9, 255]);
        let second = picture(&[13, 24, 42, 255, 255, 255, 255, 0, 0, 0, 255, 0, 9, 9, 9, 255]);
        // 9 + 16 + 144 in one of four pixels, of which two are covered.
        let found = rmse_over_grey(&first, &second);
        assert!((found.whole - (169.0_f64 / 12.0).sqrt()).abs() < 1e-12, "{found:?}");
        assert!((found.covered - (169.0_f64 / 6.0).sqrt()).abs() < 1e-12, "{found:?}");
        // Half of white over grey is 191.25.
        let found = rmse_over_grey(&picture(&[255, 255, 255, 51]), &picture(&[0, 0, 0, 0]));
        assert!((found.whole - 0.2 * 127.5).abs() < 1e-12 && found.covered == found.whole, "{found:?}");
        let clear = picture(&[1, 2, 3, 0]);
        assert_eq!(rmse_over_grey(&clear, &clear), Rmse { whole: 0.0, covered: 0.0 });
    }
}
