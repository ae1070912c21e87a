//! motion: how far the point of every pixel moved since the previous frame, in pixels. Recorded only when the variable
//! is asked for.
//!
//! Source: Green 2003, "Stupid OpenGL Shader Tricks": every vertex in its pose of this frame and of the previous one;
//! but the division by w happens at the fragment, so that the value is exact within large triangles too. It draws
//! opaque and masked surfaces again where their depth lies in the depth buffer: positions are `@invariant`. Behind them
//! is what lies infinitely far away, which moves by the camera's rotation alone. Reads: depth, the previous pose.
//! Writes: motion (rg32float).

use crate::pass_info::PassInfo;
use crate::record::{DrawSelection, Recorder, Texels};
use crate::shader::program::ProgramError;
use crate::view::{CameraStep, View};
use glam::{Mat4, Vec2};
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { variables: &["motion"], effect_inputs: &["motion"], ..PassInfo::new("motion") };

/// The format of `motion`: pixels to the right, pixels down.
pub const MOTION: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

/// The uniform of `spaces.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct MotionUniform {
    /// This frame's, without jitter.
    clip_from_world: Mat4,
    /// The previous frame's, without jitter.
    previous_clip_from_world: Mat4,
    /// Half the picture's size in pixels; y is negative.
    pixel_from_ndc: Vec2,
    /// Zero.
    padding: Vec2,
}

impl MotionUniform {
    fn new(step: &CameraStep) -> Self {
        let size_px = Vec2::new(step.output_size.0 as f32, step.output_size.1 as f32);
        let clip_from_world = |view: &View| {
            view.clip_from_view(step.range, size_px.x / size_px.y, Vec2::ZERO) * view.world_from_view.inverse()
        };
        Self {
            clip_from_world: clip_from_world(&step.current),
            previous_clip_from_world: clip_from_world(&step.previous),
            pixel_from_ndc: 0.5 * size_px * Vec2::new(1.0, -1.0),
            padding: Vec2::ZERO,
        }
    }
}

/// Records the passes. Without a previous frame nothing moved.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, depth: &Handle, step: Option<&CameraStep>) -> Result<Handle, ProgramError> {
    let target = r.texture("motion", MOTION);
    r.declare_texels(&target, Texels::Motion);
    let Some(step) = step else {
        return Ok(r.graph.pass("motion").color(target, ColorLoad::Clear(wgpu::Color::TRANSPARENT)));
    };
    let uniform = MotionUniform::new(step);
    let background = r.fullscreen("motion.background", "motion_background", &[]).uniform("motion", &uniform);
    let motion = background.draw_into(target, ColorLoad::Discard)?;
    let mut pass = r.surfaces("motion", "motion");
    pass.uniform("motion", &uniform);
    let motion = pass.color(motion, ColorLoad::Keep);
    pass.depth_read_only(depth);
    pass.draw_opaque(DrawSelection::All)?;
    Ok(motion)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "motion",
            "Motion",
            MotionUniform,
            [clip_from_world, previous_clip_from_world, pixel_from_ndc, padding]
        );
    }
}
