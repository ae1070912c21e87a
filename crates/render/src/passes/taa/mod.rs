//! taa: anti-aliasing over time: every frame is moved by a part of a pixel, and added to what the frames before showed of
//! the same surfaces.
//!
//! Sources: Karis 2014, "High Quality Temporal Supersampling" (reprojection by the motion of the nearest neighbour, boxes
//! in YCoCg, weights by brightness); Salvi 2016, "An Excursion in Temporal Supersampling" (boxes by variance); Jimenez
//! 2016, "Filmic SMAA" (Catmull-Rom in five lookups). Differences: what stands still has the mean of many frames, and not
//! one that forgets fast, so that nothing shimmers; for that boxes are as wide as the pixel flickers, which is known by
//! differences of two frames that have opposite signs, so that a change of light, which has one, leaves no trail.
//! Brightness is compressed by a curve that is straight up to where the default tone curve is, so that the mean is that of
//! display colours, as in stills.
//!
//! Reads: radiance, linear_depth, motion, and what the last frame left. Writes: radiance (`taa.next`), and what it knows
//! of the surface of each pixel (`taa.surface.next`: rgba16float, see `surface.wgsl`).

mod settings;

pub use settings::TaaSettings;

use crate::gbuffer::RADIANCE;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use crate::view::CameraStep;
use glam::Vec4;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// The frames before, which a frame goes on from.
#[derive(Clone, Copy, Debug)]
pub struct FramesBefore {
    /// From where the last one was seen.
    pub camera_step: CameraStep,
    /// What its radiance is multiplied by to be this frame's: pre-exposure may have changed.
    pub gain: f32,
    /// Whether nothing changed since: neither the scene nor the camera, nor how they are shown.
    pub stands: bool,
}

/// A frame that is anti-aliased over time.
#[derive(Clone, Copy, Debug)]
pub struct TemporalFrame {
    /// From pre-exposed radiance to what the tone curve takes.
    pub exposure: f32,
    /// None if it is the first.
    pub before: Option<FramesBefore>,
}

/// What the passes read of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'h> {
    /// Pre-exposed, with coverage.
    pub radiance: &'h Handle,
    /// Metres.
    pub linear_depth: &'h Handle,
    /// Pixels of the picture since the last frame.
    pub motion: &'h Handle,
}

/// The uniform of `history.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct TaaUniform {
    /// The distance from the last frame's camera of a point (x, y, z, 1) in world space.
    previous_distance_row: Vec4,
    /// 1 / width and height of what is written.
    inverse_size_px: [f32; 2],
    /// Its texels for each pixel of the picture, in which motion is.
    texels_per_px: [f32; 2],
    exposure: f32,
    /// What the last frame's radiance is multiplied by; 0 without one.
    gain: f32,
    /// Frames that are averaged where nothing moves.
    most_still: f32,
    /// And where something does.
    most_moving: f32,
    /// Half the side of boxes in standard deviations.
    clip: f32,
    /// What is added to that, more than any colour where nothing changed since the last frame.
    reach: f32,
    /// The least number of frames that are averaged at the most.
    most_sure: f32,
    /// Zero.
    padding: f32,
}

impl TaaUniform {
    fn new(settings: &TaaSettings, frame: &TemporalFrame, before: Option<&FramesBefore>, size: (u32, u32)) -> Self {
        let size_px = [size.0 as f32, size.1 as f32];
        let output_size = before.map_or(size, |before| before.camera_step.output_size);
        let stands = before.is_some_and(|before| before.stands);
        let view_from_world = before.map(|before| before.camera_step.previous.world_from_view.inverse());
        Self {
            previous_distance_row: view_from_world.map_or(Vec4::W, |matrix| -matrix.row(2)),
            inverse_size_px: size_px.map(f32::recip),
            texels_per_px: [size_px[0] / output_size.0 as f32, size_px[1] / output_size.1 as f32],
            exposure: frame.exposure,
            gain: before.map_or(0.0, |before| before.gain),
            most_still: settings.samples as f32,
            most_moving: 1.0 / (1.0 - settings.feedback.clamp(0.0, 0.98)),
            clip: settings.clip,
            reach: if stands { 10.0 } else { 0.0 },
            most_sure: if stands { settings.samples as f32 } else { 1.0 },
            padding: 0.0,
        }
    }
}

/// Records the passes. Returns the frame's radiance.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &TaaSettings,
    frame: &TemporalFrame,
    shown: Shown<'_>,
) -> Result<Handle, ProgramError> {
    let TextureDesc { width, height, .. } = shown.radiance.desc();
    let desc = TextureDesc::new_2d(width, height, RADIANCE);
    let (colors, surfaces) = (r.history("taa", desc), r.history("taa.surface", desc));
    let before = frame.before.as_ref().filter(|_| !colors.is_first && !surfaces.is_first);
    let uniform = TaaUniform::new(settings, frame, before, (width, height));
    // A first frame looks at nothing before it, but something has to be bound.
    let previous = if before.is_some() { &colors.previous } else { shown.radiance };
    let previous_surface = if before.is_some() { &surfaces.previous } else { shown.radiance };
    let surface = r
        .fullscreen("taa.surface", "taa_surface", &[])
        .uniform("taa", &uniform)
        .read("radiance", shown.radiance)
        .read("linear_depth", shown.linear_depth)
        .read("motion", shown.motion)
        .read("previous_surface", previous_surface)
        .draw_into(surfaces.next, ColorLoad::Discard)?;
    r.fullscreen("taa", "taa", &[])
        .uniform("taa", &uniform)
        .read("radiance", shown.radiance)
        .read("previous", previous)
        .read("motion", shown.motion)
        .read("surface", &surface)
        .draw_into(colors.next, ColorLoad::Discard)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "taa",
            "Taa",
            TaaUniform,
            [
                previous_distance_row,
                inverse_size_px,
                texels_per_px,
                exposure,
                gain,
                most_still,
                most_moving,
                clip,
                reach,
                most_sure,
                padding
            ]
        );
    }
}
