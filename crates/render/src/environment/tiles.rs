//! Where the tiles of a picture of the environment lie in their texture; `environment_tiles.wgsl` has the same for shaders.

use crate::constants::{ENVIRONMENT_COARSE_SIDE, ENVIRONMENT_FINE_SIDE, ENVIRONMENT_LEVEL_COARSE};

/// A tile: its corner behind the border of one texel, and its side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    pub corner: [u32; 2],
    pub side: u32,
}

impl Tile {
    /// X and y of its corner, width and height, with its border.
    pub fn rectangle(&self) -> [u32; 4] {
        let [x, y] = self.corner;
        [x - 1, y - 1, self.side + 2, self.side + 2]
    }

    /// Of a level, where that of the mirror is `mirror_side` wide.
    pub fn of_level(level: u32, mirror_side: u32) -> Self {
        let (fine, coarse) = (ENVIRONMENT_FINE_SIDE + 2, ENVIRONMENT_COARSE_SIDE + 2);
        let below = mirror_side + 2;
        let first_coarse = ENVIRONMENT_LEVEL_COARSE as u32;
        let ([x, y], side) = if level == 0 {
            ([0, 0], mirror_side)
        } else if level < first_coarse {
            let at = level - 1;
            ([at % 2 * fine, below + at / 2 * fine], ENVIRONMENT_FINE_SIDE)
        } else {
            let at = level - first_coarse;
            ([at % 4 * coarse, below + 3 * fine + at / 4 * coarse], ENVIRONMENT_COARSE_SIDE)
        };
        Self { corner: [x + 1, y + 1], side }
    }
}

/// Width and height of the texture.
pub(crate) fn texture_size(mirror_side: u32) -> (u32, u32) {
    let (fine, coarse) = (ENVIRONMENT_FINE_SIDE + 2, ENVIRONMENT_COARSE_SIDE + 2);
    ((mirror_side + 2).max(2 * fine), mirror_side + 2 + 3 * fine + 2 * coarse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::ENVIRONMENT_LEVEL_LAST;

    #[test]
    fn tiles_lie_within_the_texture_and_apart() {
        for mirror_side in [16, 512, 2048] {
            let (width, height) = texture_size(mirror_side);
            let tiles = (0..=ENVIRONMENT_LEVEL_LAST as u32).map(|level| Tile::of_level(level, mirror_side).rectangle());
            let tiles: Vec<[u32; 4]> = tiles.collect();
            for (i, [x, y, w, h]) in tiles.iter().enumerate() {
                assert!(x + w <= width && y + h <= height);
                let meets = |[a, b, c, d]: &[u32; 4]| x < &(a + c) && a < &(x + w) && y < &(b + d) && b < &(y + h);
                assert!(!tiles[..i].iter().any(meets), "tile {i}");
            }
        }
    }
}
