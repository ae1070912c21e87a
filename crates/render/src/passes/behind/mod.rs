//! behind: the picture so far, with mips, for surfaces that light comes through.
//!
//! Source: what transmission is seen before in KHR_materials_transmission; tents in place of boxes for its mips. Reads:
//! radiance. Writes: behind (radiance and coverage, every mip half the size of the one before).

use crate::gbuffer::RADIANCE;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use bytemuck::{Pod, Zeroable};
use glam::Vec4;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// The uniform of `behind.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Behind {
    /// How far samples lie from the middle, in both directions; one divided by the size of what is drawn.
    step: Vec4,
}

/// Records the passes under names that begin with `name`, which is the texture's: one for each mip.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, name: &'static str, radiance: &Handle) -> Result<Handle, ProgramError> {
    let (width, height) = r.view.size;
    let mips = width.max(height).ilog2() + 1;
    let behind = r.texture_of(name, TextureDesc { mips, ..TextureDesc::new_2d(width, height, RADIANCE) });
    let size_of = |mip: u32| ((width >> mip).max(1) as f32, (height >> mip).max(1) as f32);
    for mip in 0..mips {
        let target = r.graph.subview(&behind, mip, 0);
        let finer = (mip > 0).then(|| r.graph.subview(&behind, mip - 1, 0));
        let (across, down) = size_of(mip);
        // Texels themselves at first, then a texel of what is read to each side.
        let (finer_across, finer_down) = size_of(mip.saturating_sub(1));
        let spread = if mip > 0 { 1.0 } else { 0.0 };
        let step = Vec4::new(spread / finer_across, spread / finer_down, 1.0 / across, 1.0 / down);
        let step_name = if mip == 0 { format!("{name}.copy") } else { format!("{name}.halve.{mip}") };
        let pass = r.fullscreen(step_name, "behind", &[]).read("finer", finer.as_ref().unwrap_or(radiance));
        pass.uniform("behind_step", &Behind { step }).draw_into(target, ColorLoad::Discard)?;
    }
    Ok(behind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("behind", "Behind", Behind, [step]);
    }
}
