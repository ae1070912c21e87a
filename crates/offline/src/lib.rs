//! Stills and sequences as a library: accumulates samples, reads pictures back and encodes them.
//!
//! Every encoder gives bytes; [`atomic`] is the only module that touches the file system, so that nothing half-written
//! stays behind.

pub mod atomic;
pub mod encode;
pub mod exr_file;
pub mod memory;
pub mod sheet;
pub mod still;

pub use encode::{EncodeError, Format};
pub use still::{AovLayer, Picture, Samples, render_still};
