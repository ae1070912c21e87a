//! FLIP: how different two pictures look to somebody who flips between them, as a number from 0 to 1 for every pixel.
//!
//! [`ldr`] compares what displays show: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020,
//! "FLIP: A Difference Evaluator for Alternating Images". [`hdr`] compares radiance: Andersson, Nilsson, Shirley and
//! Akenine-Möller 2021, "Visualizing Errors in Rendered High Dynamic Range Images". Written from the papers' formulas;
//! `tests/authors.rs` compares with numbers of the authors' program.
//!
//! Pictures are rows from the top of linear red, green and blue with the primaries of sRGB. Nothing here reads files,
//! and nothing depends on the machine but how many threads work.
//!
//! ```
//! use manypass_flip::{PIXELS_PER_DEGREE, Picture, ldr};
//! let grey = Picture::from_srgb(8, 8, vec![[0.5; 3]; 64])?;
//! let red = Picture::from_srgb(8, 8, vec![[0.5, 0.1, 0.1]; 64])?;
//! assert_eq!(ldr(&grey, &grey, PIXELS_PER_DEGREE)?.mean(), 0.0);
//! assert!(ldr(&grey, &red, PIXELS_PER_DEGREE)?.mean() > 0.5);
//! # Ok::<(), manypass_flip::FlipError>(())
//! ```

mod colour;
mod error_map;
mod filters;
mod high_range;
mod kernel;
mod magma;
mod picture;
mod rows;

pub use error_map::{ErrorMap, LargestError};
pub use high_range::{Exposures, hdr};
pub use magma::magma;
pub use picture::{FlipError, Picture};
pub use rows::ldr;

/// The pixels in a degree of the field of view: 0.7 m before a display that is 0.7 m wide and has 3840 pixels, as in
/// the paper.
pub const PIXELS_PER_DEGREE: f32 = 67.0;

/// The fewest and the most pixels a degree that are taken: beyond, filters are smaller than a pixel or larger than
/// pictures.
pub const PIXELS_PER_DEGREE_RANGE: std::ops::RangeInclusive<f32> = 1.0..=1000.0;
