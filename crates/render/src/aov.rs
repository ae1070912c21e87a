//! Arbitrary output variables (AOVs): values of every pixel besides its colour. They show opaque and masked surfaces.
//! Blended ones are only in `radiance`, unless `aov.first_surface` asks for them.

mod exports;
mod info;
mod pass_picture;
mod pixels;
mod settings;
#[cfg(not(target_arch = "wasm32"))]
mod tap;

pub(crate) use exports::{AovExports, AovTextures, MissingExport};
pub use info::{AovInfo, PngEncoding};
pub use pass_picture::PassPicture;
use pixels::GbufferPixels;
pub(crate) use pixels::f32_from_half;
pub use settings::AovSettings;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use tap::tap_picture;

/// An arbitrary output variable (AOV): depth, normal, motion, an id or another value of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Aov {
    /// Base colour, linear.
    BaseColor,
    /// Occlusion of the material.
    Occlusion,
    /// Screen-space ambient occlusion: the share of the environment's light that is left, even if the picture does not
    /// use it; 1 where there is no surface.
    OcclusionScreen,
    /// Unit normal in world space.
    Normal,
    /// Unit normal in view space.
    NormalView,
    /// Position in world space, metres.
    Position,
    /// Distance along the view axis, metres; +∞ where there is no surface.
    Depth,
    /// Metallic.
    Metallic,
    /// Perceptual roughness.
    Roughness,
    /// Emitted radiance, linear, exposure divided out. Unlit surfaces emit their base colour.
    Emission,
    /// Motion vector since the previous frame in pixels, +x right, +y down; 0 without a previous frame.
    Motion,
    /// The index of the node plus 1; 0 where there is no surface.
    ObjectId,
    /// The index of the material plus 1, the default material coming after all others; 0 where there is no surface.
    MaterialId,
    /// The accumulated radiance of all samples, linear, associated alpha, exposure divided out.
    Radiance,
}

impl Aov {
    /// All AOVs.
    pub const ALL: &[Self] = &[
        Self::BaseColor,
        Self::Occlusion,
        Self::OcclusionScreen,
        Self::Normal,
        Self::NormalView,
        Self::Position,
        Self::Depth,
        Self::Metallic,
        Self::Roughness,
        Self::Emission,
        Self::Motion,
        Self::ObjectId,
        Self::MaterialId,
        Self::Radiance,
    ];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        self.info().name
    }
}

/// The passes that a frame needs only for its AOVs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AovPasses {
    /// The copy of the emission.
    pub emission: bool,
    /// The ids of nodes and materials.
    pub ids: bool,
    /// The motion since the previous frame.
    pub motion: bool,
    /// Screen-space occlusion.
    pub occlusion_screen: bool,
}

impl AovPasses {
    /// The passes that `aovs` need.
    pub fn of(aovs: &[Aov]) -> Self {
        Self {
            emission: aovs.contains(&Aov::Emission),
            ids: aovs.contains(&Aov::ObjectId) || aovs.contains(&Aov::MaterialId),
            motion: aovs.contains(&Aov::Motion),
            occlusion_screen: aovs.contains(&Aov::OcclusionScreen),
        }
    }
}

/// The values of an AOV, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum AovPixels {
    /// Floats, `components` a pixel.
    Float {
        /// Values a pixel.
        components: u32,
        /// All values.
        data: Vec<f32>,
    },
    /// One integer a pixel; 0 where there is no surface.
    Id(Vec<u32>),
}
