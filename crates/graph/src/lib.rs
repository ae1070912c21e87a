//! A frame graph on wgpu: declare the passes of a frame, plan them without a
//! device, then execute the plan.
//!
//! - **Declare.** [`Graph::pass`] opens a pass; its methods say what the pass
//!   reads and writes. Writing consumes a [`Handle`] and returns the next
//!   version, so two writers of one version do not compile. Declaration order is
//!   execution order: a handle exists before anything can read it.
//! - **Plan.** [`Graph::plan`] checks the declarations, drops passes that nothing
//!   needs, derives load and store operations, merges neighbours and shares
//!   textures between lifetimes that do not overlap. The [`Plan`] is plain data.
//! - **Execute.** [`Executor::run`] records the plan into a command encoder, and
//!   [`Executor::end_frame`] ends the frame once that is submitted.
//!
//! Two whole frames are declared in `crates/render/examples/textbook_layouts`.
//!
//! Absent on purpose: compute passes, and anything that knows what a scene is.
//!
//! ```
//! use manypass_graph::{ColorLoad, Graph, Limits, TextureDesc};
//!
//! let mut graph = Graph::new(Limits::WEBGL2);
//! let desc = TextureDesc::new_2d(64, 64, wgpu::TextureFormat::Rgba8Unorm);
//! let scene = graph.texture("scene", desc);
//! let image = graph.texture("image", desc);
//!
//! let mut pass = graph.pass("scene.draw");
//! let scene = pass.color(scene, ColorLoad::Clear(wgpu::Color::BLACK));
//! pass.draw(|_context| { /* set a pipeline and draw */ });
//!
//! let mut pass = graph.pass("image.tonemap");
//! let image = pass.color(image, ColorLoad::Discard);
//! let scene_read = pass.read(&scene);
//! pass.draw(move |context| {
//!     let _view = context.view(scene_read);
//! });
//!
//! graph.export(image);
//! let plan = graph.plan()?;
//! assert_eq!(plan.passes.len(), 2);
//! # Ok::<(), manypass_graph::PlanError>(())
//! ```
//!
//! A version of a texture has one writer:
//!
//! ```compile_fail,E0382
//! # use manypass_graph::{ColorLoad, Graph, Limits, TextureDesc};
//! # let mut graph = Graph::new(Limits::WEBGL2);
//! # let desc = TextureDesc::new_2d(64, 64, wgpu::TextureFormat::Rgba8Unorm);
//! let image = graph.texture("image", desc);
//! let mut pass = graph.pass("first");
//! pass.color(image, ColorLoad::Discard);
//! pass.draw(|_| {});
//! let mut pass = graph.pass("second");
//! pass.color(image, ColorLoad::Keep); // `image` was consumed by `first`.
//! pass.draw(|_| {});
//! ```

mod check;
mod desc;
mod error;
mod execute;
mod graph;
mod plan;
mod pool;
mod print;
mod report;
mod subresource;
mod tap;
#[cfg(test)]
mod tests;
mod times;

pub use desc::{Limits, TextureDesc};
pub use error::PlanError;
pub use execute::{Executor, PassContext, RunOptions, Timing};
pub use graph::{ColorLoad, DepthLoad, Export, Graph, Handle, History, Pass, ReadKey};
pub use plan::{Load, PassWork, Plan, PlanBytes, PlannedAttachment, PlannedPass, PlannedRead, PlannedTexture, Target};
pub use report::{PassTime, Run, RunReport, TapPixels};
pub use subresource::SubresourceRange;
pub use tap::{Tap, TapFailure, Taps};
