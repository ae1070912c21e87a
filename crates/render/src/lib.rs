//! Manypass draws a scene in many passes: a deferred frame with thousands of clustered lights, shadow maps, ambient
//! occlusion, reflections, glass, AOVs and effects of your own. The same frame is drawn natively, headless without a GPU
//! (software Vulkan), and in the browser on WebGPU and WebGL 2.
//!
//! ![A hall at night with 1,184 lights and a polished floor][hall]
//!
//! [hall]: https://raw.githubusercontent.com/manypass/manypass/main/docs/hall.png
//!
//! # A picture
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
//! # A window
//!
//! With [winit](https://docs.rs/winit); any library will do whose windows wgpu can draw to. wgpu and glam are exported
//! from here, so that versions fit.
//!
//! ```no_run
//! use manypass::{FrameRequest, Gpu, Renderer, Target, scene, wgpu};
//! use std::sync::Arc;
//! use winit::{application::ApplicationHandler, event::WindowEvent, event_loop::ActiveEventLoop, window};
//!
//! struct App(scene::Scene, Option<(Arc<window::Window>, wgpu::Surface<'static>, Renderer)>);
//!
//! impl ApplicationHandler for App {
//!     fn resumed(&mut self, events: &ActiveEventLoop) {
//!         let window = Arc::new(events.create_window(Default::default()).expect("a window"));
//!         let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
//!         let surface = instance.create_surface(window.clone()).expect("a surface");
//!         let (gpu, config) = Gpu::for_surface(&instance, &surface, window.inner_size().into()).expect("a device");
//!         surface.configure(&gpu.device, &config);
//!         self.1 = Some((window, surface, Renderer::new(gpu).expect("a renderer")));
//!     }
//!     fn window_event(&mut self, events: &ActiveEventLoop, _: window::WindowId, event: WindowEvent) {
//!         let Self(scene, Some((window, surface, renderer))) = self else { return };
//!         if event == WindowEvent::CloseRequested { return events.exit() }
//!         if event != WindowEvent::RedrawRequested { return }
//!         if let wgpu::CurrentSurfaceTexture::Success(output) = surface.get_current_texture() {
//!             let target = Target::whole(&output.texture);
//!             let request = FrameRequest::of_scene(scene, target.width, target.height);
//!             renderer.render_to(scene, &request, &target).expect("a frame");
//!             renderer.gpu().queue.present(output);
//!         }
//!         window.request_redraw();
//!     }
//! }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut app = App(scene::demo::hall(), None);
//! winit::event_loop::EventLoop::new()?.run_app(&mut app)?;
//! # Ok(()) }
//! ```
//!
//! The example `window` beside it orbits, zooms, resizes and moves 1,000 lights.
//!
//! # What to look at next
//!
//! | you want to | look at |
//! |---|---|
//! | read a file, or build a scene in code and edit it | [`scene`], [`scene::Scene`], [`scene::load_path`], example `scene_in_code` |
//! | say what a frame is to show: size, camera, samples | [`FrameRequest`], [`View`] |
//! | change shadows, occlusion, tone curve, any value | [`Settings`], and [`Quality`] for tiers |
//! | have the exposure metered | [`Renderer::expose`], [`Exposure`] |
//! | average samples for a still | [`FrameRequest::sample_count`], example `still` |
//! | read pixels, radiance, or depth, normals and ids | [`Renderer::read_display`], [`Renderer::read_radiance`], [`Renderer::read_aov`], [`Aov`] |
//! | draw into a texture of yours, on your device | [`Gpu::from_device`], [`Renderer::render_to`], [`Target`], example `embed` |
//! | draw several cameras at once | [`Renderer::render_views`], [`Renderer::rendered`] |
//! | add an effect in one WGSL file | [`WgslEffect`], example `own_pass` |
//! | add passes in Rust, with pipelines of your own | [`Effect`], [`Recorder`], [`graph`], example `rust_pass` |
//! | write another frame with the frame graph alone | [`graph`], example `textbook_layouts` |
//! | see what a frame draws, writes and costs | [`Renderer::plan`], [`Renderer::stats`], [`FrameStats`] |
//! | know why a frame failed | [`RenderError`] |
//!
//! Examples are in `crates/render/examples`; `cargo run --release -p manypass --example NAME` draws one. The pages of the
//! [documentation](https://github.com/manypass/manypass/blob/main/docs/README.md) have each subject; `docs/library.md` is
//! the one on this crate.

#![warn(unnameable_types)]

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
mod environment_tiles;
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

pub use aov::{Aov, AovInfo, AovPixels, PassPicture, PngEncoding};
pub use camera_settings::{Fisheye, FisheyeFrame};
pub use diagnostic::Diagnostic;
pub use effect::{Effect, EffectFile, EffectStage, WgslEffect};
pub use environment::{Background, Environment, EnvironmentRadiance};
pub use exposure::{Adaptation, Exposure, ExposureError, Metering, MeteringPattern};
pub use fisheye::{FisheyeInfo, FisheyeView};
pub use fog::FogMode;
pub use gbuffer::Gbuffer;
pub use glam;
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
pub use record::{
    DecalUse, DrawSelection, Frame, Fullscreen, LegendEntry, PicturePart, PreparedView, Recorder, SurfacePass, Texels,
};
pub use render_settings::Path;
#[cfg(target_arch = "wasm32")]
pub use renderer::Pipelines;
pub use renderer::{RenderedView, Renderer};
pub use request::{Averaging, FrameRequest, FrameStats, PairCounts, RenderError};
pub use resolution::Resolution;
pub use resources::estimate::upload_bytes;
pub use resources::layers::{ShadedIn, layer_names};
pub use settings::{SettingInfo, SettingValue, Settings, SettingsError, SettingsFile, Switch};
pub use shading_settings::ReflectanceModel;
pub use shadows::ShadowFilter;
pub use simulation::{STEPS_MAX as SIMULATION_STEPS_MAX, SimulationFile, SimulationProgress, SimulationReport};
pub use stage::stage_schema;
pub use transparency::{Masks, TransparencyMode};
pub use view::{DepthRange, View, ViewUniform};
pub use wgpu;
