//! The pictures that are compared, and what is wrong with them.

use crate::PIXELS_PER_DEGREE_RANGE;
use crate::colour::linear_from_srgb;

/// Why two pictures cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlipError {
    /// A picture has no pixels, or not as many as its size asks for.
    #[error("a picture of {width}x{height} pixels cannot have {found} of them")]
    Length {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
        /// How many pixels there are.
        found: usize,
    },
    /// A pixel is infinite or not a number.
    #[error("the pixel at column {x}, row {y} is {rgb:?}, which are not finite numbers")]
    NotFinite {
        /// Columns from the left.
        x: usize,
        /// Rows from the top.
        y: usize,
        /// Its red, green and blue.
        rgb: [f32; 3],
    },
    /// The two are of different sizes.
    #[error("the reference has {}x{} pixels, the other picture {}x{}", .reference.0, .reference.1, .test.0, .test.1)]
    Sizes {
        /// Width and height of the reference in pixels.
        reference: (usize, usize),
        /// Width and height of the other picture in pixels.
        test: (usize, usize),
    },
    /// Not a number of pixels a degree within [`PIXELS_PER_DEGREE_RANGE`].
    #[error("{0} pixels a degree are not from {first} to {last}", first = PIXELS_PER_DEGREE_RANGE.start(), last = PIXELS_PER_DEGREE_RANGE.end())]
    PixelsPerDegree(f32),
}

/// A picture of finite linear red, green and blue with the primaries of sRGB; 1 is the display's white.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    rgb_linear: Vec<[f32; 3]>,
}

impl Picture {
    /// A picture of `width · height` pixels in linear light, rows from the top. Values outside of the range that is
    /// compared (0 to 1 by [`crate::ldr`], from 0 by [`crate::hdr`]) count as the nearest within.
    ///
    /// # Errors
    /// If the number of pixels does not fit the size or is 0, or one of them is not finite.
    pub fn from_linear(width: usize, height: usize, rgb_linear: Vec<[f32; 3]>) -> Result<Self, FlipError> {
        let found = rgb_linear.len();
        if found == 0 || width.checked_mul(height) != Some(found) {
            return Err(FlipError::Length { width, height, found });
        }
        let is_finite = |rgb: &[f32; 3]| rgb.iter().all(|value| value.is_finite());
        match rgb_linear.iter().enumerate().find(|(_, rgb)| !is_finite(rgb)) {
            Some((index, rgb)) => Err(FlipError::NotFinite { x: index % width, y: index / width, rgb: *rgb }),
            None => Ok(Self { width, height, rgb_linear }),
        }
    }

    /// As [`Self::from_linear`], of values that are encoded as sRGB (IEC 61966-2-1), 0 to 1.
    ///
    /// # Errors
    /// As [`Self::from_linear`].
    pub fn from_srgb(width: usize, height: usize, mut rgb_srgb: Vec<[f32; 3]>) -> Result<Self, FlipError> {
        rgb_srgb.iter_mut().flatten().for_each(|value| *value = linear_from_srgb(*value));
        Self::from_linear(width, height, rgb_srgb)
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// All pixels, rows from the top.
    pub fn rgb_linear(&self) -> &[[f32; 3]] {
        &self.rgb_linear
    }

    /// The pixels of a row; rows above the first and below the last are those.
    pub(crate) fn row(&self, y: isize) -> &[[f32; 3]] {
        let y = y.clamp(0, self.height as isize - 1) as usize;
        &self.rgb_linear[y * self.width..][..self.width]
    }
}

/// Fails unless the two can be compared at `pixels_per_degree`.
pub(crate) fn check(reference: &Picture, test: &Picture, pixels_per_degree: f32) -> Result<(), FlipError> {
    if reference.size() != test.size() {
        return Err(FlipError::Sizes { reference: reference.size(), test: test.size() });
    }
    if !PIXELS_PER_DEGREE_RANGE.contains(&pixels_per_degree) {
        return Err(FlipError::PixelsPerDegree(pixels_per_degree));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_compared_is_named() {
        let length = |width, height, found| Err(FlipError::Length { width, height, found });
        assert_eq!(Picture::from_linear(2, 2, vec![[0.0; 3]; 3]), length(2, 2, 3));
        assert_eq!(Picture::from_linear(0, 2, Vec::new()), length(0, 2, 0));
        assert_eq!(Picture::from_linear(usize::MAX, 2, vec![[0.0; 3]]), length(usize::MAX, 2, 1));
        let error = Picture::from_linear(2, 2, vec![[0.0; 3], [0.0; 3], [0.0; 3], [0.0, f32::INFINITY, 0.0]]);
        assert_eq!(error, Err(FlipError::NotFinite { x: 1, y: 1, rgb: [0.0, f32::INFINITY, 0.0] }));
        let picture = |width: usize| Picture::from_srgb(width, 1, vec![[0.5; 3]; width]).expect("a picture");
        assert_eq!(check(&picture(2), &picture(3), 67.0), Err(FlipError::Sizes { reference: (2, 1), test: (3, 1) }));
        for degree in [0.0, 0.9, -67.0, 1001.0, f32::INFINITY] {
            assert_eq!(check(&picture(2), &picture(2), degree), Err(FlipError::PixelsPerDegree(degree)));
        }
        assert!(check(&picture(2), &picture(2), f32::NAN).is_err());
    }
}
