//! LDR-FLIP, band by band of rows, so that little is in memory and bands may lie on several threads.

use crate::colour::{hunt_lab_from_rgb, hyab, rgb_from_ycxcz, ycxcz_from_rgb};
use crate::error_map::ErrorMap;
use crate::filters::Filters;
use crate::kernel::LANES;
use crate::picture::{FlipError, Picture, check};
use std::sync::{Mutex, PoisonError};

/// The exponent that differences of colour are compressed by, and that of features.
const COLOUR_EXPONENT: f32 = 0.7;
const FEATURE_EXPONENT: f32 = 0.5;
/// Differences up to this share of the largest are mapped to [`MAPPED_SHARE`] of the range, the rare larger ones to the
/// rest.
const COMMON_SHARE: f32 = 0.4;
const MAPPED_SHARE: f32 = 0.95;

/// The rows of a band: with the filters' reach twice, as many rows again are filtered as a tenth to a third.
const BAND_ROWS: usize = 64;

/// LDR-FLIP (Andersson et al. 2020) of what two displays show, seen from where a degree has `pixels_per_degree` pixels
/// ([`crate::PIXELS_PER_DEGREE`] as a rule). Values beyond 0 to 1 count as the nearest within. Beyond the edges of a
/// picture its outermost pixels go on.
///
/// The same but for the last bits if the two change places.
///
/// # Errors
/// If the pictures are of different sizes, or `pixels_per_degree` is out of its range.
pub fn ldr(reference: &Picture, test: &Picture, pixels_per_degree: f32) -> Result<ErrorMap, FlipError> {
    check(reference, test, pixels_per_degree)?;
    Ok(ldr_as(reference, test, &Filters::new(f64::from(pixels_per_degree)), |rgb| rgb))
}

/// LDR-FLIP of two pictures of the same size, whose pixels are taken as `shown` gives them.
pub(crate) fn ldr_as(
    reference: &Picture,
    test: &Picture,
    filters: &Filters,
    shown: impl Fn([f32; 3]) -> [f32; 3] + Sync,
) -> ErrorMap {
    let (width, height) = reference.size();
    let mut errors = vec![0.0; width * height];
    let largest = largest_colour_difference();
    let bands = Mutex::new(errors.chunks_mut(width * BAND_ROWS).enumerate());
    let work = || {
        let mut workspaces = [Workspace::new(width, filters), Workspace::new(width, filters)];
        loop {
            let band = bands.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some((index, errors)) = band else { return };
            let first = index * BAND_ROWS;
            let rows = errors.len() / width;
            let [a, b] = &mut workspaces;
            a.begin(reference, first, rows, filters, &shown);
            b.begin(test, first, rows, filters, &shown);
            for (row, errors) in errors.chunks_exact_mut(width).enumerate() {
                a.finish_row(row, filters);
                b.finish_row(row, filters);
                for (x, error) in errors.iter_mut().enumerate() {
                    *error = difference(a.seen[x], b.seen[x], largest);
                }
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(height.div_ceil(BAND_ROWS));
    std::thread::scope(|scope| {
        // Where no further thread can be had, the others do its work.
        (1..threads).for_each(|_| drop(std::thread::Builder::new().spawn_scoped(scope, work)));
        work();
    });
    ErrorMap { width, height, errors }
}

/// What of a pixel is compared: CIELAB with the Hunt effect, the strengths of an edge and of a point.
#[derive(Clone, Copy, Debug, Default)]
struct PixelFeatures {
    hunt_lab: [f32; 3],
    edge: f32,
    point: f32,
}

/// The compressed difference of colour of the two most different primaries, green and blue: the largest that there is.
fn largest_colour_difference() -> f32 {
    hyab(hunt_lab_from_rgb([0.0, 1.0, 0.0]), hunt_lab_from_rgb([0.0, 0.0, 1.0])).powf(COLOUR_EXPONENT)
}

/// The difference of two pixels, 0 to 1: that of colour, raised where one has a feature that the other lacks.
fn difference(a: PixelFeatures, b: PixelFeatures, largest: f32) -> f32 {
    let compressed = hyab(a.hunt_lab, b.hunt_lab).powf(COLOUR_EXPONENT);
    let common = COMMON_SHARE * largest;
    let colour = if compressed < common {
        MAPPED_SHARE / common * compressed
    } else {
        MAPPED_SHARE + (compressed - common) / (largest - common) * (1.0 - MAPPED_SHARE)
    };
    let feature = (a.edge - b.edge).abs().max((a.point - b.point).abs()) * std::f32::consts::FRAC_1_SQRT_2;
    let feature = feature.powf(FEATURE_EXPONENT).min(1.0);
    // Colours beyond the gamut's primaries are none, so that rounding alone can pass 1.
    colour.min(1.0).powf(1.0 - feature)
}

/// The rows of one picture around a band, filtered along rows, and one row of them filtered along columns.
#[derive(Debug)]
struct Workspace {
    /// The width, made a multiple of [`LANES`].
    stride: usize,
    border_px: usize,
    /// Luminance, red against green, blue against yellow by two Gaussians; luminance by the Gaussian of features and by
    /// its two derivatives.
    along_rows: [Vec<f32>; 7],
    /// A row of YyCxCz, and of relative luminance, with borders.
    padded: [Vec<f32>; 4],
    /// A row of filtered YyCxCz; of edges along x and y, and of points along x and y.
    columns: [Vec<f32>; 7],
    seen: Vec<PixelFeatures>,
}

impl Workspace {
    fn new(width: usize, filters: &Filters) -> Self {
        let stride = width.next_multiple_of(LANES);
        let border_px = filters.radius_px();
        let row = |length: usize| vec![0.0; length];
        Self {
            stride,
            border_px,
            along_rows: std::array::from_fn(|_| row(stride * (BAND_ROWS + 2 * border_px))),
            padded: std::array::from_fn(|_| row(stride + 2 * border_px)),
            columns: std::array::from_fn(|_| row(stride)),
            seen: vec![PixelFeatures::default(); width],
        }
    }

    /// Filters `rows` rows from `first` on, and those around them, along rows.
    fn begin(
        &mut self,
        picture: &Picture,
        first: usize,
        rows: usize,
        filters: &Filters,
        shown: &impl Fn([f32; 3]) -> [f32; 3],
    ) {
        let Filters { luminance, red_green, blue_yellow: [wide, narrow], smooth, edge, point, .. } = filters;
        for row in 0..rows + 2 * self.border_px {
            self.pad(picture.row((first + row) as isize - self.border_px as isize), shown);
            let [luma, cx, cz, relative] = &self.padded;
            let sources = [luma, cx, cz, cz, relative, relative, relative];
            let kernels = [luminance, red_green, wide, narrow, smooth, edge, point];
            for ((kernel, source), plane) in kernels.iter().zip(sources).zip(&mut self.along_rows) {
                kernel.along_row(source, self.border_px, &mut plane[row * self.stride..][..self.stride]);
            }
        }
    }

    /// Takes a row of a picture; its ends go on to either side.
    fn pad(&mut self, row: &[[f32; 3]], shown: &impl Fn([f32; 3]) -> [f32; 3]) {
        let last = self.border_px + row.len() - 1;
        let [luma, cx, cz, relative] = &mut self.padded;
        for (x, rgb) in row.iter().enumerate() {
            let at = self.border_px + x;
            [luma[at], cx[at], cz[at]] = ycxcz_from_rgb(shown(*rgb).map(|value| value.clamp(0.0, 1.0)));
            relative[at] = (luma[at] + 16.0) / 116.0;
        }
        for line in &mut self.padded {
            let (left, right) = (line[self.border_px], line[last]);
            line[..self.border_px].fill(left);
            line[last + 1..].fill(right);
        }
    }

    /// Filters row `row` of the band along columns, into `seen`.
    fn finish_row(&mut self, row: usize, filters: &Filters) {
        let middle = row + self.border_px;
        let [wide, narrow] = &filters.blue_yellow_columns;
        // The plane, the kernel, and the row that it adds to.
        let steps = [
            (0, &filters.luminance, 0),
            (1, &filters.red_green, 1),
            (2, wide, 2),
            (3, narrow, 2),
            (5, &filters.smooth, 3),
            (4, &filters.edge, 4),
            (6, &filters.smooth, 5),
            (4, &filters.point, 6),
        ];
        self.columns.iter_mut().for_each(|column| column.fill(0.0));
        for (plane, kernel, column) in steps {
            kernel.along_column(&self.along_rows[plane], middle, &mut self.columns[column]);
        }
        let [luma, cx, cz, edge_x, edge_y, point_x, point_y] = &self.columns;
        for (x, seen) in self.seen.iter_mut().enumerate() {
            let rgb = rgb_from_ycxcz([luma[x], cx[x], cz[x]]).map(|value| value.clamp(0.0, 1.0));
            *seen = PixelFeatures {
                hunt_lab: hunt_lab_from_rgb(rgb),
                edge: (edge_x[x] * edge_x[x] + edge_y[x] * edge_y[x]).sqrt(),
                point: (point_x[x] * point_x[x] + point_y[x] * point_y[x]).sqrt(),
            };
        }
    }
}
