//! Stills and sequences as a library: accumulates samples, reads pictures back and encodes them.
//!
//! Only [`atomic`] and [`lines`] touch the file system: the one writes files that appear whole or not at all, the other
//! files that grow by whole lines. So nothing half-written stays behind.

pub mod atomic;
pub mod encode;
pub mod exr_file;
pub mod lines;
pub mod sheet;
pub mod still;

pub use encode::{EncodeError, Format};
pub use still::{AovLayer, Picture, Samples, render_still};
