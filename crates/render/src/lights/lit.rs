//! The part of the picture that lights with a range may reach, as rectangles: the others need not be shaded by them.

use super::ClusterLists;

/// More rectangles than this cost more as draws than they spare.
const RECTANGLES_MAX: usize = 128;

/// Where more than so many tenths of the picture are lit, one rectangle of all of it costs less.
const LIT_TENTHS_MAX: u64 = 8;

/// X and y of the corner, width and height, in pixels.
pub type Rectangle = [u32; 4];

/// Rectangles without overlap around all tiles of the picture, of `size` pixels, in which any list holds a light: none
/// if none does, and one of the whole picture if a light is in no list, or if nearly all are lit.
pub fn lit_rectangles(lists: &ClusterLists, size: (u32, u32)) -> Vec<Rectangle> {
    let everything = || vec![[0, 0, size.0, size.1]];
    if lists.uniform.global_count > 0 {
        return everything();
    }
    let Some(rectangles) = merged(&lit_tiles(lists)) else { return everything() };
    let [across, down, _, tile_px] = lists.uniform.size;
    // What lies beyond the last tile belongs to it.
    let edge = |tile: u32, count: u32, side: u32| if tile == count { side } else { (tile * tile_px).min(side) };
    let rectangles: Vec<Rectangle> = rectangles
        .into_iter()
        .map(|[x0, y0, x1, y1]| {
            let [left, right] = [x0, x1].map(|tile| edge(tile, across, size.0));
            let [top, bottom] = [y0, y1].map(|tile| edge(tile, down, size.1));
            [left, top, right - left, bottom - top]
        })
        .filter(|[.., width, height]| *width > 0 && *height > 0)
        .collect();
    let lit: u64 = rectangles.iter().map(|[.., width, height]| u64::from(*width) * u64::from(*height)).sum();
    let all = u64::from(size.0) * u64::from(size.1);
    if lit * 10 > all * LIT_TENTHS_MAX { everything() } else { rectangles }
}

/// Row by row, whether any slice of a tile holds a light.
fn lit_tiles(lists: &ClusterLists) -> Vec<Vec<bool>> {
    let [across, down, slices, _] = lists.uniform.size.map(|count| count as usize);
    let mut rows = vec![vec![false; across]; down];
    // Lists of objects lie behind those of clusters.
    for (row, clusters) in lists.table.chunks_exact(across).take(down * slices).enumerate() {
        for (is_lit, list) in rows[row % down].iter_mut().zip(clusters) {
            *is_lit |= list.count() > 0;
        }
    }
    rows
}

/// The runs of lit tiles of every row, those of the same columns in rows that follow each other as one: the first
/// column and row, and those behind the last. None if there are too many, which ends the search, too.
fn merged(rows: &[Vec<bool>]) -> Option<Vec<Rectangle>> {
    let mut done = Vec::new();
    let mut open: Vec<Rectangle> = Vec::new();
    for (y, row) in (0..).zip(rows) {
        let mut next = Vec::new();
        let runs = runs(row);
        if done.len() + runs.len() > RECTANGLES_MAX {
            return None;
        }
        for [x0, x1] in runs {
            let above = open.iter().position(|[left, _, right, _]| [*left, *right] == [x0, x1]);
            let y0 = above.map_or(y, |at| open.swap_remove(at)[1]);
            next.push([x0, y0, x1, y + 1]);
        }
        done.append(&mut open);
        open = next;
    }
    done.append(&mut open);
    (done.len() <= RECTANGLES_MAX).then_some(done)
}

/// The first column of every run of lit tiles, and that behind the last.
fn runs(row: &[bool]) -> Vec<[u32; 2]> {
    let mut runs: Vec<[u32; 2]> = Vec::new();
    for (x, _) in (0..).zip(row).filter(|(_, is_lit)| **is_lit) {
        match runs.last_mut() {
            Some([_, end]) if *end == x => *end = x + 1,
            _ => runs.push([x, x + 1]),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::{LightTable, ListRecord};

    /// The record of a list of so many lights.
    fn record(count: u16) -> ListRecord {
        ListRecord::new(0, &(0..count).collect::<Vec<_>>(), &[u32::MAX; 6])
    }

    /// Lists of 20 × 10 tiles of 16 pixels and two slices, of which those lists hold a light that `is_lit` by slice,
    /// row and column. There are lists of objects behind them.
    fn lists(is_lit: impl Fn(u32, u32, u32) -> bool) -> ClusterLists {
        let mut lists = ClusterLists::nothing(&LightTable::default(), (313, 155));
        lists.uniform.size = [20, 10, 2, 16];
        let places = (0..2).flat_map(|slice| (0..10).flat_map(move |y| (0..20).map(move |x| (slice, y, x))));
        lists.table = places.map(|(slice, y, x)| record(u16::from(is_lit(slice, y, x)))).collect();
        lists.table.extend([record(7); 45]);
        lists
    }

    #[test]
    fn rectangles_are_the_pixels_of_lit_tiles_each_once() {
        let patterns: [fn(u32, u32, u32) -> bool; 4] = [
            |_, y, x| (3..7).contains(&y) && (4..9).contains(&x) || x == 19 || y == 9 && x > 16,
            |slice, y, x| slice == (y + x) % 2 && (x * 7 + y * 5) % 11 < 3,
            |slice, y, x| slice == 1 && y == 9 && x == 19,
            |_, y, x| x >= y && x < y + 3,
        ];
        for (number, is_lit) in patterns.into_iter().enumerate() {
            let rectangles = lit_rectangles(&lists(is_lit), (313, 155));
            for (y, x) in (0..155).flat_map(|y| (0..313).map(move |x| (y, x))) {
                let covers = |[left, top, width, height]: &&Rectangle| {
                    (*left..left + width).contains(&x) && (*top..top + height).contains(&y)
                };
                let expected = (0..2).any(|slice| is_lit(slice, y / 16, x / 16));
                let count = rectangles.iter().filter(covers).count();
                assert_eq!(count, usize::from(expected), "pattern {number}, pixel {x}, {y}: {rectangles:?}");
            }
        }
        let block = lit_rectangles(&lists(|_, y, x| (3..7).contains(&y) && (4..9).contains(&x)), (313, 155));
        assert_eq!(block, [[64, 48, 80, 64]], "rows of the same columns are one rectangle");
    }

    #[test]
    fn what_is_lit_nearly_everywhere_or_in_too_many_pieces_is_one_rectangle() {
        let whole = [[0, 0, 313, 155]];
        assert_eq!(lit_rectangles(&lists(|_, y, x| y > 0 || x > 2), (313, 155)), whole);
        assert_eq!(lit_rectangles(&lists(|_, y, x| (x + y) % 2 == 0 && y < 9), (313, 155)).len(), 90);
        let mut fine = lists(|_, _, _| false);
        fine.uniform.size = [60, 10, 1, 5];
        fine.table = (0..600u16).map(|at| record((at % 60 + at / 60) % 2)).collect();
        assert_eq!(lit_rectangles(&fine, (300, 50)), [[0, 0, 300, 50]], "300 pieces");
        assert_eq!(lit_rectangles(&lists(|_, _, _| false), (313, 155)), [[0; 4]; 0], "nothing is lit");
        let mut global = lists(|_, _, _| false);
        global.uniform.global_count = 1;
        assert_eq!(lit_rectangles(&global, (313, 155)), whole, "a light in no list reaches everything");
    }
}
