//! Manypass in the browser: `create` binds a canvas, and the `Viewer` it returns loads a glTF file, renders, reads
//! the picture and its variables back and is disposed of. Off the web this crate is empty but for the camera's tests,
//! so that the workspace builds natively.

#[cfg(target_arch = "wasm32")]
mod blit;
#[cfg(any(target_arch = "wasm32", test))]
mod camera;
#[cfg(target_arch = "wasm32")]
mod canvas;
#[cfg(target_arch = "wasm32")]
mod device;
#[cfg(target_arch = "wasm32")]
mod loss;
#[cfg(target_arch = "wasm32")]
mod options;
#[cfg(target_arch = "wasm32")]
mod overlay;
#[cfg(target_arch = "wasm32")]
mod types;
#[cfg(target_arch = "wasm32")]
mod viewer;

#[cfg(target_arch = "wasm32")]
pub use loss::Loss;
#[cfg(target_arch = "wasm32")]
pub use viewer::{ShownTime, Viewer, create, stage_model};
