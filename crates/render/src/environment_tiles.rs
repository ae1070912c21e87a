//! Where the tiles of a picture of the environment lie in their texture; `environment_tiles.wgsl` has the same for
//! shaders.

use crate::constants::{ENVIRONMENT_LEVEL_COARSE, ENVIRONMENT_LEVEL_MEDIUM};
use crate::octahedral::direction_from_octahedral;
use glam::{Vec2, Vec3, Vec4};

/// The sides of the tiles in texels: the mirror's, those of little roughness, of more, and of much.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TileSides {
    pub mirror: u32,
    pub fine: u32,
    pub medium: u32,
    pub coarse: u32,
}

/// The largest side of the mirror's tile.
const MIRROR_SIDE_MAX: u32 = 2048;

impl TileSides {
    /// Of a picture of a width, for devices whose textures have a largest side. Where that is small, or the picture,
    /// tiles are smaller.
    pub fn of_picture(width: u32, texture_side_max: u32) -> Self {
        let [fine_max, medium_max] = if texture_side_max < 4096 { [256, 128] } else { [512, 256] };
        let fine = (width / 2).next_power_of_two().clamp(128, fine_max);
        let (medium, coarse) = (fine.min(medium_max), 64);
        let below = texture_size(Self { mirror: 0, fine, medium, coarse }).1;
        let mirror = (width / 2).clamp(16, MIRROR_SIDE_MAX.min(texture_side_max.saturating_sub(below)).max(16));
        Self { mirror, fine, medium, coarse }
    }

    /// As shaders take them.
    pub fn uniform(&self) -> Vec4 {
        Vec4::from([self.mirror, self.fine, self.medium, self.coarse].map(|side| side as f32))
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
        let TileSides { mirror, fine, medium, coarse } = sides;
        let [first_medium, first_coarse] =
            [ENVIRONMENT_LEVEL_MEDIUM, ENVIRONMENT_LEVEL_COARSE].map(|level| level as u32);
        let below = mirror + 2;
        let (first, columns, side, top) = match level {
            0 => return Self { corner: [1, 1], side: mirror },
            _ if level < first_medium => (1, 2, fine, below),
            _ if level < first_coarse => (first_medium, 4, medium, below + 3 * (fine + 2)),
            _ => (first_coarse, 16, coarse, below + 3 * (fine + 2) + 2 * (medium + 2)),
        };
        let at = level - first;
        Self { corner: [at % columns * (side + 2) + 1, top + at / columns * (side + 2) + 1], side }
    }

    /// The direction of the middle of a texel of [`Self::rectangle`]. The border goes on at the other end of the same
    /// edge.
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
    let TileSides { mirror, fine, medium, coarse } = sides;
    let [mirror, fine, medium, coarse] = [mirror, fine, medium, coarse].map(|side| side + 2);
    (mirror.max(2 * fine).max(4 * medium).max(10 * coarse), mirror + 3 * fine + 2 * medium + coarse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::ENVIRONMENT_LEVEL_LAST;

    #[test]
    fn tiles_lie_within_the_texture_and_apart() {
        let of_pictures = [(1, 2048), (1024, 2048), (4096, 2048), (2048, 4096), (4096, 4096), (4096, 16_384)]
            .map(|(width, largest)| (TileSides::of_picture(width, largest), largest));
        for (sides, largest) in of_pictures.into_iter().chain([(crate::environment::studio::SIDES, 2048)]) {
            let (width, height) = texture_size(sides);
            assert!(width <= largest && height <= largest, "{sides:?}");
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
