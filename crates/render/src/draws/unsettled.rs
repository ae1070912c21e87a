//! Which tiles of a still are to be drawn on.

use crate::constants::SETTLED_TILE_PX;
use glam::Vec2;

/// How many tiles of a still's picture are not settled, in each rectangle of tiles from the first: a summed-area table
/// (Crow 1984, "Summed-Area Tables for Texture Mapping").
#[derive(Debug)]
pub(crate) struct UnsettledTiles {
    /// Tiles across and down.
    size: [usize; 2],
    /// Row by row, of one more than there are tiles in each direction.
    sums: Vec<u32>,
}

impl UnsettledTiles {
    /// From the texels of the texture that says which tiles are settled, of a picture of `size`.
    pub fn new(settled: &[u8], (width, height): (u32, u32)) -> Self {
        let [across, down] = [width, height].map(|side| side.div_ceil(SETTLED_TILE_PX as u32) as usize);
        let mut sums = vec![0; (across + 1) * (down + 1)];
        for y in 0..down {
            let mut of_row = 0;
            for x in 0..across {
                // What is not known is drawn.
                of_row += u32::from(settled.get(y * across + x).is_none_or(|share| *share == 0));
                sums[(y + 1) * (across + 1) + x + 1] = sums[y * (across + 1) + x + 1] + of_row;
            }
        }
        Self { size: [across, down], sums }
    }

    /// Whether any tile is not settled that the rectangle between two places touches, in pixels from the top left
    /// corner.
    pub fn touches(&self, low_px: Vec2, high_px: Vec2) -> bool {
        let [across, down] = self.size;
        let tile = |px: f32| (px / SETTLED_TILE_PX as f32).max(0.0) as usize;
        let (left, right) = (tile(low_px.x).min(across), (tile(high_px.x) + 1).min(across));
        let (top, bottom) = (tile(low_px.y).min(down), (tile(high_px.y) + 1).min(down));
        let sum = |x: usize, y: usize| self.sums[y * (across + 1) + x];
        // Sums of different corners, of which the first two are the greatest.
        sum(right, bottom) + sum(left, top) > sum(left, bottom) + sum(right, top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_touches_the_tiles_in_it() {
        // 5 by 3 tiles, of which one is not settled.
        let mut settled = [191; 15];
        settled[5 + 3] = 0;
        let tiles = UnsettledTiles::new(&settled, (18, 11));
        let touches = |low: (f32, f32), high: (f32, f32)| tiles.touches(low.into(), high.into());
        assert!(touches((13.0, 5.0), (13.5, 5.5)) && touches((-9.0, -9.0), (99.0, 99.0)));
        assert!(touches((0.0, 0.0), (12.5, 4.5)) && touches((15.5, 7.5), (40.0, 40.0)));
        assert!(!touches((0.0, 0.0), (11.5, 40.0)) && !touches((16.5, 0.0), (40.0, 40.0)));
        assert!(!touches((0.0, 0.0), (40.0, 3.5)) && !touches((0.0, 8.5), (40.0, 40.0)));
        assert!(!touches((90.0, 90.0), (99.0, 99.0)));
    }
}
