//! How a tile of the atlas sees the world.
//!
//! The space of a tile: x and y go from −1 to 1 over the tile, after a division by z where rays go through a point; z
//! is the distance from that point in units of the nearest one that is drawn, or for parallel rays the depth itself, 1
//! nearest to the light and 0 farthest away. All of it is affine in world space, so that one matrix of three rows takes
//! an object into a tile.

use glam::{Quat, Vec2, Vec3, Vec4};

/// Texels around what a tile is for that are drawn as well, so that filters find neighbours there.
pub const BORDER_TEXELS: f32 = 3.0;

/// How a tile sees the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileProjection {
    /// Tile from world space: the rows of x, y and z.
    pub rows: [Vec4; 3],
    /// Whether rays go through a point; otherwise they are parallel.
    pub is_perspective: bool,
    /// Whether it is a tile of the ground's map. Corners before the nearest depth are then drawn at that depth, which
    /// bends triangles with corners on both sides of it; and what stops a part of the light is spread evenly over few
    /// texels, since that map is drawn once for all samples.
    pub is_of_ground: bool,
    /// The side of a texel in metres, at a z of 1 if rays go through a point.
    pub texel_m: f32,
}

/// The rotations whose −Z looks through the faces of a cube: +x, −x, +y, −y, +z, −z.
pub fn cube_faces() -> [Quat; 6] {
    [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].map(looking_along)
}

/// A rotation whose −Z is `direction`, of length 1.
pub fn looking_along(direction: Vec3) -> Quat {
    let up = if direction.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
    let back = -direction;
    let right = up.cross(back).normalize_or(Vec3::X);
    Quat::from_mat3(&glam::Mat3::from_cols(right, back.cross(right), back))
}

impl TileProjection {
    /// Of a tile of `side` texels that looks from `position` along −Z of `world_from_light`. Within its border it sees
    /// what lies within `tangent` of its axis, and nothing nearer than `near_m`. Its texels are moved by `shift_texels`,
    /// at most half a texel along an axis, and the border is wider by as much.
    pub fn perspective(
        position: Vec3,
        world_from_light: Quat,
        [tangent, near_m]: [f32; 2],
        shift_texels: Vec2,
        side: u32,
    ) -> Self {
        let border = BORDER_TEXELS + shift_texels.abs().max_element();
        let tangent = tangent / (1.0 - 2.0 * border / side as f32).max(0.25);
        let axis = |axis: Vec3, scale: f32| {
            let axis = world_from_light * axis * scale;
            axis.extend(-axis.dot(position))
        };
        let depth = axis(Vec3::NEG_Z, 1.0 / near_m);
        let shift = shift_texels * 2.0 / side as f32;
        Self {
            rows: [
                axis(Vec3::X, 1.0 / (tangent * near_m)) + depth * shift.x,
                axis(Vec3::Y, 1.0 / (tangent * near_m)) + depth * shift.y,
                depth,
            ],
            is_perspective: true,
            is_of_ground: false,
            texel_m: 2.0 * tangent * near_m / side as f32,
        }
    }

    /// Of a tile of `side` texels for parallel rays along −Z of `world_from_light`: within its border a square of half
    /// the side `half_m` around `center`, a point of light space, from the z `nearest` to the z `farthest` of that
    /// space.
    pub fn parallel(
        world_from_light: Quat,
        center: Vec2,
        half_m: f32,
        [nearest, farthest]: [f32; 2],
        side: u32,
    ) -> Self {
        let half_m = half_m / (1.0 - 2.0 * BORDER_TEXELS / side as f32).max(0.25);
        let axis = |axis: Vec3, scale: f32, offset: f32| (world_from_light * axis * scale).extend(offset);
        let depth = 1.0 / (nearest - farthest).max(1e-6);
        Self {
            rows: [
                axis(Vec3::X, 1.0 / half_m, -center.x / half_m),
                axis(Vec3::Y, 1.0 / half_m, -center.y / half_m),
                axis(Vec3::Z, depth, -farthest * depth),
            ],
            is_perspective: false,
            is_of_ground: false,
            texel_m: 2.0 * half_m / side as f32,
        }
    }

    /// A point of world space in the space of the tile.
    #[cfg(test)]
    pub fn point(&self, world: Vec3) -> Vec3 {
        let [x, y, z] = self.rows.map(|row| row.dot(world.extend(1.0)));
        Vec3::new(x, y, z)
    }

    /// The rows of the matrix that takes an object into the tile.
    pub fn of_object(&self, world_from_object: &[[f32; 4]; 3]) -> [[f32; 4]; 3] {
        let [x, y, z] = world_from_object.map(Vec4::from_array);
        self.rows.map(|row| (x * row.x + y * row.y + z * row.z + Vec4::W * row.w).to_array())
    }

    /// The planes of what the tile may show: inside, all of `plane · (p, 1)` are at least 0. What lies between a light
    /// and what is seen casts a shadow, however near the light it is, so that parallel rays have no nearest distance.
    pub fn planes(&self) -> [Vec4; 5] {
        let [x, y, z] = self.rows;
        if self.is_perspective {
            [z + x, z - x, z + y, z - y, z]
        } else {
            [Vec4::W + x, Vec4::W - x, Vec4::W + y, Vec4::W - y, z]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_a_cube_see_all_directions_with_a_border() {
        let position = Vec3::new(1.0, -2.0, 3.0);
        let tiles = cube_faces().map(|face| TileProjection::perspective(position, face, [1.0, 0.05], Vec2::ZERO, 64));
        for i in 0..2000u16 {
            let angle = f32::from(i) * 2.4;
            let height = 1.0 - f32::from(i) / 1000.0;
            let direction = Vec3::new(
                angle.cos() * (1.0 - height * height).sqrt(),
                height,
                angle.sin() * (1.0 - height * height).sqrt(),
            );
            let axis = direction.abs();
            let greatest = axis.max_element();
            let face = (0..3).find(|at| axis[*at] == greatest).unwrap_or(0) * 2;
            let face = face + usize::from(direction[face / 2] < 0.0);
            let at = tiles[face].point(position + direction * 4.0);
            assert!((at.z - 4.0 * greatest / 0.05).abs() < 1e-2, "{at}");
            let border = 1.0 - 2.0 * BORDER_TEXELS / 64.0;
            assert!(at.x.abs() <= at.z * border * 1.0001 && at.y.abs() <= at.z * border * 1.0001, "{at}");
            assert!(tiles[face].planes().iter().all(|plane| plane.dot((position + direction).extend(1.0)) >= 0.0));
        }
    }
}
