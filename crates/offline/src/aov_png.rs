//! Variables as PNG files from which their values can be had again; [`manypass::AovInfo`] says how.

use crate::encode::{EncodeError, check_length, png_bytes};
use crate::still::{AovLayer, Samples};
use manypass::PngEncoding;
use manypass::colour::srgb_from_linear;
use serde::Serialize;

/// The smallest and the largest value that the numbers of a PNG stand for: one for every channel, or one for all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PngRange {
    /// What the lowest number stands for.
    pub low: Vec<f32>,
    /// What the highest number stands for.
    pub high: Vec<f32>,
}

/// A variable as a PNG, and the range of its values where its encoding has one and any surface is in the picture. The
/// file holds both too, as JSON in a text chunk called `manypass`. What is not finite is taken for background.
///
/// # Errors
/// If the number of values does not fit the size, or an id does not fit 16 bits.
pub fn aov_png(layer: &AovLayer, width: u32, height: u32) -> Result<(Vec<u8>, Option<PngRange>), EncodeError> {
    let info = layer.aov.info();
    let components = info.channels.len();
    check_length(width, height, components, layer.samples.len())?;
    let failed = |reason: String| EncodeError::Encoder { format: "PNG", reason };
    let (bytes, range) = match &layer.samples {
        Samples::Float { data, .. } => encoded(info.png, data, components),
        Samples::Id(ids) => {
            if let Some(id) = ids.iter().find(|id| **id > PngEncoding::LARGEST_ID) {
                return Err(failed(format!("the {} {id} does not fit 16 bits; write .exr", info.name)));
            }
            (ids.iter().flat_map(|id| (*id as u16).to_be_bytes()).collect(), None)
        }
    };
    let is_srgb = info.png == PngEncoding::Srgb8;
    let depth = match info.png {
        PngEncoding::Srgb8 | PngEncoding::Unit8 => png::BitDepth::Eight,
        _ => png::BitDepth::Sixteen,
    };
    let color = match components {
        1 => png::ColorType::Grayscale,
        4 => png::ColorType::Rgba,
        _ => png::ColorType::Rgb,
    };
    let empty = Vec::new();
    let (low, high) = range.as_ref().map_or((&empty, &empty), |range| (&range.low, &range.high));
    let note = serde_json::json!({ "aov": info.name, "unit": info.unit, "low": low, "high": high });
    let note = (!is_srgb).then(|| crate::manifest::ascii(&note));
    let bytes = png_bytes((width, height), color, depth, is_srgb, note.as_deref(), &bytes)?;
    Ok((bytes, range))
}

fn encoded(encoding: PngEncoding, data: &[f32], components: usize) -> (Vec<u8>, Option<PngRange>) {
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    match encoding {
        PngEncoding::Srgb8 => (data.iter().map(|value| byte(srgb_from_linear(value.clamp(0.0, 1.0)))).collect(), None),
        PngEncoding::Unit8 => (data.iter().map(|value| byte(*value)).collect(), None),
        PngEncoding::Signed16 => (signed(data, components), None),
        PngEncoding::Range16 => ranged(data, components),
        PngEncoding::Symmetric16 => symmetric(data, components),
        PngEncoding::Maximum16 | PngEncoding::Id16 => up_to_maximum(data, components),
    }
}

/// From −1…1 to 0…65535; a pixel of zeros, which is no direction, stays zeros.
fn signed(data: &[f32], components: usize) -> Vec<u8> {
    let pixel = |values: &[f32]| {
        let is_nothing = values.iter().all(|value| *value == 0.0);
        let word = |value: &f32| if is_nothing { 0 } else { word_of(0.5 + 0.5 * f64::from(*value), 65535.0) };
        values.iter().flat_map(|value| word(value).to_be_bytes()).collect::<Vec<u8>>()
    };
    data.chunks_exact(components).flat_map(pixel).collect()
}

/// From the smallest to the largest value of each channel to 0…65534; 65535 in all channels is the background.
fn ranged(data: &[f32], components: usize) -> (Vec<u8>, Option<PngRange>) {
    let pixels = || data.chunks_exact(components);
    let surface = |values: &[f32]| values.iter().all(|value| value.is_finite());
    let mut low = vec![f32::INFINITY; components];
    let mut high = vec![f32::NEG_INFINITY; components];
    for values in pixels().filter(|values| surface(values)) {
        for ((low, high), value) in low.iter_mut().zip(&mut high).zip(values) {
            *low = low.min(*value);
            *high = high.max(*value);
        }
    }
    let range = low.iter().all(|value| value.is_finite()).then(|| PngRange { low: low.clone(), high: high.clone() });
    let mut bytes = Vec::with_capacity(data.len() * 2);
    for values in pixels() {
        for ((low, high), value) in low.iter().zip(&high).zip(values) {
            let extent = f64::from(*high) - f64::from(*low);
            let share = if extent > 0.0 { (f64::from(*value) - f64::from(*low)) / extent } else { 0.0 };
            let word = if surface(values) { word_of(share, 65534.0) } else { u16::MAX };
            bytes.extend_from_slice(&word.to_be_bytes());
        }
    }
    (bytes, range)
}

/// From −high…high to 1…65535 with 0 at 32768, where `high` is the largest magnitude, or 1 where that is smaller, so
/// that rounding errors of what stands still are not spread over all numbers; a third channel of zeros.
fn symmetric(data: &[f32], components: usize) -> (Vec<u8>, Option<PngRange>) {
    let high = data.iter().filter(|value| value.is_finite()).fold(1.0f32, |high, value| high.max(value.abs()));
    let mut bytes = Vec::with_capacity(data.len() / components.max(1) * 6);
    for values in data.chunks_exact(components) {
        for value in values {
            let share = if value.is_finite() { f64::from(*value) / f64::from(high) } else { 0.0 };
            bytes.extend_from_slice(&((32768.0 + (share * 32767.0).round()) as u16).to_be_bytes());
        }
        for _ in components..3 {
            bytes.extend_from_slice(&[0; 2]);
        }
    }
    (bytes, Some(PngRange { low: vec![-high], high: vec![high] }))
}

/// From 0 to the largest value of all colours to 0…65535. A fourth channel is alpha, from 0 to 1; colours are divided
/// by it, as PNG wants them.
fn up_to_maximum(data: &[f32], components: usize) -> (Vec<u8>, Option<PngRange>) {
    let alpha_of = |values: &[f32]| values.get(3).copied();
    let color = |value: f32, alpha: Option<f32>| match alpha {
        Some(alpha) if alpha > 0.0 => value / alpha,
        Some(_) => 0.0,
        None => value,
    };
    let colors = |values: &[f32]| {
        let alpha = alpha_of(values);
        values.iter().take(3).map(|value| color(*value, alpha)).collect::<Vec<f32>>()
    };
    let pixels = || data.chunks_exact(components);
    let high = pixels().flat_map(colors).filter(|value| value.is_finite()).fold(0.0f32, f32::max);
    let mut bytes = Vec::with_capacity(data.len() * 2);
    for values in pixels() {
        for value in colors(values) {
            let share = if high > 0.0 { f64::from(value) / f64::from(high) } else { 0.0 };
            bytes.extend_from_slice(&word_of(share, 65535.0).to_be_bytes());
        }
        if let Some(alpha) = alpha_of(values) {
            bytes.extend_from_slice(&word_of(f64::from(alpha), 65535.0).to_be_bytes());
        }
    }
    (bytes, Some(PngRange { low: vec![0.0], high: vec![high] }))
}

/// 0 to 1 as 0 to `largest`; a NaN is 0.
fn word_of(share: f64, largest: f64) -> u16 {
    (share.clamp(0.0, 1.0) * largest).round() as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass::Aov;

    fn words(layer: &AovLayer, width: u32) -> (Vec<u16>, Option<PngRange>, Vec<u8>) {
        let (bytes, range) = aov_png(layer, width, 1).expect("encoded");
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().expect("PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("small")];
        let frame = reader.next_frame(&mut pixels).expect("pixels");
        let words = match frame.bit_depth {
            png::BitDepth::Sixteen => pixels.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect(),
            _ => pixels.into_iter().map(u16::from).collect(),
        };
        (words, range, bytes)
    }

    fn float(aov: Aov, data: Vec<f32>) -> AovLayer {
        AovLayer { aov, samples: Samples::Float { components: aov.info().channels.len(), data } }
    }

    fn has_chunk(bytes: &[u8], name: &[u8; 4]) -> bool {
        bytes.windows(4).any(|window| window == name)
    }

    #[test]
    fn every_encoding_gives_its_values_back() {
        let nothing = f32::INFINITY;
        let (depth, range, bytes) = words(&float(Aov::Depth, vec![1.0, 3.0, nothing, 2.0]), 4);
        assert_eq!(depth, [0, 65534, 65535, 32767]);
        assert_eq!(range, Some(PngRange { low: vec![1.0], high: vec![3.0] }));
        assert!(!has_chunk(&bytes, b"sRGB") && !has_chunk(&bytes, b"gAMA"), "data have no colour space");
        let note = br#"{"aov":"depth","high":[3.0],"low":[1.0],"unit":"metres"}"#;
        assert!(bytes.windows(note.len()).any(|window| window == note), "the range is in the file");
        assert_eq!(words(&float(Aov::Depth, vec![nothing]), 1).1, None);
        assert_eq!(words(&float(Aov::Depth, vec![5.0]), 1).0, [0]);

        let position = vec![-1.0, 2.0, 0.0, 3.0, 2.0, 8.0, nothing, nothing, nothing];
        let (position, range, _) = words(&float(Aov::Position, position), 3);
        assert_eq!(position, [0, 0, 0, 65534, 0, 65534, 65535, 65535, 65535]);
        assert_eq!(range, Some(PngRange { low: vec![-1.0, 2.0, 0.0], high: vec![3.0, 2.0, 8.0] }));

        let (normal, ..) = words(&float(Aov::Normal, vec![0.0, 0.6, -0.8, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 3);
        assert_eq!(normal, [32768, 52428, 6553, 0, 32768, 32768, 0, 0, 0]);

        let (motion, range, _) = words(&float(Aov::Motion, vec![-20.0, 5.0, 0.0, 0.0]), 2);
        assert_eq!(motion, [1, 32768 + 8192, 0, 32768, 32768, 0]);
        assert_eq!(range, Some(PngRange { low: vec![-20.0], high: vec![20.0] }));
        assert_eq!(words(&float(Aov::Motion, vec![1e-6, 0.0]), 1).0, [32768, 32768, 0]);

        // Half covered by radiance 8: a quarter of the largest, which is 32.
        let radiance = vec![4.0, 0.0, 0.0, 0.5, 32.0, 0.0, 0.0, 1.0];
        let (radiance, range, _) = words(&float(Aov::Radiance, radiance), 2);
        assert_eq!(radiance, [16384, 0, 0, 32768, 65535, 0, 0, 65535]);
        assert_eq!(range, Some(PngRange { low: vec![0.0], high: vec![32.0] }));

        let (roughness, range, bytes) = words(&float(Aov::Roughness, vec![0.5, 1.0]), 2);
        assert_eq!((roughness, range), (vec![128, 255], None), "linear, not sRGB");
        assert!(!has_chunk(&bytes, b"sRGB"));
        let (color, _, bytes) = words(&float(Aov::BaseColor, vec![0.214_041_14, 1.0, 0.0]), 1);
        assert_eq!(color, [128, 255, 0]);
        assert!(has_chunk(&bytes, b"sRGB"));
    }

    #[test]
    fn ids_are_numbers_and_too_large_ones_errors() {
        let ids = |ids: &[u32]| AovLayer { aov: Aov::ObjectId, samples: Samples::Id(ids.to_vec()) };
        assert_eq!(words(&ids(&[0, 1, 65534]), 3).0, [0, 1, 65534]);
        assert!(aov_png(&ids(&[65535]), 1, 1).is_err());
        assert!(aov_png(&ids(&[1]), 2, 1).is_err());
    }
}
