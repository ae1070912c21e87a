//! Comparison of pictures.

mod flip;
mod quality;
mod rmse;

pub use flip::{assert_looks_same, flip};
pub use quality::{psnr_db, ssim};
pub use rmse::{Rmse, rmse_over_grey};

/// A picture of 8-bit red, green, blue and alpha, rows from the top, tightly packed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// `width · height` pixels.
    pub pixels: Vec<[u8; 4]>,
}

impl Picture {
    /// The picture in `bytes`, which holds four bytes a pixel.
    ///
    /// # Panics
    /// If `bytes` has another length.
    pub fn from_rgba8(width: usize, height: usize, bytes: &[u8]) -> Self {
        assert_eq!(bytes.len(), 4 * width * height, "bytes of a {width}x{height} RGBA8 picture");
        let pixels = bytes.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2], pixel[3]]).collect();
        Self { width, height, pixels }
    }

    /// Whether no channel of `pixel` leaves the range of the 3×3 pixels around `index` by more than `within` levels.
    fn is_between_neighbours(&self, index: usize, pixel: [u8; 4], within: u8) -> bool {
        let (x, y) = (index % self.width, index / self.width);
        let (mut low, mut high) = ([255; 4], [0; 4]);
        for row in y.saturating_sub(1)..(y + 2).min(self.height) {
            for neighbour in
                &self.pixels[row * self.width + x.saturating_sub(1)..row * self.width + (x + 2).min(self.width)]
            {
                for channel in 0..4 {
                    low[channel] = neighbour[channel].min(low[channel]);
                    high[channel] = neighbour[channel].max(high[channel]);
                }
            }
        }
        (0..4).all(|c| (low[c].saturating_sub(within)..=high[c].saturating_add(within)).contains(&pixel[c]))
    }

    /// The picture whose pixel at (x, y) is the pixel of `self` at `source(x, y)` after `recolor`.
    fn mutated(
        &self,
        source: impl Fn(usize, usize) -> (usize, usize),
        recolor: impl Fn([u8; 4]) -> [u8; 4],
    ) -> Picture {
        let pixels = (0..self.width * self.height)
            .map(|i| {
                let (x, y) = source(i % self.width, i / self.width);
                recolor(self.pixels[y * self.width + x])
            })
            .collect();
        Picture { width: self.width, height: self.height, pixels }
    }
}

/// How far two pictures may differ and still count as the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// A pixel agrees if no channel differs by more levels than this.
    pub within: u8,
    /// The smallest share of pixels that agree, 0 to 1.
    pub share: f64,
    /// The smallest share of pixels that agree, or lie between the pixels around them in the first picture, 0 to 1.
    pub share_between: f64,
    /// The largest mean absolute difference of a channel, in levels of 255.
    pub mean: f64,
    /// The most pixels that hang together, by edges or corners, and do not agree. A share alone lets all of them lie
    /// together, where they are a thing that is missing.
    pub area_px: usize,
    /// The most pixels that hang together and neither agree nor lie between the pixels around them.
    pub area_between_px: usize,
}

impl Default for Tolerance {
    /// Software adapters differ by two to three levels from host to host, on few pixels, which lie apart: twice the
    /// four that were seen together (lavapipe with the instructions of SSE2, SSE4.1 and AVX2).
    fn default() -> Self {
        Self { within: 2, share: 0.999, share_between: 0.999, mean: 0.25, area_px: 8, area_between_px: 8 }
    }
}

impl Tolerance {
    /// For one sample a pixel on rasterizers that snap vertices to different grids (SwiftShader to 1/16 pixel, lavapipe
    /// to 1/256): a pixel at an edge shows the other side of it, which is what a pixel beside it shows too.
    /// Such pixels hang together along edges, 16 at most in the pictures of the browser tests; of those that show
    /// nothing beside them, two. Twice that is allowed.
    pub const RASTERIZERS: Self =
        Self { within: 2, share: 0.98, share_between: 0.999, mean: 0.25, area_px: 32, area_between_px: 4 };
}

/// The pixel in which two pictures differ most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorstPixel {
    /// Column, from the left.
    pub x: usize,
    /// Row, from the top.
    pub y: usize,
    /// The largest difference of a channel in levels.
    pub difference: u8,
    /// The pixel of the first picture.
    pub first: [u8; 4],
    /// The pixel of the second picture.
    pub second: [u8; 4],
}

/// How two pictures of the same size differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The share of pixels that agree, 0 to 1.
    pub share: f64,
    /// The share of pixels that agree, or lie between the pixels around them in the first picture, 0 to 1.
    pub share_between: f64,
    /// The mean absolute difference of all channels, in levels of 255.
    pub mean: f64,
    /// The most pixels that hang together, by edges or corners, and do not agree.
    pub area_px: usize,
    /// The most pixels that hang together and neither agree nor lie between the pixels around them.
    pub area_between_px: usize,
    /// Where they differ most; none if they are equal.
    pub worst: Option<WorstPixel>,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (share, between) = (100.0 * self.share, 100.0 * self.share_between);
        write!(f, "{share:.3} % agree, {between:.3} % with those at edges, mean {:.4}/255", self.mean)?;
        write!(f, ", at most {} and {} px together", self.area_px, self.area_between_px)
    }
}

impl Difference {
    /// Whether the difference lies within `tolerance`.
    pub fn is_within(&self, tolerance: Tolerance) -> bool {
        self.share >= tolerance.share
            && self.share_between >= tolerance.share_between
            && self.mean <= tolerance.mean
            && self.area_px <= tolerance.area_px
            && self.area_between_px <= tolerance.area_between_px
    }
}

/// Compares two pictures; a pixel agrees if no channel differs by more than `within` levels.
///
/// # Panics
/// If the sizes differ or a picture is empty.
pub fn difference(first: &Picture, second: &Picture, within: u8) -> Difference {
    assert_eq!((first.width, first.height), (second.width, second.height), "sizes of the pictures");
    assert!(!first.pixels.is_empty(), "a picture without pixels proves nothing");
    let (mut sum, mut worst) = (0_u64, None::<WorstPixel>);
    let (mut wrong, mut outside) = (Vec::new(), Vec::new());
    for (i, (a, b)) in first.pixels.iter().zip(&second.pixels).enumerate() {
        let channels: [u8; 4] = std::array::from_fn(|channel| a[channel].abs_diff(b[channel]));
        let largest = channels.into_iter().fold(0, u8::max);
        wrong.push(largest > within);
        outside.push(largest > within && !first.is_between_neighbours(i, *b, within));
        sum += channels.into_iter().map(u64::from).sum::<u64>();
        if largest > worst.map_or(0, |worst| worst.difference) {
            let (x, y) = (i % first.width, i / first.width);
            worst = Some(WorstPixel { x, y, difference: largest, first: *a, second: *b });
        }
    }
    let count = first.pixels.len() as f64;
    let share_outside = |marked: &[bool]| 1.0 - marked.iter().filter(|is_marked| **is_marked).count() as f64 / count;
    Difference {
        share: share_outside(&wrong),
        share_between: share_outside(&outside),
        mean: sum as f64 / (4.0 * count),
        area_px: largest_area(wrong, first.width),
        area_between_px: largest_area(outside, first.width),
        worst,
    }
}

/// How many of the marked pixels hang together at most, by edges or corners.
fn largest_area(mut marked: Vec<bool>, width: usize) -> usize {
    let height = marked.len() / width;
    let mut largest = 0;
    for start in 0..marked.len() {
        let (mut open, mut area) = (vec![start], 0);
        while let Some(i) = open.pop() {
            if !std::mem::take(&mut marked[i]) {
                continue;
            }
            area += 1;
            let (x, y) = (i % width, i / width);
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                open.extend((x.saturating_sub(1)..(x + 2).min(width)).map(|column| row * width + column));
            }
        }
        largest = largest.max(area);
    }
    largest
}

/// Asserts that two pictures are the same within `tolerance`.
///
/// # Panics
/// If they are not; the message names the share, the mean and the worst pixel.
#[track_caller]
pub fn assert_same(first: &Picture, second: &Picture, tolerance: Tolerance) {
    let found = difference(first, second, tolerance.within);
    if found.is_within(tolerance) {
        return;
    }
    let worst = found.worst.map_or(String::new(), |worst| {
        let WorstPixel { x, y, difference, first, second } = worst;
        format!("; the worst pixel, ({x}, {y}), is off by {difference}: {first:?} against {second:?}")
    });
    panic!("pictures differ: {found}; expected {tolerance:?}{worst}");
}

/// `picture` spoilt in every way that a renderer commonly spoils one, each with its name.
pub fn mutations(picture: &Picture) -> Vec<(&'static str, Picture)> {
    let (width, height) = (picture.width, picture.height);
    let keep = |pixel| pixel;
    let gamma = |level: u8| (255.0 * (f64::from(level) / 255.0).powf(1.0 / 2.2)).round() as u8;
    vec![
        ("flipped in x", picture.mutated(|x, y| (width - 1 - x, y), keep)),
        ("flipped in y", picture.mutated(|x, y| (x, height - 1 - y), keep)),
        ("red and blue swapped", picture.mutated(|x, y| (x, y), |[r, g, b, a]| [b, g, r, a])),
        ("gamma applied twice", picture.mutated(|x, y| (x, y), |[r, g, b, a]| [gamma(r), gamma(g), gamma(b), a])),
        ("shifted by a pixel in x", picture.mutated(|x, y| (x.saturating_sub(1), y), keep)),
        ("shifted by a pixel in y", picture.mutated(|x, y| (x, y.saturating_sub(1)), keep)),
        ("black", picture.mutated(|x, y| (x, y), |[_, _, _, a]| [0, 0, 0, a])),
    ]
}

/// Asserts that a comparison with `picture` would fail: that `tolerance` tells it from all its [`mutations`].
///
/// # Panics
/// If a mutation passes; the message names every one. The picture is then too plain, or the tolerance too wide.
#[track_caller]
pub fn assert_rejects_mutations(picture: &Picture, tolerance: Tolerance) {
    let passing: Vec<_> = mutations(picture)
        .into_iter()
        .filter(|(_, mutation)| difference(picture, mutation, tolerance.within).is_within(tolerance))
        .map(|(name, _)| name)
        .collect();
    assert!(passing.is_empty(), "the comparison accepts the picture {}", passing.join(", "));
}

/// How two linear pictures of the same size differ. The error of a pixel is the largest absolute difference of a
/// channel, divided by the largest channel of the reference or by the floor, whichever is larger.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearDifference {
    /// Relative errors, ascending.
    errors: Vec<f64>,
    /// The mean relative error.
    pub mean: f64,
    /// The index of the pixel with the largest error.
    pub worst: usize,
}

impl LinearDifference {
    /// The smallest error that `share` (0 to 1) of the pixels do not exceed.
    pub fn percentile(&self, share: f64) -> f64 {
        let last = self.errors.len() - 1;
        self.errors[((share * self.errors.len() as f64).ceil() as usize).saturating_sub(1).min(last)]
    }

    /// The share of pixels whose error is at most `error` (0.01 is one per cent).
    pub fn share_within(&self, error: f64) -> f64 {
        self.errors.partition_point(|&found| found <= error) as f64 / self.errors.len() as f64
    }
}

/// Compares linear red, green and blue of `found` with `reference`. `floor` is the radiance below which errors are
/// relative to `floor`. A value that is not finite where the reference is finite is an infinite error.
///
/// # Panics
/// If the sizes differ, a picture is empty, or `floor` is not positive.
pub fn linear_difference(reference: &[[f32; 3]], found: &[[f32; 3]], floor: f64) -> LinearDifference {
    assert_eq!(reference.len(), found.len(), "sizes of the pictures");
    assert!(!reference.is_empty(), "a picture without pixels proves nothing");
    assert!(floor > 0.0, "floor of radiance: {floor}");
    let mut errors: Vec<f64> = reference
        .iter()
        .zip(found)
        .map(|(a, b)| {
            let scale = a.iter().fold(floor, |scale, &channel| scale.max(f64::from(channel).abs()));
            let error = (0..3).fold(0.0_f64, |largest, channel| {
                let absolute = (f64::from(a[channel]) - f64::from(b[channel])).abs();
                // `f64::max` would pass over NaN.
                if absolute.is_nan() { f64::INFINITY } else { largest.max(absolute) }
            });
            error / scale
        })
        .collect();
    let worst = errors.iter().enumerate().fold(0, |worst, (i, &error)| if error > errors[worst] { i } else { worst });
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    errors.sort_by(f64::total_cmp);
    LinearDifference { errors, mean, worst }
}

/// Asserts that at least `share` (0 to 1) of the pixels of `found` are within one per cent of `reference`, and the mean
/// error too. See [`linear_difference`] for `floor`.
///
/// # Panics
/// If they are not; the message names the errors and the worst pixel.
#[track_caller]
pub fn assert_within_one_percent(reference: &[[f32; 3]], found: &[[f32; 3]], floor: f64, share: f64) {
    let result = linear_difference(reference, found, floor);
    let worst = result.worst;
    assert!(
        result.mean <= 0.01 && result.share_within(0.01) >= share,
        "{:.3} % of pixels are within 1 %, {:.3} % expected; mean error {:.4} %, 99th percentile {:.4} %, worst {:.4} %: \
         pixel {worst} is {:?}, expected {:?}",
        100.0 * result.share_within(0.01),
        100.0 * share,
        100.0 * result.mean,
        100.0 * result.percentile(0.99),
        100.0 * result.percentile(1.0),
        found[worst],
        reference[worst],
    );
}

#[cfg(test)]
mod tests;
