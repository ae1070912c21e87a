//! Shaders: composed when the crate is built (`compose`), bound by the names that they declare (`program`).

pub mod compose;
pub(crate) mod locate;
pub mod program;

pub use program::{Program, ProgramError, Shaders};
