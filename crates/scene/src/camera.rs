//! Cameras. A camera looks along −Z of its node, with +Y up, as in glTF 2.0.

use glam::Vec2;

/// The projection of a camera: perspective or orthographic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// The vertical field of view in radians.
        fov_y_rad: f32,
        /// The distance of the near plane in metres.
        near_m: f32,
        /// The distance of the far plane in metres; none means infinity.
        far_m: Option<f32>,
    },
    /// Parallel rays.
    Orthographic {
        /// The full height of the picture in metres (twice glTF's `ymag`).
        height_m: f32,
        /// The distance of the near plane in metres.
        near_m: f32,
        /// The distance of the far plane in metres.
        far_m: f32,
    },
}

impl Projection {
    /// Half the extent of a picture whose width is `aspect` times its height, in view space: at a distance of 1 m for a
    /// pinhole, in metres for parallel rays.
    pub fn half_extent(&self, aspect: f32) -> Vec2 {
        let half_height = match self {
            Self::Perspective { fov_y_rad, .. } => (0.5 * fov_y_rad).tan(),
            Self::Orthographic { height_m, .. } => 0.5 * height_m,
        };
        Vec2::new(half_height * aspect, half_height)
    }
}

impl Projection {
    /// Of a picture whose width is `aspect` times its height, with so much more height, where it is narrower than what
    /// a camera of the aspect `least` sees, that all of its width is in the picture.
    pub fn as_wide_as(self, least: Option<f32>, aspect: f32) -> Self {
        let ratio = least.map_or(1.0, |least| least / aspect.max(1e-6)).max(1.0);
        match self {
            // So much that it is left alone where rounding alone makes a difference.
            _ if ratio < 1.0 + 1e-4 || !ratio.is_finite() => self,
            Self::Perspective { fov_y_rad, near_m, far_m } => {
                let fov_y_rad = 2.0 * ((0.5 * fov_y_rad).tan() * ratio).atan();
                Self::Perspective { fov_y_rad, near_m, far_m }
            }
            Self::Orthographic { height_m, near_m, far_m } => {
                Self::Orthographic { height_m: height_m * ratio, near_m, far_m }
            }
        }
    }
}

/// A camera; its place and direction are those of the node that holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The name in the file; empty if it has none.
    pub name: String,
    /// How it maps space to the picture.
    pub projection: Projection,
    /// Width by height of what it sees (glTF's `aspectRatio`, or `xmag` by `ymag`), if it says so: pictures of another
    /// shape crop none of it.
    pub aspect: Option<f32>,
}

impl Camera {
    /// Its projection in a picture whose width is `aspect` times its height: wider pictures see more to the sides, and
    /// narrower ones more above and below.
    pub fn projection_in(&self, aspect: f32) -> Projection {
        self.projection.as_wide_as(self.aspect, aspect)
    }
}
