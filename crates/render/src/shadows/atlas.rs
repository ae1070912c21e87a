//! Which part of the atlas belongs to whom: squares whose sides are powers of two, cut from larger ones.
//!
//! Source: the buddy system (Knowlton 1965, "A Fast Storage Allocator"), in two dimensions. Squares that are taken in
//! descending order fill the atlas without a gap.

/// A square of the atlas, in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Square {
    /// The left edge.
    pub x: u32,
    /// The upper edge.
    pub y: u32,
    /// The side.
    pub side: u32,
}

/// The squares that are free, by the logarithm of their side.
#[derive(Clone, Debug)]
pub struct Allocator {
    side: u32,
    free: Vec<Vec<Square>>,
}

impl Allocator {
    /// An atlas whose side is a power of two.
    pub fn new(side: u32) -> Self {
        let levels = side.ilog2() as usize + 1;
        let mut free = vec![Vec::new(); levels];
        free[levels - 1].push(Square { x: 0, y: 0, side });
        Self { side, free }
    }

    /// The side of the atlas.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Takes a square whose side is the power of two `side`, if there is one.
    pub fn take(&mut self, side: u32) -> Option<Square> {
        let level = side.checked_ilog2()? as usize;
        let from = (level..self.free.len()).find(|level| !self.free[*level].is_empty())?;
        let mut square = self.free[from].pop()?;
        for level in (level..from).rev() {
            let half = 1 << level;
            let corner = |dx, dy| Square { x: square.x + dx * half, y: square.y + dy * half, side: half };
            self.free[level].extend([corner(1, 1), corner(0, 1), corner(1, 0)]);
            square = corner(0, 0);
        }
        Some(square)
    }

    /// Gives a square back; four that make up a larger one become that.
    pub fn give(&mut self, square: Square) {
        let mut square = square;
        loop {
            let level = square.side.ilog2() as usize;
            if level + 1 == self.free.len() {
                break;
            }
            let parent = 2 * square.side;
            let (x, y) = (square.x / parent * parent, square.y / parent * parent);
            let is_sibling = |other: &Square| other.x / parent * parent == x && other.y / parent * parent == y;
            if self.free[level].iter().filter(|other| is_sibling(other)).count() < 3 {
                break;
            }
            self.free[level].retain(|other| !is_sibling(other));
            square = Square { x, y, side: parent };
        }
        self.free[square.side.ilog2() as usize].push(square);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    fn overlaps(a: &Square, b: &Square) -> bool {
        a.x < b.x + b.side && b.x < a.x + a.side && a.y < b.y + b.side && b.y < a.y + a.side
    }

    #[test]
    fn squares_fill_the_atlas_and_are_given_back() {
        let mut atlas = Allocator::new(256);
        let sides = [128, 128, 64, 64, 64, 32, 32, 32, 32, 64, 64, 64, 16];
        let mut taken: Vec<Square> = Vec::new();
        for side in sides {
            let Some(square) = atlas.take(side) else { panic!("no place for {side}") };
            assert!(square.side == side && square.x + side <= 256 && square.y + side <= 256);
            assert!(square.x % side == 0 && square.y % side == 0);
            assert!(!taken.iter().any(|other| overlaps(other, &square)), "{square:?} {taken:?}");
            taken.push(square);
        }
        assert_eq!(atlas.take(256), None);
        // In another order than they were taken.
        taken.sort_by_key(|square| (square.y * 31 + square.x * 17) % 257);
        taken.into_iter().for_each(|square| atlas.give(square));
        assert_eq!(atlas.take(256), Some(Square { x: 0, y: 0, side: 256 }));
        assert_eq!(atlas.take(1), None);
    }

    #[test]
    fn descending_squares_leave_no_gap() {
        let mut atlas = Allocator::new(64);
        let sides = [32, 32, 16, 16, 16, 16, 16, 16, 8, 8, 8, 8, 8, 8, 8, 4, 4, 4, 4];
        assert_eq!(sides.iter().map(|side| side * side).sum::<u32>(), 64 * 64);
        assert!(sides.iter().all(|side| atlas.take(*side).is_some()));
        assert_eq!(atlas.take(1), None);
    }
}
