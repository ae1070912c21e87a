//! Shaders: composed when the crate is built (`compose`), bound by the names that they declare (`program`).

pub mod compose;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]
pub(crate) mod layout;
pub(crate) mod locate;
pub mod program;

pub use program::{Program, ProgramError, Shaders};
