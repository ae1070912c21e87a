//! linear_depth: the distance along the view axis in metres, from the depth attachment, once for all later passes.
//!
//! Reads: depth. Writes: linear_depth (r32float; the background is `DISTANCE_BACKGROUND_M`, which stands for infinity).

use crate::gbuffer::LINEAR_DEPTH;
use crate::pass_info::PassInfo;
use crate::record::{Recorder, Texels};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};
use std::borrow::Cow;

/// What lists of passes say of this one.
pub const PASS: PassInfo =
    PassInfo { variables: &["position", "depth"], effect_inputs: &["depth"], ..PassInfo::new("linear_depth") };

/// Records the pass under the name `name`, which is its texture's, too.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    name: impl Into<Cow<'static, str>>,
    depth: &Handle,
) -> Result<Handle, ProgramError> {
    let name = name.into();
    let target = r.texture(name.clone(), LINEAR_DEPTH);
    r.declare_texels(&target, Texels::Distance);
    let leaves_out = u32::from(r.view.settled.is_some());
    let step = r.fullscreen(name, "linear_depth", &[]).constant("leaves_out", leaves_out);
    step.read_depth("depth", depth).leave_out_settled().draw_into(target, ColorLoad::Discard)
}
