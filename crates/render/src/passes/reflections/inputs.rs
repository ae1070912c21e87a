//! What rays of reflections go through: distances and light of the picture, and levels of these.

use super::ScreenInputs;
use crate::constants::REFLECTION_LEVELS;
use crate::gbuffer::{LINEAR_DEPTH, RADIANCE};
use crate::record::{DrawSelection, Recorder, Texels};
use crate::shader::program::ProgramError;
use glam::Vec2;
use manypass_graph::{ColorLoad, DepthLoad, Handle, TextureDesc};
use std::iter::successors;

/// Levels of the picture's light, the first of half its size.
const COARSE_LEVELS: u32 = 5;

/// The uniform of `halve.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct CoarseLevelUniform {
    inverse_size: Vec2,
    inverse_finer_size: Vec2,
}

/// What rays go through.
pub struct RayInputs<'i> {
    pub screen: ScreenInputs<'i>,
    /// The light that they meet.
    pub met: &'i Handle,
    pub pyramid: Handle,
    pub coarse_radiance: Handle,
    pub backs: Option<Handle>,
}

/// How far away the backs of bodies are, so that it is known where what is seen of them ends.
pub fn record_backs(r: &mut Recorder<'_, '_>) -> Result<Handle, ProgramError> {
    let depth = r.texture_of(
        "reflections.backs",
        TextureDesc { format: r.frame.gpu.capabilities.depth_format, ..r.view.desc(LINEAR_DEPTH) },
    );
    let mut pass = r.surfaces("reflections.backs", "geometry");
    let depth = pass.depth(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 });
    pass.backs();
    pass.draw_opaque(DrawSelection::Hiding)?;
    let target = r.texture("reflections.back_distances", LINEAR_DEPTH);
    r.declare_texels(&target, Texels::Distance);
    let step = r.fullscreen("reflections.back_distances", "linear_depth", &[]).constant("leaves_out", 0);
    step.read_depth("depth", &depth).draw_into(target, ColorLoad::Discard)
}

/// The least distances of pixels, and of squares of 2 × 2, 4 × 4, … of them.
pub fn record_pyramid(r: &mut Recorder<'_, '_>, linear_depth: &Handle) -> Result<Handle, ProgramError> {
    let largest = 1 << (REFLECTION_LEVELS - 1);
    let [width, height] = [r.view.size.0, r.view.size.1].map(|side| side.next_multiple_of(largest));
    let desc = TextureDesc { mips: REFLECTION_LEVELS, ..TextureDesc::new_2d(width, height, LINEAR_DEPTH) };
    let pyramid = r.texture_of("reflections.pyramid", desc);
    r.declare_texels(&pyramid, Texels::Distance);
    for level in 0..REFLECTION_LEVELS {
        let target = r.graph.subview(&pyramid, level, 0);
        let finer = (level > 0).then(|| r.graph.subview(&pyramid, level - 1, 0));
        let name = format!("reflections.pyramid.{level}");
        let step = r.fullscreen(name, "reflections_pyramid", &[]).constant("begins", u32::from(level == 0));
        step.read("finer", finer.as_ref().unwrap_or(linear_depth)).draw_into(target, ColorLoad::Discard)?;
    }
    Ok(pyramid)
}

/// The light of the picture at half its size, and at halves of that.
pub fn record_coarse_radiance(r: &mut Recorder<'_, '_>, radiance: &Handle) -> Result<Handle, ProgramError> {
    let sizes: Vec<(u32, u32)> = successors(Some(r.view.size), |(width, height)| {
        ((*width).max(*height) > 1).then_some(((width / 2).max(1), (height / 2).max(1)))
    })
    .skip(1)
    .take(COARSE_LEVELS as usize)
    .collect();
    let (width, height) = sizes.first().copied().unwrap_or((1, 1));
    let mips = sizes.len().max(1) as u32;
    let coarse =
        r.texture_of("reflections.radiance", TextureDesc { mips, ..TextureDesc::new_2d(width, height, RADIANCE) });
    let inverse = |(width, height): (u32, u32)| Vec2::new(width as f32, height as f32).recip();
    for level in 0..mips {
        let target = r.graph.subview(&coarse, level, 0);
        let finer = (level > 0).then(|| r.graph.subview(&coarse, level - 1, 0));
        let size_of = |level: u32| sizes.get(level as usize).copied().unwrap_or((1, 1));
        let finer_size = level.checked_sub(1).map_or(r.view.size, size_of);
        let uniform =
            CoarseLevelUniform { inverse_size: inverse(size_of(level)), inverse_finer_size: inverse(finer_size) };
        let name = format!("reflections.radiance.{level}");
        let step = r.fullscreen(name, "reflections_halve", &[]).uniform("coarse_level", &uniform);
        step.read("finer", finer.as_ref().unwrap_or(radiance)).draw_into(target, ColorLoad::Discard)?;
    }
    Ok(coarse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("reflections_halve", "CoarseLevel", CoarseLevelUniform, [inverse_size, inverse_finer_size]);
    }
}
