//! Stills and sequences as a library: accumulates samples, reads pictures back and encodes them.
//!
//! Only [`atomic`], [`lines`], [`cache`] and `spool` open files: the first writes files that appear whole or not at
//! all, the second files that grow by whole lines, the third a folder of the first, the last files without a name. So
//! nothing half-written stays behind.

pub mod aov_docs;
pub mod aov_png;
pub mod atomic;
pub mod cache;
pub mod camera;
pub mod decode;
pub mod encode;
pub mod exr_file;
mod exr_header;
pub mod lines;
pub mod manifest;
pub mod memory;
mod npz;
pub mod picture_end;
mod png_stream;
pub mod settings_docs;
pub mod sheet;
mod spool;
pub mod stage_docs;
pub mod still;
pub mod stream;
mod tar;
mod y4m;

pub use aov_png::{PngRange, aov_png};
pub use camera::CameraData;
pub use encode::{EncodeError, Format};
pub use exr_header::{ExrCompression, ExrPart, PictureInfo};
pub use still::{AovLayer, Picture, Samples, render_still};
pub use stream::{Container, Stream, StreamError};
