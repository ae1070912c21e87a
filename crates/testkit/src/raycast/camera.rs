//! Cameras.

use glam::{DMat4, DQuat, DVec2, DVec3, Mat4};
use manypass_scene::{Projection, Scene};

/// How the camera maps space to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// A pinhole with this vertical field of view in radians.
    Perspective {
        /// Radians from the lower to the upper edge.
        fov_y_rad: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// The full height of the picture in metres.
        height_m: f64,
    },
}

impl From<Projection> for Lens {
    fn from(projection: Projection) -> Self {
        match projection {
            Projection::Perspective { fov_y_rad, .. } => Self::Perspective { fov_y_rad: fov_y_rad.into() },
            Projection::Orthographic { height_m, .. } => Self::Orthographic { height_m: height_m.into() },
        }
    }
}

/// A camera that looks along −Z of `world_from_view`, +Y up. It has no near and no far plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The place in world space.
    pub position_world: DVec3,
    /// The rotation.
    pub world_from_view: DQuat,
    /// The projection.
    pub lens: Lens,
}

impl Camera {
    /// The camera at a place that neither shears nor scales.
    pub fn new(world_from_view: Mat4, projection: Projection) -> Self {
        let (_, rotation, translation) = as_f64(&world_from_view).to_scale_rotation_translation();
        Self { position_world: translation, world_from_view: rotation.normalize(), lens: projection.into() }
    }

    /// The camera of the first node that has one, as of the last [`Scene::update_transforms`].
    pub fn of_scene(scene: &Scene) -> Option<Self> {
        let with_camera = |id| {
            let node = scene.node(id);
            Some(Self::new(node.world_from_object, scene.cameras.get(node.camera?)?.projection))
        };
        scene.visible_nodes().into_iter().find_map(with_camera)
    }

    /// The origin and the unit direction of the ray through `position_ndc` (x right, y up, −1 to 1).
    pub fn ray(&self, position_ndc: DVec2, aspect: f64) -> (DVec3, DVec3) {
        match self.lens {
            Lens::Perspective { fov_y_rad } => {
                let tan = (0.5 * fov_y_rad).tan();
                let direction_view = DVec3::new(position_ndc.x * tan * aspect, position_ndc.y * tan, -1.0);
                (self.position_world, (self.world_from_view * direction_view).normalize())
            }
            Lens::Orthographic { height_m } => {
                let offset_view = DVec3::new(position_ndc.x * aspect, position_ndc.y, 0.0) * (0.5 * height_m);
                (self.position_world + self.world_from_view * offset_view, self.world_from_view * DVec3::NEG_Z)
            }
        }
    }
}

/// The same matrix in twice the precision.
pub(super) fn as_f64(matrix: &Mat4) -> DMat4 {
    DMat4::from_cols_array(&matrix.to_cols_array().map(f64::from))
}
