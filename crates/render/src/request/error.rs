//! Why there is no frame, or why it cannot be read.

use crate::aov::Aov;
use crate::gpu::GpuError;
use crate::overlay::OverlayError;
use crate::quality::Quality;
use crate::settings::SettingsError;
use crate::shader::program::ProgramError;
use manypass_graph::PlanError;

/// The error of a frame that was not drawn, or cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A shader failed.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// The frame graph is contradictory.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The settings do not go together.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The picture does not fit the adapter.
    #[error("a picture of {width} × {height} pixels is not possible: each side must be 1 to {limit} on this adapter")]
    Size {
        /// The width that was asked for.
        width: u32,
        /// The height that was asked for.
        height: u32,
        /// The largest side.
        limit: u32,
    },
    /// The picture fits the adapter, but not at the size at which it is shaded.
    #[error(
        "a picture of {width} × {height} pixels is shaded at {} × {} by `render.scale`, and each side must be 1 to {limit} on \
         this adapter",
        shaded.0, shaded.1
    )]
    ShadedSize {
        /// The width that was asked for.
        width: u32,
        /// The height that was asked for.
        height: u32,
        /// The width and height at which it would be shaded.
        shaded: (u32, u32),
        /// The largest side.
        limit: u32,
    },
    /// The textures of the frame would take more memory than [`crate::Renderer::set_memory_budget`] allows.
    #[error("the textures of the frame take {needed_bytes} bytes more, but {budget_bytes} are allowed")]
    Memory {
        /// What they take beyond what the renderer holds already.
        needed_bytes: u64,
        /// What is allowed.
        budget_bytes: u64,
    },
    /// The caller's target cannot be drawn to.
    #[error("the target cannot be drawn to: {0}")]
    Target(String),
    /// A camera with parallel rays has no focal length, and so no lens.
    #[error("the camera has parallel rays, and depth of field (`camera.f_stop`) needs a perspective one")]
    ParallelLens,
    /// What is to be drawn over the picture cannot be.
    #[error(transparent)]
    Overlay(#[from] OverlayError),
    /// A fisheye picture cannot be what it is asked to be.
    #[error("a fisheye picture (`camera.fisheye`) {0}")]
    Fisheye(&'static str),
    /// A picture within the picture asks for a tier of quality that there is not.
    #[error("a capture asks for the quality `{quality}`; there are {known}", known = Quality::NAMES.join(", "))]
    CaptureQuality {
        /// What it asks for.
        quality: String,
    },
    /// Two views of a frame have one name.
    #[error("two views of the frame are called `{0}`")]
    ViewTwice(String),
    /// The caller's progress function asked to stop.
    #[error("stopped")]
    Stopped,
    /// A view is read that no frame has drawn yet.
    #[error(
        "{} was not rendered yet; draw a frame first, with `Renderer::render` or `Renderer::render_views`",
        if view.is_empty() { "the picture".to_owned() } else { format!("the view `{view}`") }
    )]
    NotRendered {
        /// The view's name; empty for the only view of a frame.
        view: String,
    },
    /// Radiance is read of a picture whose display colours alone were averaged.
    #[error(
        "the picture has no radiance to read: set `FrameRequest::averaging` to `Averaging::Radiance` or `Both`, or add \
         `Aov::Radiance` to `FrameRequest::want_aovs`"
    )]
    RadianceNotKept,
    /// An AOV is read that the frame did not keep.
    #[error(
        "the frame has no AOV `{}`: add it to `FrameRequest::want_aovs`, and draw on the path `deferred`", aov.name()
    )]
    AovNotKept {
        /// The AOV that is read.
        aov: Aov,
    },
    /// A later sample has no samples before it that it could be averaged with.
    #[error(
        "a sample does not follow one of the same picture: draw the samples from `sample_index` 0 on, with one size, one \
         `sample_count` and one `averaging`"
    )]
    SampleWithoutFirst,
    /// The renderer contradicts itself; no request should lead here.
    #[error("{0}; this is a fault of the renderer, please report it")]
    Internal(&'static str),
}

impl RenderError {
    /// Whether the device went away, so that nothing more can be rendered with it.
    pub fn is_device_lost(&self) -> bool {
        matches!(self, Self::Gpu(GpuError::Lost(_)))
    }
}
