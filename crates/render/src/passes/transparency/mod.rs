//! transparency: the weighted mean of blended surfaces, over what lies behind them all.
//!
//! Source: McGuire & Bavoil 2013, "Weighted Blended Order-Independent Transparency". Where it differs: weights fall
//! with the fourth power of the distance within the range of the scene's blended surfaces, not with fixed distances;
//! what is very bright has less weight, so that half floats hold the sums; and what comes through lies in alpha, so
//! that one blend state does for both targets.
//! Reads: the sums that blended surfaces left. Writes: radiance and coverage.

use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use crate::transparency::BlendTargets;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("transparency");

/// Records the pass, if blended surfaces left sums. Returns radiance and depth.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, blended: BlendTargets) -> Result<(Handle, Handle), ProgramError> {
    let BlendTargets { radiance, depth, sums, .. } = blended;
    let Some([sums, weights]) = sums else { return Ok((radiance, depth)) };
    let step = r.fullscreen("transparency", "transparency", &[]).read("sums", &sums).read("weights", &weights);
    let over = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;
    Ok((step.blend(over).draw_into(radiance, ColorLoad::Keep)?, depth))
}
