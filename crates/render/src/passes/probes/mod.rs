//! probes: every probe as a sphere in its light (`debug.view=probes`); see `probes.wgsl`.
//!
//! Drawn over all that is opaque, and before what is blended. Reads: the texels of probes. Writes: radiance, depth.

use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo =
    PassInfo { off: Some("debug.view=off"), in_fisheye: false, tiers: &[], ..PassInfo::new("probes") };

/// Draws the probes of a view. Returns radiance and depth.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, (radiance, depth): (Handle, Handle)) -> Result<(Handle, Handle), ProgramError> {
    let count = r.view.probe_count;
    if count == 0 || r.view.counts_pairs() {
        return Ok((radiance, depth));
    }
    let step = r.fullscreen("probes", "probes", &[]).quads(count);
    step.draw_nearer_into(radiance, ColorLoad::Keep, depth)
}
