//! What the map of the plane is drawn from.

use crate::draws::{Tile, WorldDraws};
use crate::resources::Instance;
use crate::shadows::{ShadowCasters, TileProjection, looking_along};
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use manypass_graph::TextureDesc;
use manypass_scene::Aabb;

/// The least and the most texels along the sides of the map.
const SIDE_TEXELS: [u32; 2] = [256, 2048];

/// At most so many pixels of the longer side of a picture come to a texel of the map, up to the largest map.
const PIXELS_OF_TEXEL: u32 = 5;

/// Texels along the sides of the map for a picture whose longer side has so many pixels.
pub(crate) fn side_texels(longest_px: u32) -> u32 {
    let [least, most] = SIDE_TEXELS;
    longest_px.div_ceil(PIXELS_OF_TEXEL).clamp(least, most).next_power_of_two()
}

/// The width of the band along the map's edge in which light comes back, as a share of its half.
pub(super) const EDGE_BAND: f32 = 0.15;

/// A light that is parallel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ParallelLight {
    /// Towards it, of length 1.
    pub direction: Vec3,
    /// The tangent of half the angle that it takes in the sky.
    pub half_angle_tan: f32,
    pub casts_shadows: bool,
}

impl ParallelLight {
    /// Whether it stands above the plane.
    pub fn reaches(&self) -> bool {
        self.casts_shadows && self.direction.y > 1e-3
    }
}

/// A plane, and the part of it that the scene takes light from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GroundMap {
    /// The height of the plane.
    pub height_m: f32,
    /// How far above it the scene reaches.
    pub top_m: f32,
    /// X and z of its middle, and half its width and depth.
    pub center: Vec2,
    pub half_m: Vec2,
    /// Half the diagonal of the scene's bounds.
    pub radius_m: f32,
    pub light: Option<ParallelLight>,
    pub bounds: Aabb,
    /// Texels along the sides of the map.
    pub side_texels: u32,
}

/// The uniform of `ground_map.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct GroundMapUniform {
    /// X and z of the map's middle, half its width and depth.
    place: Vec4,
    /// The height of the plane, how far above it the scene reaches, the heights below which what hangs over it counts
    /// as so high: for what touches it, and for what stands on it.
    heights: Vec4,
    /// The rows of the tile along the light.
    light_x: Vec4,
    light_y: Vec4,
    light_z: Vec4,
    /// Of the light the tangent of half its angle; metres of half the side of its tile, and of its depth; 1 if it casts
    /// shadows.
    light: Vec4,
    /// The first two rows of the tile from below.
    below_x: Vec4,
    below_y: Vec4,
    /// One divided by the texels along the sides of the map; the width of the band along its edge in which light comes
    /// back, as a share of its half; zero.
    texels: Vec4,
}

impl GroundMap {
    /// The texture of the map: the share of the parallel light, and of light from everywhere, that reaches the plane.
    pub fn texture(&self) -> TextureDesc {
        TextureDesc::new_2d(self.side_texels, self.side_texels, wgpu::TextureFormat::Rg16Float)
    }

    /// The side of a tile of [`Self::depths`] in texels.
    fn tile_side(&self) -> u32 {
        2 * self.side_texels
    }

    /// The texture of two depth maps side by side: seen along the light, and from below.
    pub fn depths(&self) -> TextureDesc {
        let side = self.tile_side();
        TextureDesc::new_2d(2 * side, side, wgpu::TextureFormat::Depth32Float)
    }

    /// How the light sees the scene, if there is one that casts shadows, and how the scene is seen from below.
    fn projections(&self) -> [TileProjection; 2] {
        let parallel = |direction: Vec3, [nearest, farthest]: [f32; 2], half_m: f32| {
            let rotation = looking_along(direction);
            let center = rotation.inverse() * self.bounds.center();
            let depth = [center.z + nearest, center.z + farthest];
            TileProjection::parallel(rotation, center.truncate(), half_m, depth, self.tile_side())
        };
        let radius_m = 1.001 * self.radius_m;
        let along = self.light.filter(ParallelLight::reaches).map_or(Vec3::NEG_Y, |light| -light.direction);
        let light = parallel(along, [radius_m, -radius_m], radius_m);
        let extent = self.bounds.max - self.bounds.min;
        let middle_m = self.bounds.center().y - self.height_m;
        // Depth is 1 on the plane and 0 at the top.
        let below = parallel(Vec3::Y, [middle_m, middle_m - self.top_m], 0.505 * extent.x.max(extent.z).max(1e-6));
        // What reaches below the plane touches it.
        [light, below].map(|projection| TileProjection { is_of_ground: true, ..projection })
    }

    /// What its shader takes.
    pub fn uniform(&self) -> GroundMapUniform {
        let [light, below] = self.projections();
        let extent_m = (self.bounds.max - self.bounds.min).max_element();
        let touching_m = 0.02 * extent_m;
        let half_side = |row: Vec4| row.truncate().length_recip();
        let half_angle_tan = self.light.map_or(0.0, |light| light.half_angle_tan);
        let casts = self.light.is_some_and(|light| light.reaches());
        GroundMapUniform {
            place: Vec4::new(self.center.x, self.center.y, self.half_m.x, self.half_m.y),
            heights: Vec4::new(self.height_m, self.top_m, touching_m, (0.5 * self.top_m).max(touching_m)),
            light_x: light.rows[0],
            light_y: light.rows[1],
            light_z: light.rows[2],
            light: Vec4::new(
                half_angle_tan,
                half_side(light.rows[0]),
                half_side(light.rows[2]),
                f32::from(u8::from(casts)),
            ),
            below_x: below.rows[0],
            below_y: below.rows[1],
            texels: Vec4::new(1.0 / self.side_texels as f32, EDGE_BAND, 0.0, 0.0),
        }
    }

    /// The tiles of [`GROUND_DEPTHS`], whose instances are appended, and a number that they share with all that are
    /// alike.
    pub fn tiles(&self, world: &WorldDraws, version: u64, instances: &mut Vec<Instance>) -> (Vec<Tile>, u64) {
        let casting = ShadowCasters::new(world, version);
        let mut signature = 0u64;
        let side = self.tile_side();
        let tiles = self.projections().into_iter().zip([0, side]).map(|(projection, x)| {
            let (draws, of_tile) = casting.tile(&projection, instances);
            signature = signature.rotate_left(7) ^ of_tile;
            Tile { rectangle: [x, 0, side, side], draws }
        });
        (tiles.collect(), signature)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "ground_map",
            "GroundMap",
            GroundMapUniform,
            [place, heights, light_x, light_y, light_z, light, below_x, below_y, texels]
        );
    }

    #[test]
    fn the_map_grows_with_the_picture() {
        let sides = [0, 640, 1280, 1281, 1920, 3840, 7680, 16384, u32::MAX].map(side_texels);
        assert_eq!(sides, [256, 256, 256, 512, 512, 1024, 2048, 2048, 2048]);
        // Up to the largest map a texel is at most so many pixels where the picture shows the ground as a whole.
        let is_fine = |longest_px: u32| longest_px <= PIXELS_OF_TEXEL * side_texels(longest_px);
        assert!((1..=PIXELS_OF_TEXEL * SIDE_TEXELS[1]).step_by(97).all(is_fine));
    }

    #[test]
    fn depth_from_below_is_the_height_above_the_plane() {
        let bounds = Aabb { min: Vec3::new(-1.0, 2.0, -3.0), max: Vec3::new(4.0, 5.0, 1.0) };
        let map = super::super::map_under(&bounds, Some(1.5), None, 256).expect("there is something");
        let [_, below] = map.projections();
        for (height_m, depth) in [(1.5, 1.0), (5.0, 0.0), (3.25, 0.5)] {
            let found = below.rows[2].dot(Vec4::new(0.3, height_m, -0.2, 1.0));
            assert!((found - depth).abs() < 1e-4, "{height_m}: {found}");
        }
    }
}
