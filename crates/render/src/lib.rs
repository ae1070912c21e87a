//! Manypass: a deferred, multi-pass renderer. The same frame natively, headless without a GPU, and in the browser on
//! WebGPU and WebGL 2.
//!
//! [`Renderer`] draws a [`scene::Scene`] as a [`FrameRequest`] says. The frame itself is one function, in [`frame`].

pub mod aov;
pub mod draws;
pub mod environment;
pub mod frame;
pub mod gbuffer;
pub mod gpu;
pub mod passes;
mod pose;
mod renderer;
pub mod resources;
pub mod settings;
pub mod shader;
pub mod surfaces;
pub mod view;

pub use aov::{Aov, AovPixels};
pub use environment::{Background, Environment};
pub use frame::Path;
pub use gpu::{AdapterSummary, Gpu, GpuError};
pub use manypass_graph as graph;
pub use manypass_graph::Plan;
pub use manypass_scene as scene;
pub use passes::lights::LightCulling;
pub use passes::tone_map::Tonemap;
pub use pose::Pose;
pub use renderer::{FrameRequest, FrameStats, PairCounts, PassPicture, RenderError, Renderer};
pub use settings::{Settings, SettingsError};
pub use view::View;
