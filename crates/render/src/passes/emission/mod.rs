//! emission: keeps what surfaces emit, before light is added to it. Recorded only when the variable is asked for.
//!
//! Reads: radiance as `geometry` or `coverage` begins it. Writes: emission (pre-exposed).

use crate::gbuffer::RADIANCE;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { variables: &["emission"], ..PassInfo::new("emission") };

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, radiance: &Handle) -> Result<Handle, ProgramError> {
    let target = r.texture("emission", RADIANCE);
    r.fullscreen("emission", "emission", &[]).read("radiance", radiance).draw_into(target, ColorLoad::Discard)
}
