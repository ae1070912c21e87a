//! The coarser forms of one node or material.

/// The levels of detail of a node or of a material (`MSFT_lod`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Levels<T> {
    /// Finer ones first; level 0 is the node or the material itself, and is none of them.
    pub coarser: Vec<T>,
    /// The share of the picture's area down to which each level is shown, that of level 0 first; below the last,
    /// nothing. What takes the area is the ball around the finest level. Where there are fewer than levels,
    /// [`Self::end_coverage`] says how they go on.
    pub screen_coverage: Vec<f32>,
}

/// Where a file does not say down to which share of the picture's area its node or material itself is shown: a quarter.
const FIRST_COVERAGE: f32 = 0.25;

impl<T> Levels<T> {
    /// How many levels there are, level 0 among them.
    pub fn count(&self) -> usize {
        self.coarser.len() + 1
    }

    /// The share of the picture's area down to which `level` is shown. Where the file does not say it, each ends at
    /// half the size of the one before, which is a quarter of the area, and the last never.
    pub fn end_coverage(&self, level: usize) -> f32 {
        if let Some(coverage) = self.screen_coverage.get(level) {
            return *coverage;
        }
        if level + 1 >= self.count() {
            return 0.0;
        }
        let (known, first) = match self.screen_coverage.last() {
            Some(last) => (self.screen_coverage.len(), 0.25 * last),
            None => (0, FIRST_COVERAGE),
        };
        first * 0.25f32.powi((level - known) as i32)
    }
}
