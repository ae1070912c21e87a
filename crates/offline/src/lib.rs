//! Stills and sequences as a library: accumulates samples, reads pictures back and encodes them.
//!
//! Every encoder gives bytes; [`atomic`] is the only module that touches the file system, so that nothing half-written
//! stays behind.

pub mod aov_docs;
pub mod aov_png;
pub mod atomic;
pub mod camera;
pub mod encode;
pub mod exr_file;
mod exr_header;
pub mod manifest;
pub mod sheet;
pub mod still;

pub use aov_png::{PngRange, aov_png};
pub use camera::CameraData;
pub use encode::{EncodeError, Format};
pub use exr_header::{Part, PictureInfo};
pub use still::{AovLayer, Picture, Samples, render_still};
