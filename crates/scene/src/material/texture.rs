//! How materials use textures.

use glam::{Mat3, Vec2, Vec3};

/// The placement of a texture on its UV set (`KHR_texture_transform`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureTransform {
    /// Added after rotation and scale, in UV units.
    pub offset: Vec2,
    /// Counter-clockwise as seen with v pointing down, in radians, about the UV origin.
    pub rotation_rad: f32,
    /// Applied first.
    pub scale: Vec2,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation_rad: 0.0, scale: Vec2::ONE }
    }
}

impl TextureTransform {
    /// The matrix of the extension's specification: translation · rotation · scale.
    pub fn matrix(&self) -> Mat3 {
        let (sin, cos) = self.rotation_rad.sin_cos();
        Mat3::from_cols(
            Vec3::new(self.scale.x * cos, -self.scale.x * sin, 0.0),
            Vec3::new(self.scale.y * sin, self.scale.y * cos, 0.0),
            Vec3::new(self.offset.x, self.offset.y, 1.0),
        )
    }
}

/// A material's use of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TextureRef {
    /// Index into [`crate::Scene::textures`].
    pub texture: usize,
    /// Which UV set: 0 or 1.
    pub uv_set: u32,
    /// The placement on that set.
    pub transform: TextureTransform,
}
