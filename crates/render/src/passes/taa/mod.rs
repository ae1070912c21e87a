//! taa: anti-aliasing over time: every frame is moved by a part of a pixel, and added to what the frames before showed of
//! the same surfaces.
//!
//! Sources: Karis 2014, "High Quality Temporal Supersampling" (reprojection by the motion of the nearest neighbour, boxes
//! in YCoCg, weights by brightness); Salvi 2016, "An Excursion in Temporal Supersampling" (boxes by variance); Jimenez
//! 2016, "Filmic SMAA" (Catmull-Rom in five lookups). Differences: what stands still has the mean of many frames, and not
//! one that forgets fast, so that nothing shimmers; for that boxes are as wide as the pixel flickers, which is known by
//! differences of two frames that have opposite signs. Where a surface stands still and another light falls on it, by all of
//! 3 × 3 pixels, its mean begins anew (`surface.wgsl`), so that shadows that move, and lamps that change, leave no trail.
//! Brightness is compressed by a curve that is straight up to where the default tone curve is, so that the mean is that of
//! display colours, as in stills.
//!
//! Reads: radiance, linear_depth, motion, and what the last frame left. Writes: radiance (`taa.next`), and what it knows
//! of the surface of each pixel (`taa.surface.next`: rgba16float, or rgba32float, see `surface.wgsl`).
//!
//! Where the picture is larger than its frames (`upscale.method=temporal`), what is written has its size: a frame's samples
//! are weighted by their distance from the middle of the pixel, as in the first source, by a box as wide as a pixel, so
//! that the mean is that of the still; what lies between samples counts little, and shows until one came.

mod settings;

pub use settings::TaaSettings;

use crate::gbuffer::RADIANCE;
use crate::pass_info::{PassInfo, Reach};
use crate::record::{Recorder, Texels};
use crate::shader::program::ProgramError;
use crate::view::CameraStep;
use glam::Vec4;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { off: Some("taa.enabled=false"), tiers: &[], ..PassInfo::deferred("taa") };

/// How far it looks; none if settings switch it off. Of several samples the first alone is anti-aliased over time.
pub fn reach(settings: &TaaSettings) -> Option<Reach> {
    settings.enabled.then_some(Reach::FirstSamples)
}

/// The frames before, which a frame goes on from.
#[derive(Clone, Copy, Debug)]
pub struct PreviousFrames {
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
    pub before: Option<PreviousFrames>,
    /// The picture's size, if what is written has that, and not the size at which the frame was shaded.
    pub upscaled_to: Option<(u32, u32)>,
}

/// What the passes read of a frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameInputs<'h> {
    /// Pre-exposed, with coverage.
    pub radiance: &'h Handle,
    /// Metres.
    pub linear_depth: &'h Handle,
    /// Pixels of the picture since the last frame.
    pub motion: &'h Handle,
}

/// What is interpolated of a frame counts, beside samples where they are, where the picture is larger than the frame.
const FAR_WEIGHT: f32 = 0.03;
/// The same where something moves: found by measuring (`cargo xtask bench --only antialiasing`).
const FAR_WEIGHT_MOVING: f32 = 1.5;

/// The format of what is known of surfaces where counts of frames are not whole.
const FINE_SURFACE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

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
    /// The frame's texels for each of its.
    shaded_per_texel: [f32; 2],
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
    /// What a sample counts that lies in the texel, where the frame is smaller than what is written; in frames.
    near_weight: f32,
    /// What a frame counts whose samples lie beside it.
    far_weight: f32,
    /// The same where something moves.
    far_weight_moving: f32,
}

impl TaaUniform {
    /// Of a frame that was shaded at one size, and is written at another one.
    fn new(
        settings: &TaaSettings,
        frame: &TemporalFrame,
        before: Option<&PreviousFrames>,
        [shaded, size]: [(u32, u32); 2],
    ) -> Self {
        let size_px = [size.0 as f32, size.1 as f32];
        let shaded_per_texel = [shaded.0 as f32 / size_px[0], shaded.1 as f32 / size_px[1]];
        let texels_per_sample = (shaded_per_texel[0] * shaded_per_texel[1]).recip();
        // Of a pixel as many samples as without.
        let most_still = settings.samples as f32 * texels_per_sample;
        let output_size = before.map_or(size, |before| before.camera_step.output_size);
        let stands = before.is_some_and(|before| before.stands);
        let view_from_world = before.map(|before| before.camera_step.previous.world_from_view.inverse());
        Self {
            previous_distance_row: view_from_world.map_or(Vec4::W, |matrix| -matrix.row(2)),
            inverse_size_px: size_px.map(f32::recip),
            texels_per_px: [size_px[0] / output_size.0 as f32, size_px[1] / output_size.1 as f32],
            shaded_per_texel,
            exposure: frame.exposure,
            gain: before.map_or(0.0, |before| before.gain),
            most_still,
            most_moving: 1.0 / (1.0 - settings.feedback.clamp(0.0, 0.98)),
            clip: settings.clip,
            reach: if stands { 10.0 } else { 0.0 },
            most_sure: if stands { most_still } else { 1.0 },
            // A sample comes to lie in one frame of so many, so that each counts as one in the mean.
            near_weight: texels_per_sample,
            far_weight: FAR_WEIGHT,
            far_weight_moving: FAR_WEIGHT_MOVING,
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
    inputs: FrameInputs<'_>,
) -> Result<Handle, ProgramError> {
    let TextureDesc { width, height, .. } = inputs.radiance.desc();
    let shaded = (width, height);
    let size = frame.upscaled_to.unwrap_or(shaded);
    let upscales = [("upscales", u32::from(size != shaded))];
    let desc = |format| TextureDesc::new_2d(size.0, size.1, format);
    let colors = r.history("taa", desc(RADIANCE));
    let surfaces = r.history("taa.surface", desc(if size == shaded { RADIANCE } else { FINE_SURFACE }));
    // Logarithms of distances, beside counts.
    r.declare_texels(&surfaces.next, Texels::Number);
    let before = frame.before.as_ref().filter(|_| !colors.is_first && !surfaces.is_first);
    let uniform = TaaUniform::new(settings, frame, before, [shaded, size]);
    // A first frame looks at nothing before it, but something has to be bound.
    let previous = if before.is_some() { &colors.previous } else { inputs.radiance };
    let previous_surface = if before.is_some() { &surfaces.previous } else { inputs.radiance };
    let surface = r
        .fullscreen("taa.surface", "taa_surface", &[])
        .constants(&upscales)
        .uniform("taa", &uniform)
        .read("radiance", inputs.radiance)
        .read("linear_depth", inputs.linear_depth)
        .read("motion", inputs.motion)
        .read("previous_surface", previous_surface)
        .draw_into(surfaces.next, ColorLoad::Discard)?;
    r.fullscreen("taa", "taa", &[])
        .constants(&upscales)
        .uniform("taa", &uniform)
        .read("radiance", inputs.radiance)
        .read("previous", previous)
        .read("motion", inputs.motion)
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
                shaded_per_texel,
                exposure,
                gain,
                most_still,
                most_moving,
                clip,
                reach,
                most_sure,
                near_weight,
                far_weight,
                far_weight_moving
            ]
        );
    }
}
