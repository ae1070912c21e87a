//! Convolution by one row or column of weights: all filters of FLIP are sums of products of such two.

/// How many values are summed up at a time, so that the compiler keeps them in registers.
pub const LANES: usize = 16;

/// An odd number of weights around the middle.
#[derive(Clone, Debug)]
pub struct Kernel {
    weights: Vec<f32>,
}

impl Kernel {
    /// `weight` of every whole number of pixels up to `radius_px` to either side, times `scale`.
    pub fn new(radius_px: usize, scale: f64, weight: impl Fn(f64) -> f64) -> Self {
        let radius = radius_px as i64;
        Self { weights: (-radius..=radius).map(|x| (scale * weight(x as f64)) as f32).collect() }
    }

    /// How many pixels it reaches to either side.
    pub fn radius_px(&self) -> usize {
        self.weights.len() / 2
    }

    /// Convolves a row that has `border_px` values more at either end, and is `out.len()` long else, a multiple of
    /// [`LANES`].
    pub fn along_row(&self, padded: &[f32], border_px: usize, out: &mut [f32]) {
        let first = border_px - self.radius_px();
        for (chunk, out) in out.chunks_exact_mut(LANES).enumerate() {
            let start = first + chunk * LANES;
            let mut sums = [0.0; LANES];
            for (k, &weight) in self.weights.iter().enumerate() {
                add(&mut sums, weight, &padded[start + k..][..LANES]);
            }
            out.copy_from_slice(&sums);
        }
    }

    /// Convolves downwards rows that lie one after the other in `plane`, each of `out.len()` values, a multiple of
    /// [`LANES`], around row `middle`; adds the result to `out`.
    pub fn along_column(&self, plane: &[f32], middle: usize, out: &mut [f32]) {
        let stride = out.len();
        let first = (middle - self.radius_px()) * stride;
        for (chunk, out) in out.chunks_exact_mut(LANES).enumerate() {
            let mut sums = [0.0; LANES];
            sums.copy_from_slice(out);
            for (k, &weight) in self.weights.iter().enumerate() {
                add(&mut sums, weight, &plane[first + k * stride + chunk * LANES..][..LANES]);
            }
            out.copy_from_slice(&sums);
        }
    }
}

#[inline(always)]
fn add(sums: &mut [f32; LANES], weight: f32, values: &[f32]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += weight * value;
    }
}
