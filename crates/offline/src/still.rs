//! Accumulates the samples of one picture and reads it back.

use crate::exr_file::{self, WriteError};
use crate::exr_header::{ExrPart, PictureInfo};
use manypass::{Aov, AovPixels, Averaging, FrameRequest, RenderError, Renderer, View, shutter_position};
use manypass_scene::Scene;
use std::io::{Seek, Write};
use std::ops::Range;
use std::time::{Duration, Instant};

/// The values of an AOV, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Floats, `components` a pixel.
    Float {
        /// Values a pixel.
        components: usize,
        /// All values.
        data: Vec<f32>,
    },
    /// One integer a pixel.
    Id(Vec<u32>),
}

impl Samples {
    /// How many values there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Float { data, .. } => data.len(),
            Self::Id(ids) => ids.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The rows of a picture that is `width` pixels wide.
    pub(crate) fn rows(&self, width: u32, rows: Range<u32>) -> Self {
        let range = |components: usize| {
            let row = width as usize * components;
            (rows.start as usize * row).min(self.len())..(rows.end as usize * row).min(self.len())
        };
        match self {
            Self::Float { components, data } => {
                Self::Float { components: *components, data: data[range(*components)].to_vec() }
            }
            Self::Id(ids) => Self::Id(ids[range(1)].to_vec()),
        }
    }

    /// Appends the bytes of every `step`-th value of a range, in the order of this machine.
    pub(crate) fn append_to(&self, range: Range<usize>, step: usize, bytes: &mut Vec<u8>) {
        let range = range.start.min(self.len())..range.end.min(self.len());
        match self {
            Self::Float { data, .. } => {
                data[range].iter().step_by(step).for_each(|value| bytes.extend_from_slice(&value.to_ne_bytes()));
            }
            Self::Id(ids) => {
                ids[range].iter().step_by(step).for_each(|value| bytes.extend_from_slice(&value.to_ne_bytes()));
            }
        }
    }
}

impl From<AovPixels> for Samples {
    fn from(pixels: AovPixels) -> Self {
        match pixels {
            AovPixels::Float { components, data } => Self::Float { components: components as usize, data },
            AovPixels::Id(ids) => Self::Id(ids),
        }
    }
}

/// A variable with its values.
#[derive(Clone, Debug, PartialEq)]
pub struct AovLayer {
    /// Which variable.
    pub aov: Aov,
    /// The values.
    pub samples: Samples,
}

/// A finished picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// sRGB with unassociated alpha.
    pub display_rgba8: Vec<u8>,
    /// Linear RGBA with associated alpha; empty unless asked for.
    pub radiance: Vec<f32>,
    /// The AOVs that the request wanted, in its order.
    pub aovs: Vec<AovLayer>,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum StillError {
    /// The caller's `progress` said stop.
    #[error("interrupted")]
    Stopped,
    /// The renderer failed.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// The names of all AOVs.
pub fn aov_names() -> Vec<&'static str> {
    Aov::ALL.iter().map(|aov| aov.name()).collect()
}

/// The AOV called `name`.
pub fn aov_named(name: &str) -> Option<Aov> {
    Aov::ALL.iter().copied().find(|aov| aov.name() == name)
}

/// Renders `samples` frames of a still scene, adds them up and reads the result. After every sample `progress` gets
/// the number done and says whether to go on. Radiance is read only if `want_radiance`.
///
/// # Errors
/// If the renderer fails, or `progress` says stop.
pub fn render_still(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    samples: u32,
    want_radiance: bool,
    progress: impl FnMut(u32) -> bool,
) -> Result<Picture, StillError> {
    let mut request = request.clone();
    if want_radiance && !request.averages_radiance() {
        request.averaging = Averaging::Both;
    }
    accumulate(renderer, scene, &request, samples, progress)?;
    read_picture(renderer, &request, want_radiance)
}

/// The first half of [`render_still`]: renders and adds up, and reads nothing.
///
/// # Errors
/// If the renderer fails, or `progress` says stop.
pub fn accumulate(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    samples: u32,
    mut progress: impl FnMut(u32) -> bool,
) -> Result<(), StillError> {
    let request = still_request(renderer, scene, request, samples)?;
    for frame in 0..request.sample_count {
        add_frame(renderer, scene, &FrameRequest { sample_index: frame, ..request.clone() }, &mut progress)?;
    }
    Ok(())
}

/// As [`accumulate`], of a scene that moves while the shutter is open. For each sample `pose` puts the scene as it is at
/// a time from −0.5, when the shutter opens, to 0.5, when it closes, and gives the camera; at 0 that of `request`. The
/// scene is left as it is at 0.
///
/// # Errors
/// If the renderer fails, `pose` fails, or `progress` says stop.
pub fn accumulate_moving<E: From<StillError>>(
    renderer: &mut Renderer,
    scene: &mut Scene,
    request: &FrameRequest,
    samples: u32,
    mut pose: impl FnMut(&mut Scene, f32) -> Result<View, E>,
    mut progress: impl FnMut(u32) -> bool,
) -> Result<(), E> {
    let mut request = still_request(renderer, scene, request, samples)?;
    if scene.has_simulations() {
        pose(scene, 0.0)?;
        renderer.simulate(scene, &mut |_| true).map_err(StillError::from)?;
    }
    for frame in 0..request.sample_count {
        // All frames of a sample show the same.
        if frame % request.frames_per_sample == 0 {
            request.camera = pose(scene, shutter_position(frame / request.frames_per_sample, samples))?;
        }
        add_frame(renderer, scene, &FrameRequest { sample_index: frame, ..request.clone() }, &mut progress)?;
    }
    pose(scene, 0.0)?;
    Ok(())
}

/// Adds a frame of a still to those before it; the last makes the picture.
fn add_frame(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    progress: &mut impl FnMut(u32) -> bool,
) -> Result<(), StillError> {
    if request.sample_index + 1 < request.sample_count {
        renderer.accumulate(scene, request)?;
    } else {
        renderer.render(scene, request)?;
    }
    if !progress(request.sample_index / request.frames_per_sample + 1) {
        return Err(StillError::Stopped);
    }
    Ok(())
}

/// The request of the first frame of a still of so many samples, in which every light casts its shadow: where there are
/// more lights than shadow maps, they take turns, if need be in several frames a sample. In pictures that are
/// anti-aliased by those before them (`taa.enabled`) they take no turns.
///
/// # Errors
/// If the renderer fails.
pub fn still_request(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    samples: u32,
) -> Result<FrameRequest, StillError> {
    let samples = samples.max(1);
    if (FrameRequest { sample_count: samples, ..request.clone() }).is_temporal() {
        // Each frame stands for itself, as in a live view.
        let (sample_count, frames_per_sample, light_rounds) = (samples, 1, None);
        return Ok(FrameRequest { sample_index: 0, sample_count, frames_per_sample, light_rounds, ..request.clone() });
    }
    let light_rounds = renderer.light_rounds(scene, request)?;
    let frames_per_sample = light_rounds.unwrap_or(1).div_ceil(samples);
    let sample_count = samples * frames_per_sample;
    Ok(FrameRequest { sample_index: 0, sample_count, frames_per_sample, light_rounds, ..request.clone() })
}

/// The second half of [`render_still`]: reads what was added up.
///
/// # Errors
/// If the device was lost, or nothing was rendered.
pub fn read_picture(
    renderer: &mut Renderer,
    request: &FrameRequest,
    want_radiance: bool,
) -> Result<Picture, StillError> {
    let mut aovs = Vec::with_capacity(request.want_aovs.len());
    for aov in &request.want_aovs {
        aovs.push(AovLayer { aov: *aov, samples: renderer.read_aov(*aov)?.into() });
    }
    Ok(Picture {
        width: request.width,
        height: request.height,
        display_rgba8: renderer.read_display()?,
        radiance: if want_radiance { renderer.read_radiance()? } else { Vec::new() },
        aovs,
    })
}

/// Reads a variable as [`crate::aov_png()`] wants it: positions where there is no surface are infinite, so that they
/// can be told from the world's origin.
///
/// # Errors
/// If the device was lost, or the frame did not record the variable.
pub fn read_for_png(renderer: &mut Renderer, aov: Aov) -> Result<AovLayer, StillError> {
    let mut samples: Samples = renderer.read_aov(aov)?.into();
    if let (Aov::Position, Samples::Float { data, .. }) = (aov, &mut samples)
        && let AovPixels::Float { data: depth_m, .. } = renderer.read_aov(Aov::Depth)?
    {
        for (position, depth_m) in data.chunks_exact_mut(3).zip(&depth_m) {
            if depth_m.is_infinite() {
                position.fill(f32::INFINITY);
            }
        }
    }
    Ok(AovLayer { aov, samples })
}

/// Writes what was added up as OpenEXR: the picture, and the variables that `request` wanted; reading and writing it
/// band by band. Gives the time that it took to read.
///
/// # Errors
/// If the device was lost, nothing was rendered, or the writer fails.
pub fn write_exr<W: Write + Seek>(
    out: &mut W,
    renderer: &mut Renderer,
    request: &FrameRequest,
    info: &PictureInfo,
) -> Result<Duration, WriteError<StillError>> {
    let mut parts = vec![ExrPart::picture()];
    parts.extend(request.want_aovs.iter().map(|aov| ExrPart::of(*aov)));
    let mut reading = Duration::ZERO;
    exr_file::write(out, (request.width, request.height), &parts, info, |part, rows| {
        let start = Instant::now();
        // The first part is the picture itself, which is this variable too.
        let aov = part.checked_sub(1).and_then(|index| request.want_aovs.get(index));
        let samples = match aov {
            None => Samples::Float { components: 4, data: renderer.read_radiance_rows(rows)? },
            Some(aov) => renderer.read_aov_rows(*aov, rows)?.into(),
        };
        reading += start.elapsed();
        Ok(samples)
    })?;
    Ok(reading)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_channels_are_cut_out() {
        let samples = Samples::Float { components: 2, data: (0..12).map(|value| value as f32).collect() };
        assert_eq!(samples.rows(2, 1..2), Samples::Float { components: 2, data: vec![4.0, 5.0, 6.0, 7.0] });
        assert_eq!(samples.rows(2, 2..9).len(), 4);
        let mut bytes = Vec::new();
        samples.append_to(5..8, 2, &mut bytes);
        assert_eq!(bytes, [5.0f32.to_ne_bytes(), 7.0f32.to_ne_bytes()].concat());
    }
}
