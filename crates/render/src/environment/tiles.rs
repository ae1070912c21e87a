//! Where the tiles of a picture of the environment lie in their texture; `environment_tiles.wgsl` has the same for shaders.

use crate::constants::ENVIRONMENT_LEVEL_COARSE;
use crate::octahedral::direction_from_octahedral;
use glam::{Vec2, Vec3, Vec4};

/// The sides of the tiles in texels: the mirror's, those of little roughness, those of more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TileSides {
    pub mirror: u32,
    pub fine: u32,
    pub coarse: u32,
}

impl TileSides {
    /// Of a picture whose mirror's tile has the side `mirror`.
    pub fn of_picture(mirror: u32) -> Self {
        Self { mirror, fine: 256, coarse: 64 }
    }

    /// As shaders take them.
    pub fn uniform(&self) -> Vec4 {
        Vec4::new(self.mirror as f32, self.fine as f32, self.coarse as f32, 0.0)
    }
}

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

    /// Of a level.
    pub fn of_level(level: u32, sides: TileSides) -> Self {
        let (fine, coarse) = (sides.fine + 2, sides.coarse + 2);
        let below = sides.mirror + 2;
        let first_coarse = ENVIRONMENT_LEVEL_COARSE as u32;
        let ([x, y], side) = if level == 0 {
            ([0, 0], sides.mirror)
        } else if level < first_coarse {
            let at = level - 1;
            ([at % 2 * fine, below + at / 2 * fine], sides.fine)
        } else {
            let at = level - first_coarse;
            ([at % 4 * coarse, below + 3 * fine + at / 4 * coarse], sides.coarse)
        };
        Self { corner: [x + 1, y + 1], side }
    }

    /// The direction of the middle of a texel of [`Self::rectangle`]. The border goes on at the other end of the same edge.
    pub fn direction(&self, [x, y]: [u32; 2]) -> Vec3 {
        let place = |at: u32| (2.0 * at as f32 - 1.0) / self.side as f32 - 1.0;
        let inside = |at: f32| if at.abs() > 1.0 { at.signum() * 2.0 - at } else { at };
        let turned = |at: f32, other: f32| if other.abs() > 1.0 { -inside(at) } else { inside(at) };
        let (x, y) = (place(x), place(y));
        direction_from_octahedral(Vec2::new(turned(x, y), turned(y, x)))
    }
}

/// Width and height of the texture.
pub(crate) fn texture_size(sides: TileSides) -> (u32, u32) {
    let (fine, coarse) = (sides.fine + 2, sides.coarse + 2);
    ((sides.mirror + 2).max(2 * fine).max(4 * coarse), sides.mirror + 2 + 3 * fine + 2 * coarse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::ENVIRONMENT_LEVEL_LAST;

    #[test]
    fn tiles_lie_within_the_texture_and_apart() {
        let of_pictures = [16, 512, 2048].map(TileSides::of_picture);
        for sides in of_pictures.into_iter().chain([crate::environment::studio::SIDES]) {
            let (width, height) = texture_size(sides);
            let tiles = (0..=ENVIRONMENT_LEVEL_LAST as u32).map(|level| Tile::of_level(level, sides).rectangle());
            let tiles: Vec<[u32; 4]> = tiles.collect();
            for (i, [x, y, w, h]) in tiles.iter().enumerate() {
                assert!(x + w <= width && y + h <= height);
                let meets = |[a, b, c, d]: &[u32; 4]| x < &(a + c) && a < &(x + w) && y < &(b + d) && b < &(y + h);
                assert!(!tiles[..i].iter().any(meets), "tile {i}");
            }
        }
    }
}
