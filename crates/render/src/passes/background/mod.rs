//! background: the backdrop of the environment, where there is no opaque surface; blended ones are drawn over it later.
//!
//! Reads: the environment, depth. Writes: radiance. A background colour is none of radiance: `tone_map` lays the
//! picture over it.

mod settings;

pub use settings::BackgroundSettings;

use crate::environment::Background;
use crate::pass_info::PassInfo;
use crate::record::{PicturePart, Recorder};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("background");

/// Records the pass; only the environment as background needs it.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &BackgroundSettings,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if settings.source != Background::Environment {
        return Ok(radiance);
    }
    let step = r.fullscreen("background", "background", &[]);
    step.over(PicturePart::Background, depth).draw_into(radiance, ColorLoad::Keep)
}
