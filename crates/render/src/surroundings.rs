//! What stands for the environment in parts of the scene: where its tiles lie, and what shaders know of it.

use crate::environment_tiles::{Tile, TileSides, texture_size};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3, Vec4};
use manypass_scene::Scene;
use manypass_scene::surroundings::{Region, SURROUNDINGS_MAX, Surroundings};

/// The side of the pictures that are taken, in texels.
pub(crate) const FACE_SIDE: u32 = 256;

/// The sides of the tiles of surroundings.
pub(crate) const SIDES: TileSides = TileSides { mirror: 256, fine: 128, medium: 64, coarse: 32 };

/// A region is larger by so much of its smallest extent.
const SLACK_SHARE: f32 = 0.01;

/// A region fades over so much of its smaller extents where it fades at once.
const FADE_MIN_SHARE: f32 = 1e-3;

/// As `Surroundings` of `environment.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SurroundingsUniform {
    /// The middle of the box of those that have it; one divided by how many metres it fades over.
    pub center: Vec4,
    /// Half its extent; what the light of its tiles is multiplied by.
    pub half_m: Vec4,
    /// Where it is seen from; 1 if it has walls.
    pub place: Vec4,
    /// The middle of its walls.
    pub walls_center: Vec4,
    /// Half their extent.
    pub walls_half_m: Vec4,
    /// The corner of its tiles in texels.
    pub corner: Vec4,
}

/// Half the extent of a box in which something fades in, and one divided by how many metres it fades over: walls that lie on
/// its faces are in it.
pub(crate) fn fading_box(region: &Region, fade_m: f32) -> (Vec3, f32) {
    let half_m = region.half_m.max(Vec3::splat(1e-6)) + SLACK_SHARE * region.half_m.min_element().max(1e-6);
    let least_m = FADE_MIN_SHARE * half_m.min_element();
    (half_m, if fade_m > least_m { fade_m } else { least_m }.recip())
}

impl SurroundingsUniform {
    /// Of surroundings whose tiles lie at a corner, and whose light is multiplied by `scale`.
    pub fn new(of: &Surroundings, [x, y]: [u32; 2], scale: f32) -> Self {
        let Region { center_world, .. } = of.region;
        let (half_m, per_fade_m) = fading_box(&of.region, of.fade_m);
        let walls = of.walls.unwrap_or(of.region);
        let has_walls = if of.walls.is_some() { 1.0 } else { 0.0 };
        Self {
            center: center_world.extend(per_fade_m),
            half_m: half_m.extend(scale),
            place: of.position_world.extend(has_walls),
            walls_center: walls.center_world.extend(0.0),
            walls_half_m: walls.half_m.max(Vec3::splat(1e-6)).extend(0.0),
            corner: Vec4::new(x as f32, y as f32, 0.0, 0.0),
        }
    }
}

/// Whether all numbers of surroundings are some.
pub(crate) fn is_sound(of: &Surroundings) -> bool {
    let is_box = |region: &Region| {
        let largest = region.center_world.abs().max(region.half_m).max_element();
        region.center_world.is_finite() && region.half_m.min_element() > 0.0 && largest < 1e9
    };
    of.position_world.is_finite()
        && of.position_world.abs().max_element() < 1e9
        && is_box(&of.region)
        && of.walls.as_ref().is_none_or(is_box)
}

/// The surroundings of a scene that are drawn.
pub(crate) fn known_surroundings(scene: &Scene) -> impl Iterator<Item = &Surroundings> + Clone {
    scene.surroundings.iter().take(SURROUNDINGS_MAX).filter(|of| is_sound(of))
}

/// Where the tiles of surroundings, those of the environment and the texels of probes lie in one texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Atlas {
    /// Width and height.
    pub size: (u32, u32),
    /// The corner of the first, and how far each is to the right of the one before.
    first: [u32; 2],
    /// The corner of the texels of probes.
    pub probes: [u32; 2],
}

/// The size of two rectangles, the second to the right of the first or below it, whichever is smaller, and the corner of the
/// second.
fn joined((width, height): (u32, u32), (w, h): (u32, u32), limit: u32) -> Option<((u32, u32), [u32; 2])> {
    let beside = ((width + w, height.max(h)), [width, 0]);
    let below = ((width.max(w), height + h), [0, height]);
    let fits = |((width, height), _): &((u32, u32), [u32; 2])| *width <= limit && *height <= limit;
    let texels = |((width, height), _): &((u32, u32), [u32; 2])| u64::from(*width) * u64::from(*height);
    [beside, below].into_iter().filter(fits).min_by_key(texels)
}

impl Atlas {
    /// For so many, beside tiles of the environment of a size, and for texels of probes; none where a texture may not be so
    /// large.
    pub fn new(count: usize, environment: (u32, u32), probes: (u32, u32), limit: u32) -> Option<Self> {
        let (own_width, own_height) = texture_size(SIDES);
        let own = (own_width * count as u32, if count > 0 { own_height } else { 0 });
        let (size, first) = joined(environment, own, limit)?;
        let (size, probes) = joined(size, probes, limit)?;
        Some(Self { size, first, probes })
    }

    /// The corner of one.
    pub fn corner(&self, index: usize) -> [u32; 2] {
        let [x, y] = self.first;
        [x + texture_size(SIDES).0 * index as u32, y]
    }

    /// The tile of a level of one.
    pub fn tile(&self, index: usize, level: u32) -> Tile {
        let tile = Tile::of_level(level, SIDES);
        let [x, y] = self.corner(index);
        Tile { corner: [tile.corner[0] + x, tile.corner[1] + y], ..tile }
    }
}

/// The camera of a face of a cube map around a place, whose axes are those that cube maps have: it sees the world mirrored.
pub(crate) fn face_camera([right, down, forward]: [Vec3; 3], position_world: Vec3) -> Mat4 {
    Mat4::from_cols(right.extend(0.0), (-down).extend(0.0), (-forward).extend(0.0), position_world.extend(1.0))
}

/// As many uniforms as shaders have room for.
pub(crate) type SurroundingsUniforms = [SurroundingsUniform; SURROUNDINGS_MAX];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "forward",
            "Surroundings",
            SurroundingsUniform,
            [center, half_m, place, walls_center, walls_half_m, corner]
        );
    }

    #[test]
    fn tiles_lie_beside_those_of_the_environment_or_below() {
        let own = texture_size(SIDES);
        let beside = Atlas::new(2, (1000, 700), (0, 0), 2048).unwrap();
        assert_eq!((beside.size, beside.corner(1)), ((1000 + 2 * own.0, own.1), [1000 + own.0, 0]));
        let below = Atlas::new(4, (1500, 900), (0, 0), 2048).unwrap();
        assert_eq!((below.size, below.corner(0)), ((1500.max(4 * own.0), 900 + own.1), [0, 900]));
        assert_eq!(Atlas::new(4, (2048, 1500), (0, 0), 2048), None);
        let tile = beside.tile(1, 3);
        assert_eq!(tile.corner[0], Tile::of_level(3, SIDES).corner[0] + beside.corner(1)[0]);
        let of_probes = Atlas::new(0, (0, 0), (640, 704), 2048).unwrap();
        assert_eq!((of_probes.size, of_probes.probes), ((640, 704), [0, 0]));
        let of_both = Atlas::new(0, (1000, 700), (640, 704), 2048).unwrap();
        assert_eq!((of_both.size, of_both.probes), ((1640, 704), [1000, 0]));
        assert_eq!(Atlas::new(0, (2048, 1500), (640, 704), 2048), None);
    }
}
