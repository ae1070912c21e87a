//! The parts of a picture that samples are still added to, as rectangles.

use crate::constants::SETTLED_TILE_PX;
use crate::lights::Rectangle;

/// Tiles along the sides of the blocks that rectangles are made of: 32 pixels, half of what software adapters draw at a
/// time, so that few pixels are drawn in vain, and in few rectangles.
const BLOCK_TILES: usize = 8;

/// Rectangles around all tiles that are not settled, x and y of the corner, width and height in pixels, which do not
/// overlap; from the texels of the texture that says which tiles are, of a picture of `size`.
pub fn unsettled_rectangles(settled: &[u8], (width, height): (u32, u32)) -> Vec<Rectangle> {
    let across = width.div_ceil(SETTLED_TILE_PX as u32) as usize;
    let block_px = BLOCK_TILES as u32 * SETTLED_TILE_PX as u32;
    let mut rectangles: Vec<Rectangle> = Vec::new();
    for (row, tiles) in settled.chunks(across.max(1) * BLOCK_TILES).enumerate() {
        let top = row as u32 * block_px;
        let is_unsettled = |block: usize| {
            let columns = block * BLOCK_TILES..((block + 1) * BLOCK_TILES).min(across);
            tiles.chunks(across).any(|line| line.get(columns.clone()).is_some_and(|line| line.contains(&0)))
        };
        let mut run: Option<Rectangle> = None;
        for block in 0..=across.div_ceil(BLOCK_TILES) {
            let left = block as u32 * block_px;
            if left < width && is_unsettled(block) {
                let [.., run_width, _] = run.get_or_insert([left, top, 0, block_px.min(height - top)]);
                *run_width += block_px.min(width - left);
            } else if let Some([x, y, run_width, run_height]) = run.take() {
                // As wide as the one above it, they are one.
                let above = rectangles
                    .iter_mut()
                    .find(|above| above[0] == x && above[2] == run_width && above[1] + above[3] == y);
                match above {
                    Some(above) => above[3] += run_height,
                    None => rectangles.push([x, y, run_width, run_height]),
                }
            }
        }
    }
    rectangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_hold_all_that_is_not_settled_once() {
        // Sides that are multiples of nothing.
        let size: (u32, u32) = (197, 131);
        let (across, down) = (size.0.div_ceil(4), size.1.div_ceil(4));
        for seed in 0..40u32 {
            let tile = |x: u32, y: u32| -> u8 {
                let mixed =
                    (x / (1 + seed % 9)).wrapping_mul(0x9e37_79b9) ^ (y / (1 + seed % 7)).wrapping_mul(0x85eb_ca6b);
                if mixed.wrapping_mul(seed + 1) >> 29 > seed % 8 { 191 } else { 0 }
            };
            let settled: Vec<u8> = (0..down).flat_map(|y| (0..across).map(move |x| tile(x, y))).collect();
            let rectangles = unsettled_rectangles(&settled, size);
            let holds = |[left, top, width, height]: &Rectangle, x: u32, y: u32| {
                (*left..left + width).contains(&x) && (*top..top + height).contains(&y)
            };
            for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
                let count = rectangles.iter().filter(|rectangle| holds(rectangle, x, y)).count();
                assert!(count == 1 || count == 0 && tile(x / 4, y / 4) > 0, "{count} at {x}, {y} of {rectangles:?}");
            }
            assert!(rectangles.iter().all(|[x, y, width, height]| x + width <= size.0 && y + height <= size.1));
        }
        assert!(unsettled_rectangles(&vec![191; (across * down) as usize], size).is_empty());
        assert_eq!(unsettled_rectangles(&vec![0; (across * down) as usize], size), [[0, 0, 197, 131]]);
    }
}
