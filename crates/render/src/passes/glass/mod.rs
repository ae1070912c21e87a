//! glass: the backs of bodies that light goes through, and how far away what lies behind them is, for rays that bodies
//! bend where they enter and where they leave.
//!
//! Source: Wyman 2005, "An Approximate Image-Space Approach for Interactive Refraction". Where it differs: the nearest
//! back of a pixel counts, not the farthest, because it is where a ray first leaves a body; and where rays leave, and
//! what they meet, is found step by step (`transmission.wgsl`), not by an estimate of the thickness. Backs of one layer
//! of glass share a texture, because none of them lies behind another.
//! Reads: linear_depth. Writes: `glass` (rgba32float): normal and distance of backs, and the distance of what is
//! behind.

use crate::draws::Draw;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, DepthLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("glass");

/// Distances need all of a float: what lies behind may be infinitely far away, and rays leave bodies that are seen from
/// a thousand times their size.
const GLASS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Records the passes for some of the view's surfaces, under names with a `suffix`. `linear_depth` is that of what they
/// are seen before.
///
/// # Errors
/// A program that does not compile.
pub(crate) fn record(
    r: &mut Recorder<'_, '_>,
    (draws, suffix): (&[Draw], &str),
    linear_depth: &Handle,
) -> Result<Handle, ProgramError> {
    let target = r.texture(format!("glass{suffix}"), GLASS);
    let step = r.fullscreen(format!("glass{suffix}.distances"), "glass_distances", &[]);
    let target = step.read("linear_depth", linear_depth).draw_into(target, ColorLoad::Discard)?;
    let depth = r.texture(format!("glass{suffix}.depth"), r.frame.gpu.capabilities.depth_format);
    let mut pass = r.surfaces(format!("glass{suffix}.backs"), "glass_backs");
    pass.read("linear_depth", linear_depth);
    let target = pass.color(target, ColorLoad::Keep);
    pass.depth(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 });
    pass.backs();
    pass.draw_those(draws)?;
    Ok(target)
}
