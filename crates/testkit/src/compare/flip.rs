//! How different two pictures look to people, by FLIP: for pictures that may differ in every pixel, where shares and
//! levels say little.

use super::Picture;
use manypass_flip::{ErrorMap, PIXELS_PER_DEGREE, ldr};

/// Mid grey of displays, over which transparent pixels are laid.
const GREY_SRGB: f32 = 0.5;

/// The FLIP error of every pixel (Andersson et al. 2020), from where a degree of the field of view has 67 pixels.
///
/// # Panics
/// If the sizes differ or a picture is empty.
pub fn flip(reference: &Picture, test: &Picture) -> ErrorMap {
    match ldr(&opaque(reference), &opaque(test), PIXELS_PER_DEGREE) {
        Ok(map) => map,
        Err(error) => panic!("pictures that cannot be compared: {error}"),
    }
}

/// Asserts that two pictures look the same: that their mean FLIP is at most `most`. 0.005 is hardly seen; 0.05 is
/// plain.
///
/// # Panics
/// If they do not; the message names the mean, and the largest error with its place.
#[track_caller]
pub fn assert_looks_same(reference: &Picture, test: &Picture, most: f64) {
    let map = flip(reference, test);
    let (mean, largest) = (map.mean(), map.largest());
    assert!(
        mean <= most,
        "the mean FLIP is {mean:.5}, expected at most {most}; the largest is {:.3} at ({}, {})",
        largest.error,
        largest.x,
        largest.y
    );
}

fn opaque(picture: &Picture) -> manypass_flip::Picture {
    let value = |byte: u8| f32::from(byte) / 255.0;
    let over_grey = |pixel: &[u8; 4]| {
        let alpha = value(pixel[3]);
        [0, 1, 2].map(|channel| alpha * value(pixel[channel]) + (1.0 - alpha) * GREY_SRGB)
    };
    let pixels = picture.pixels.iter().map(over_grey).collect();
    match manypass_flip::Picture::from_srgb(picture.width, picture.height, pixels) {
        Ok(picture) => picture,
        Err(error) => panic!("a picture that cannot be compared: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::mutations;

    fn stripes() -> Picture {
        let pixel = |i: usize| {
            [(4 * (i % 64)) as u8, (5 * (i / 64)) as u8, if (i % 64 / 8).is_multiple_of(2) { 220 } else { 40 }, 255]
        };
        Picture { width: 64, height: 48, pixels: (0..64 * 48).map(pixel).collect() }
    }

    #[test]
    fn what_is_spoilt_looks_different() {
        assert_looks_same(&stripes(), &stripes(), 0.0);
        for (name, spoilt) in mutations(&stripes()) {
            assert!(flip(&stripes(), &spoilt).mean() > 0.02, "{name}");
        }
        let clear = |rgb: [u8; 3]| Picture { width: 2, height: 1, pixels: vec![[rgb[0], rgb[1], rgb[2], 0]; 2] };
        assert_looks_same(&clear([255, 0, 0]), &clear([0, 0, 255]), 0.0);
    }

    #[test]
    #[should_panic(expected = "the mean FLIP is")]
    fn a_bound_can_be_passed() {
        assert_looks_same(&stripes(), &mutations(&stripes())[0].1, 0.01);
    }
}
