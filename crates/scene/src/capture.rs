//! Pictures that cameras take within a scene: what monitors show.
//!
//! A monitor is an [`Image`] whose texels are what a camera of the scene sees, frame by frame. Whatever samples images
//! may show it: the emission of a screen, a base colour, an item of an overlay.
//!
//! ```
//! # use manypass_scene::capture::{Monitor, MonitorCamera};
//! # use manypass_scene::{Image, Material, Projection, Scene, Texture, TextureRef};
//! # use glam::{Mat4, Vec3};
//! # let mut scene = Scene::default();
//! # scene.materials.push(Material::default());
//! let projection = Projection::Perspective { fov_y_rad: 0.9, near_m: 0.05, far_m: None };
//! let camera = MonitorCamera::Fixed { world_from_view: Mat4::from_translation(Vec3::Y), projection };
//! scene.images.push(Image::of_monitor("entrance", Monitor::new(camera, 512, 288)));
//! scene.textures.push(Texture { image: scene.images.len() - 1, sampler: Default::default() });
//! let texture = scene.textures.len() - 1;
//! let screen = &mut scene.materials[0];
//! screen.emissive_texture = Some(TextureRef { texture, ..TextureRef::default() });
//! screen.emissive_factor = Vec3::splat(250.0); // Its white, in cd/m².
//! ```

use crate::{Image, ImageSource, NodeId, Projection, Scene};
use glam::Mat4;
use std::sync::Arc;

/// The most monitors of a scene that are drawn.
pub const MONITORS_MAX: usize = 64;

/// The largest width and height of a monitor's picture, in texels.
pub const MONITOR_SIDE_MAX: u32 = 4096;

/// The layers that a node is in where nobody says: the first.
pub const LAYERS_DEFAULT: u32 = 1;

/// All layers.
pub const LAYERS_ALL: u32 = u32::MAX;

/// When a picture within the picture is drawn anew, where frames of a live view follow each other. Stills, and every
/// picture of a sequence, depend on nothing before them: there it always is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Update {
    /// In every frame that shows it.
    #[default]
    Always,
    /// In the first frame that shows it, and then in one of so many.
    Every(u32),
    /// In the first frame that shows it.
    Once,
}

/// How a picture within the picture is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct CaptureOptions {
    /// When it is drawn anew.
    pub update: Update,
    /// The layers that it shows ([`crate::Node::layers`]), a bit each.
    pub layers: u32,
    /// The tier of quality whose passes draw it; none for that of the picture that shows it.
    pub quality: Option<String>,
}

impl Default for CaptureOptions {
    fn default() -> Self {
        Self { update: Update::Always, layers: LAYERS_ALL, quality: None }
    }
}

/// From where a monitor's picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MonitorCamera {
    /// From the camera of a node, wherever that is.
    Node(NodeId),
    /// From one place.
    Fixed {
        /// The camera's transform: it looks along its −Z, with its +Y up.
        world_from_view: Mat4,
        /// How space is mapped to the picture.
        projection: Projection,
    },
}

/// What a camera of the scene sees, as the texels of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// From where.
    pub camera: MonitorCamera,
    /// Width of its picture in texels.
    pub width: u32,
    /// Height of its picture in texels.
    pub height: u32,
    /// By how many stops it is exposed more than the picture that shows it.
    pub exposure_stops: f32,
    /// How it is drawn.
    pub options: CaptureOptions,
}

impl Monitor {
    /// As bright as the picture that shows it, drawn as that is, in every frame.
    pub fn new(camera: MonitorCamera, width: u32, height: u32) -> Self {
        Self { camera, width, height, exposure_stops: 0.0, options: CaptureOptions::default() }
    }

    /// `world_from_view` and the projection of its camera, as of the last [`Scene::update_transforms`]; none if the node
    /// has no camera.
    pub fn seen_from(&self, scene: &Scene) -> Option<(Mat4, Projection)> {
        match self.camera {
            MonitorCamera::Fixed { world_from_view, projection } => Some((world_from_view, projection)),
            MonitorCamera::Node(id) => {
                let node = scene.nodes.get(id.0 as usize)?;
                let camera = scene.cameras.get(node.camera?)?;
                let (_, rotation, translation) = node.world_from_object.to_scale_rotation_translation();
                Some((Mat4::from_rotation_translation(rotation, translation), camera.projection))
            }
        }
    }
}

impl Image {
    /// What a camera of the scene sees.
    pub fn of_monitor(name: impl Into<String>, monitor: Monitor) -> Self {
        Self { name: name.into(), source: ImageSource::Monitor(Arc::new(monitor)) }
    }

    /// The monitor whose picture it is, if it is one.
    pub fn monitor(&self) -> Option<&Monitor> {
        if let ImageSource::Monitor(monitor) = &self.source { Some(monitor) } else { None }
    }
}

impl Scene {
    /// The images that are monitors, by their indices.
    pub fn monitors(&self) -> impl Iterator<Item = (usize, &Image, &Monitor)> {
        self.images.iter().enumerate().filter_map(|(index, image)| Some((index, image, image.monitor()?)))
    }
}
