//! Manypass: a deferred, multi-pass renderer. The same frame natively, headless without a GPU, and in the browser on
//! WebGPU and WebGL 2.
//!
//! [`Renderer`] draws a [`scene::Scene`] as a [`FrameRequest`] says. The frame itself is one page, `frame.rs`.
//!
//! ```
//! use manypass::{FrameRequest, Gpu, Renderer, scene};
//!
//! let scene = scene::demo::hall();
//! let mut renderer = Renderer::new(Gpu::headless(None)?)?;
//! renderer.load(&scene)?;
//! renderer.render(&scene, &FrameRequest::of_scene(&scene, 64, 36))?;
//! let rgba8 = renderer.read_display()?;
//! assert_eq!(rgba8.len(), 64 * 36 * 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The frame can be extended with an [`Effect`], most easily one WGSL file ([`WgslEffect`]), and drawn to a texture of
//! the caller's on the caller's own device ([`Gpu::from_device`], [`Renderer::render_to`]). The folder `examples` shows
//! both.

pub mod aov;
mod camera_settings;
mod capture_settings;
pub mod colour;
pub mod constants;
mod decals;
mod diagnostic;
mod draws;
pub mod effect;
pub mod environment;
pub mod exposure;
mod fisheye;
mod fog;
mod frame;
mod gbuffer;
pub mod gpu;
mod ground;
mod lens;
mod levels;
mod lights;
mod mirror_picture;
mod occlusion;
mod octahedral;
mod outline;
mod overlay;
mod pass_info;
mod passes;
mod pose;
mod probes;
mod quality;
mod record;
mod relief_settings;
mod render_settings;
mod renderer;
mod request;
mod resolution;
mod resources;
mod screen_space;
mod setting;
pub mod settings;
pub mod shader;
mod shading_settings;
mod shadows;
mod simulation;
#[cfg(doctest)]
mod snippets;
mod stage;
mod surroundings;
mod tone_curve;
mod transparency;
mod user_shader;
mod view;
mod waves;

pub use aov::{Aov, AovInfo, AovPixels, PngEncoding};
pub use camera_settings::{Fisheye, FisheyeFrame};
pub use diagnostic::Diagnostic;
pub use effect::{Effect, EffectFile, EffectStage, WgslEffect};
pub use environment::{Background, Environment, EnvironmentRadiance};
pub use exposure::{Adaptation, Exposure, ExposureError, Metering, MeteringPattern};
pub use fisheye::{FisheyeInfo, FisheyeView};
pub use fog::FogMode;
pub use gbuffer::Gbuffer;
pub use gpu::{AdapterSummary, Gpu, GpuError};
pub use ground::Ground;
pub use lens::shutter_position;
pub use levels::LevelCount;
pub use lights::LightCulling;
pub use manypass_graph as graph;
pub use manypass_graph::Plan;
pub use manypass_scene as scene;
pub use manypass_scene::Cache;
pub use overlay::OverlayError;
pub use passes::debug::DebugView;
pub use passes::occlusion::OcclusionMethod;
pub use passes::present::Target;
pub use passes::resolve::PixelSamples;
pub use passes::tone_map::Tonemap;
pub use passes::upscale::UpscaleMethod;
pub use pose::Pose;
pub use quality::{Quality, QualityBudget};
pub use record::{DrawSelection, LegendEntry, PreparedView, Recorder, Texels};
pub use render_settings::Path;
#[cfg(target_arch = "wasm32")]
pub use renderer::Pipelines;
pub use renderer::{RenderedView, Renderer};
pub use request::{Averaging, FrameRequest, FrameStats, PairCounts, PassPicture, RenderError};
pub use resolution::Resolution;
pub use resources::estimate::upload_bytes;
pub use resources::layers::{ShadedIn, layer_names};
pub use settings::{SettingInfo, SettingValue, Settings, SettingsError, SettingsFile, Switch};
pub use shading_settings::ReflectanceModel;
pub use shadows::ShadowFilter;
pub use simulation::{STEPS_MAX as SIMULATION_STEPS_MAX, SimulationFile, SimulationProgress, SimulationReport};
pub use stage::stage_schema;
pub use transparency::{Masks, TransparencyMode};
pub use view::View;
