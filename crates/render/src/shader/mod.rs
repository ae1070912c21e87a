//! Shaders: composed when the crate is built (`compose`), bound by the names that they declare (`program`,
//! `reflection`), and made once (`cache`), on threads (`pipeline`). `dump` writes their texts.

pub mod cache;
pub mod compose;
pub(crate) mod dump;
pub(crate) mod frame_group;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]
pub(crate) mod layout;
pub(crate) mod locate;
pub(crate) mod pipeline;
pub mod program;
pub(crate) mod reflection;
#[cfg(all(feature = "reload", debug_assertions, not(target_arch = "wasm32")))]
mod reload;
#[cfg(not(target_arch = "wasm32"))]
mod specialise;

pub use cache::Shaders;
pub use pipeline::Pipeline;
pub use program::{Program, ProgramError};
