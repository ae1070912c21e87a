//! Accumulates the samples of one picture and reads it back.

use crate::encode::{self, EncodeError};
use manypass::{Aov, AovPixels, FrameRequest, RenderError, Renderer};
use manypass_scene::Scene;

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

/// A named AOV.
#[derive(Clone, Debug, PartialEq)]
pub struct AovLayer {
    /// The name, as in `--aov`.
    pub name: String,
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
    accumulate(renderer, scene, request, samples, progress)?;
    read_picture(renderer, request, want_radiance)
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
    let mut request = request.clone();
    request.sample_count = samples.max(1);
    for sample in 0..request.sample_count {
        request.sample_index = sample;
        if sample + 1 < request.sample_count {
            renderer.accumulate(scene, &request)?;
        } else {
            renderer.render(scene, &request)?;
        }
        if !progress(sample + 1) {
            return Err(StillError::Stopped);
        }
    }
    Ok(())
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
        let samples = match renderer.read_aov(*aov)? {
            AovPixels::Float { components, data } => Samples::Float { components: components as usize, data },
            AovPixels::Id(ids) => Samples::Id(ids),
        };
        aovs.push(AovLayer { name: aov.name().to_owned(), samples });
    }
    Ok(Picture {
        width: request.width,
        height: request.height,
        display_rgba8: renderer.read_display()?,
        radiance: if want_radiance { renderer.read_radiance()? } else { Vec::new() },
        aovs,
    })
}

/// The motion in pixels that a PNG can hold to each side.
const MOTION_RANGE_PX: f32 = 32.0;

/// An AOV as a PNG, and its range in metres if it is depth: 16-bit grey for depth, shifted from −1…1 for normals and
/// from −32…32 pixels for motion, hashed colours for ids, and the values clamped to 0…1 and encoded as sRGB for the
/// rest, with unassociated alpha if they have alpha.
///
/// # Errors
/// If the number of values does not fit the size.
pub fn aov_png(layer: &AovLayer, width: u32, height: u32) -> Result<(Vec<u8>, Option<[f32; 2]>), EncodeError> {
    let pixels: Vec<u8> = match &layer.samples {
        Samples::Float { data, .. } if layer.name == "depth" => {
            let (gray, range) = encode::depth_to_gray16(data);
            return Ok((encode::png_gray16(width, height, &gray)?, range));
        }
        Samples::Id(ids) => ids.iter().flat_map(|id| id_color(*id)).collect(),
        Samples::Float { components, data } => {
            let signed_range = match layer.name.as_str() {
                "normal" | "normal_view" => Some(1.0),
                "motion" => Some(MOTION_RANGE_PX),
                _ => None,
            };
            data.chunks_exact((*components).max(1)).flat_map(|pixel| aov_pixel(pixel, signed_range)).collect()
        }
    };
    Ok((encode::png_rgba8(width, height, &pixels)?, None))
}

/// `signed_range` is the magnitude that becomes 0 or 1; none for values from 0 to 1.
fn aov_pixel(values: &[f32], signed_range: Option<f32>) -> [u8; 4] {
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    let encode = |value: f32| match signed_range {
        Some(range) => byte(0.5 * value / range + 0.5),
        None => byte(srgb_from_linear(value.clamp(0.0, 1.0))),
    };
    match *values {
        [y] => [encode(y), encode(y), encode(y), 255],
        [x, y] => [encode(x), encode(y), 0, 255],
        [x, y, z] => [encode(x), encode(y), encode(z), 255],
        [x, y, z, w, ..] => {
            let unassociated = |value: f32| encode(if w > 0.0 { value / w } else { 0.0 });
            [unassociated(x), unassociated(y), unassociated(z), byte(w)]
        }
        [] => [0; 4],
    }
}

/// The sRGB transfer function (IEC 61966-2-1).
fn srgb_from_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

/// A colour that differs between neighbouring ids; 0, the background, is black.
fn id_color(id: u32) -> [u8; 4] {
    if id == 0 {
        return [0, 0, 0, 255];
    }
    // The finaliser of MurmurHash3 spreads every input bit over every output bit.
    let mut hash = (id ^ (id >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    let [r, g, b, _] = (hash ^ (hash >> 16)).to_le_bytes();
    [r | 32, g | 32, b | 32, 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aovs_become_pngs() {
        let normal =
            AovLayer { name: "normal".into(), samples: Samples::Float { components: 3, data: vec![0.0, 1.0, -1.0] } };
        let (bytes, range) = aov_png(&normal, 1, 1).expect("encoded");
        let decoded = image::load_from_memory(&bytes).expect("decoded").to_rgba8();
        assert_eq!((decoded.get_pixel(0, 0).0, range), ([128, 255, 0, 255], None));
        let depth = AovLayer { name: "depth".into(), samples: Samples::Float { components: 1, data: vec![2.0, 4.0] } };
        assert_eq!(aov_png(&depth, 2, 1).expect("encoded").1, Some([2.0, 4.0]));
        let ids = AovLayer { name: "object_id".into(), samples: Samples::Id(vec![0, 1, 2]) };
        assert!(aov_png(&ids, 3, 1).is_ok() && aov_png(&ids, 2, 2).is_err());
        assert_ne!(id_color(1), id_color(2));
        // 16 pixels to the left and 32 down; half covered by 0.5.
        assert_eq!(aov_pixel(&[-16.0, 32.0], Some(MOTION_RANGE_PX)), [64, 255, 0, 255]);
        assert_eq!(aov_pixel(&[0.25, 0.0, 0.5, 0.5], None), [188, 0, 255, 128]);
    }
}
