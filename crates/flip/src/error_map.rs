//! What a comparison gives: an error for every pixel, and numbers about all of them.

/// The error of every pixel, 0 (no difference can be seen) to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// `width · height` errors, rows from the top.
    pub errors: Vec<f32>,
}

/// The largest error of a map, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestError {
    /// The error, 0 to 1.
    pub error: f32,
    /// Columns from the left.
    pub x: usize,
    /// Rows from the top.
    pub y: usize,
}

impl ErrorMap {
    /// The mean of all errors: the number by which FLIP is quoted.
    pub fn mean(&self) -> f64 {
        self.sum() / self.errors.len().max(1) as f64
    }

    /// The largest error; the first of several, row by row.
    pub fn largest(&self) -> LargestError {
        let first = LargestError { error: 0.0, x: 0, y: 0 };
        self.errors.iter().enumerate().fold(first, |largest, (index, &error)| {
            if error > largest.error {
                LargestError { error, x: index % self.width, y: index / self.width }
            } else {
                largest
            }
        })
    }

    /// The smallest errors such that all errors up to them make up these shares (0 to 1) of the sum of all: at 0.25,
    /// 0.5 and 0.75 the paper's weighted quartiles and median. 0 where nothing differs.
    pub fn weighted_quantiles<const N: usize>(&self, shares: [f64; N]) -> [f32; N] {
        let mut sorted = self.errors.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let total = self.sum();
        shares.map(|share| {
            let mut sum = 0.0;
            let reaches = |&&error: &&f32| {
                sum += f64::from(error);
                sum >= share * total
            };
            sorted.iter().find(reaches).or(sorted.last()).copied().unwrap_or(0.0)
        })
    }

    fn sum(&self) -> f64 {
        self.errors.iter().copied().map(f64::from).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_about_a_map_are_those_counted_by_hand() {
        let map = ErrorMap { width: 2, height: 2, errors: vec![0.1, 0.4, 0.2, 0.3] };
        assert!((map.mean() - 0.25).abs() < 1e-7);
        assert_eq!(map.largest(), LargestError { error: 0.4, x: 1, y: 0 });
        // The sums of errors in order are 0.1, 0.3, 0.6 and 1.
        assert_eq!(map.weighted_quantiles([0.05, 0.25, 0.5, 0.75]), [0.1, 0.2, 0.3, 0.4]);
        let same = ErrorMap { width: 1, height: 1, errors: vec![0.0] };
        assert_eq!((same.mean(), same.largest().error, same.weighted_quantiles([0.5])), (0.0, 0.0, [0.0]));
    }
}
