//! Light that is computed beforehand.
//!
//! [`bake`] makes textures of the light that reaches the surfaces of a scene that stay where they are: from
//! its lights, from what shines, from around it, and from each other. Rays on the CPU find it, without a GPU, and the
//! same scene with the same settings gives the same bytes on every machine of one kind. [`ProbeBaker`] finds the light that arrives
//! at places between them, [`SurroundingsBaker`] what is to be seen there.

mod apply;
mod denoise;
mod emitters;
mod encode;
mod error;
mod file;
mod fill;
mod gather;
mod layout;
mod light_map;
mod materials;
mod paths;
mod probes;
mod progress;
mod sampling;
mod seams;
mod small_source;
#[cfg(doctest)]
mod snippets;
mod surfaces;
mod surroundings;
mod texels;
mod tracing;
mod work;

pub use emitters::DistantLight;
pub use encode::Encoding;
pub use error::BakeError;
pub use layout::{Layout, LayoutSettings, SIDE_MAX, TEXELS_MAX, UnwrappedPrimitive};
pub use light_map::{BOUNCES_MAX, BakeSettings, BakedMaps, Baker, SAMPLES_MAX, bake};
pub use probes::{ProbeBaker, ProbeSettings};
pub use progress::{Progress, Stage};
pub use surfaces::{Place, Surfaces};
pub use surroundings::{SurroundingsBaker, SurroundingsSettings, picture_file};
pub use work::Keeper;
