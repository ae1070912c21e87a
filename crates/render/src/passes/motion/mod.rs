//! motion: how far the point of every pixel moved since the previous frame, in pixels. Recorded only when the variable
//! is asked for.
//!
//! Source: Green 2003, "Stupid OpenGL Shader Tricks": every vertex in its pose of this frame and of the previous one;
//! but the division by w happens at the fragment, so that the value is exact within large triangles too. It draws
//! opaque and masked surfaces again where their depth lies in the depth buffer: positions are `@invariant`. Behind them
//! is what lies infinitely far away, which moves by the camera's rotation alone. Reads: depth, the previous pose.
//! Writes: motion (rg32float).

use crate::frame::Shared;
use crate::shader::program::ProgramError;
use crate::surfaces::{self, Targets};
use crate::view::{DepthRange, View};
use glam::{Mat4, Vec2};
use manypass_graph::{ColorLoad, Graph, Handle, TextureDesc};

/// The format of `motion`: pixels to the right, pixels down.
pub const MOTION: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

/// The uniform of `spaces.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct MotionUniform {
    /// This frame's, without jitter.
    pub clip_from_world: Mat4,
    /// The previous frame's, without jitter.
    pub previous_clip_from_world: Mat4,
    /// Half the picture's size in pixels; y is negative.
    pub pixel_from_ndc: Vec2,
    /// Zero.
    pub padding: Vec2,
}

impl MotionUniform {
    /// Two views of one shape onto a picture of `output_size` pixels; without a previous view nothing moved.
    pub fn new(camera: &View, previous: Option<&View>, range: DepthRange, output_size: (u32, u32)) -> Self {
        let size_px = Vec2::new(output_size.0 as f32, output_size.1 as f32);
        let clip_from_world = |view: &View| {
            view.clip_from_view(range, size_px.x / size_px.y, Vec2::ZERO) * view.world_from_view.inverse()
        };
        Self {
            clip_from_world: clip_from_world(camera),
            previous_clip_from_world: clip_from_world(previous.unwrap_or(camera)),
            pixel_from_ndc: 0.5 * size_px * Vec2::new(1.0, -1.0),
            padding: Vec2::ZERO,
        }
    }
}

/// Records the passes. Without a previous frame nothing moved.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(graph: &mut Graph<'f>, shared: &'f Shared<'f>, depth: &Handle) -> Result<Handle, ProgramError> {
    let (width, height) = shared.size;
    let target = graph.texture("motion", TextureDesc::new_2d(width, height, MOTION));
    if !shared.has_previous {
        return Ok(graph.pass("motion").color(target, ColorLoad::Clear(wgpu::Color::TRANSPARENT)));
    }
    let step = shared.fullscreen("motion_background", &[], MOTION, None)?;
    let mut pass = graph.pass("motion.background");
    let motion = pass.color(target, ColorLoad::Discard);
    pass.draw(move |context| step.draw(context, &[], &[]));

    let targets = Targets { colors: vec![MOTION], blend: None, depth: shared.depth_format, depth_write: false };
    let draws = surfaces::prepare(shared, "motion", &targets, &shared.draws.opaque)?;
    let mut pass = graph.pass("motion");
    let motion = pass.color(motion, ColorLoad::Keep);
    pass.depth_stencil_read_only(depth);
    pass.draw(move |context| surfaces::draw(context, shared.resources, shared.instances, &draws));
    Ok(motion)
}
