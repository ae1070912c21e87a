//! Compares two pictures, and shows that the comparison would notice.

use anyhow::{Context, Result, ensure};
use std::path::Path;

/// RGBA, 8 bits each, rows from the top.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 4]>,
}

impl Picture {
    pub fn open(path: &Path) -> Result<Self> {
        let image = image::open(path).with_context(|| format!("reading {}", path.display()))?.to_rgba8();
        let pixels = image.pixels().map(|pixel| pixel.0).collect();
        Ok(Self { width: image.width() as usize, height: image.height() as usize, pixels })
    }

    fn moved(&self, from: impl Fn(usize, usize) -> (usize, usize)) -> Self {
        let at = |index: usize| {
            let (x, y) = from(index % self.width, index / self.width);
            self.pixels[y * self.width + x]
        };
        Self { pixels: (0..self.pixels.len()).map(at).collect(), ..*self }
    }

    fn recoloured(&self, colour: impl Fn([u8; 4]) -> [u8; 4]) -> Self {
        Self { pixels: self.pixels.iter().map(|&pixel| colour(pixel)).collect(), ..*self }
    }

    /// Everything that a careless port does to a picture.
    fn spoilt(&self) -> Vec<(&'static str, Self)> {
        let encode = |c: u8| ((f32::from(c) / 255.0).powf(1.0 / 2.2) * 255.0).round() as u8;
        vec![
            ("flipped top to bottom", self.moved(|x, y| (x, self.height - 1 - y))),
            ("flipped left to right", self.moved(|x, y| (self.width - 1 - x, y))),
            ("shifted right by a pixel", self.moved(|x, y| (x.saturating_sub(1), y))),
            ("shifted down by a pixel", self.moved(|x, y| (x, y.saturating_sub(1)))),
            ("red and blue swapped", self.recoloured(|[r, g, b, a]| [b, g, r, a])),
            ("gamma applied twice", self.recoloured(|[r, g, b, a]| [encode(r), encode(g), encode(b), a])),
            ("black", self.recoloured(|[_, _, _, a]| [0, 0, 0, a])),
        ]
    }
}

/// How far two pictures are apart, in levels of 255.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference {
    /// Share of pixels whose channels are all within 2 levels.
    pub share_within_2: f64,
    pub mean_absolute: f64,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.3} % within 2 levels, mean {:.4}", 100.0 * self.share_within_2, self.mean_absolute)
    }
}

/// How far apart two pictures may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    pub share_within_2: f64,
    pub mean_absolute: f64,
}

impl Tolerance {
    /// For the same frame on different drivers.
    pub const DRIVERS: Self = Self { share_within_2: 0.999, mean_absolute: 0.25 };

    pub fn allows(self, found: Difference) -> bool {
        found.share_within_2 >= self.share_within_2 && found.mean_absolute <= self.mean_absolute
    }
}

pub(crate) fn difference(a: &Picture, b: &Picture) -> Result<Difference> {
    let sizes = [a, b].map(|picture| (picture.width, picture.height));
    ensure!(sizes[0] == sizes[1] && !a.pixels.is_empty(), "the sizes differ or are zero: {sizes:?}");
    let (mut within, mut sum) = (0_u64, 0_u64);
    for (a, b) in a.pixels.iter().zip(&b.pixels) {
        let levels: [u8; 4] = std::array::from_fn(|channel| a[channel].abs_diff(b[channel]));
        within += u64::from(levels.iter().all(|&level| level <= 2));
        sum += levels.iter().map(|&level| u64::from(level)).sum::<u64>();
    }
    let count = a.pixels.len() as f64;
    Ok(Difference { share_within_2: within as f64 / count, mean_absolute: sum as f64 / (4.0 * count) })
}

/// # Errors
/// When the comparison would take a spoilt version of `picture` for the picture itself.
pub(crate) fn check_rejects_spoilt(picture: &Picture, tolerance: Tolerance) -> Result<()> {
    for (name, spoilt) in picture.spoilt() {
        let found = difference(picture, &spoilt)?;
        ensure!(!tolerance.allows(found), "the comparison accepts the picture {name}: {found}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noisy() -> Picture {
        let pixel = |i: usize| [(i * 37 % 251) as u8, (i * 91 % 241) as u8, (i * 13 % 239) as u8, 255];
        Picture { width: 32, height: 24, pixels: (0..32 * 24).map(pixel).collect() }
    }

    #[test]
    fn a_picture_agrees_with_itself_and_rejects_spoilt_versions() -> Result<()> {
        assert!(Tolerance::DRIVERS.allows(difference(&noisy(), &noisy())?));
        check_rejects_spoilt(&noisy(), Tolerance::DRIVERS)
    }

    #[test]
    fn a_comparison_on_a_plain_picture_is_refused() {
        let grey = Picture { width: 4, height: 4, pixels: vec![[90, 90, 90, 255]; 16] };
        assert!(check_rejects_spoilt(&grey, Tolerance::DRIVERS).is_err());
    }
}
