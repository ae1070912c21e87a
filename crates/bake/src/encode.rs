//! Light as files.

use crate::BakeError;
use exr::prelude::{Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage};
use half::f16;
use manypass_scene::colour::srgb_from_linear;
use manypass_scene::environment::RADIANCE_MAX;
use manypass_scene::material::LightEncoding;
use std::io::Cursor;

/// A PNG file of grey texels from 0 to 1, rows from the top.
///
/// # Errors
/// The encoder fails.
pub(crate) fn grey_png(texels: &[[f32; 1]], width: u32, height: u32) -> Result<Vec<u8>, BakeError> {
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    let data = texels.iter().map(|[value]| byte(*value)).collect();
    let image = image::GrayImage::from_raw(width, height, data);
    png(&image.ok_or_else(|| BakeError::Encode("texels are missing".into()))?)
}

/// A PNG file of vectors whose parts are from -1 to 1, rows from the top: half of each and a half.
///
/// # Errors
/// The encoder fails.
pub(crate) fn direction_png(texels: &[[f32; 3]], (width, height): (u32, u32)) -> Result<Vec<u8>, BakeError> {
    let byte = |part: &f32| ((part * 0.5 + 0.5).clamp(0.0, 1.0) * 255.0).round() as u8;
    let image = image::RgbImage::from_raw(width, height, texels.iter().flatten().map(byte).collect());
    png(&image.ok_or_else(|| BakeError::Encode("texels are missing".into()))?)
}

/// How light maps are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// OpenEXR: half floats. In glTF the texture has the extension `MANYPASS_texture_exr`.
    #[default]
    Exr,
    /// Radiance: three bytes with a common exponent (Ward 1991, "Real Pixels"). In glTF the texture has the extension
    /// `MOZ_texture_rgbe`, as Mozilla Hubs has it.
    Rgbe,
    /// PNG: three bytes that a fourth one multiplies; see [`LightEncoding::Rgbm`]. Plain glTF but for the range.
    Rgbm,
}

impl Encoding {
    /// The words for all of them.
    pub const NAMES: [&str; 3] = ["exr", "rgbe", "rgbm"];

    /// The one of a word.
    pub fn named(word: &str) -> Option<Self> {
        match word {
            "exr" => Some(Self::Exr),
            "rgbe" => Some(Self::Rgbe),
            "rgbm" => Some(Self::Rgbm),
            _ => None,
        }
    }

    /// How materials say it.
    pub(crate) fn of_material(self) -> LightEncoding {
        if self == Self::Rgbm { LightEncoding::Rgbm } else { LightEncoding::Linear }
    }

    /// The extension of the texture whose source it is, if it is none of plain glTF.
    pub(crate) fn extension(self) -> Option<&'static str> {
        match self {
            Self::Exr => Some("MANYPASS_texture_exr"),
            Self::Rgbe => Some("MOZ_texture_rgbe"),
            Self::Rgbm => None,
        }
    }
}

/// A file of light and what its values are to be multiplied by.
pub(crate) struct LightFile {
    pub mime_type: &'static str,
    pub bytes: Vec<u8>,
    pub factor: f32,
}

/// Light as a file, of texels that are rows from the top.
///
/// # Errors
/// The encoder fails.
pub(crate) fn light_file(
    encoding: Encoding,
    texels: &[[f32; 3]],
    (width, height): (u32, u32),
) -> Result<LightFile, BakeError> {
    match encoding {
        Encoding::Exr => Ok(LightFile { mime_type: "image/x-exr", bytes: exr(texels, width, height)?, factor: 1.0 }),
        Encoding::Rgbe => {
            let clean = |value: f32| if value.is_finite() { value.clamp(0.0, RADIANCE_MAX) } else { 0.0 };
            let texels: Vec<image::Rgb<f32>> = texels.iter().map(|texel| image::Rgb(texel.map(clean))).collect();
            let mut bytes = Vec::new();
            let written =
                image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&texels, width as usize, height as usize);
            written.map_err(|error| BakeError::Encode(error.to_string()))?;
            Ok(LightFile { mime_type: "image/vnd.radiance", bytes, factor: 1.0 })
        }
        Encoding::Rgbm => {
            let largest = texels.iter().flatten().copied().filter(|value| value.is_finite()).fold(0.0, f32::max);
            let range = if largest > 0.0 { largest.min(RADIANCE_MAX) } else { 1.0 };
            Ok(LightFile { mime_type: "image/png", bytes: rgbm_png(texels, width, height, range)?, factor: range })
        }
    }
}

/// The share of texels that are brighter than the range of [`emission_png`].
const BEYOND_RANGE: f64 = 0.001;

/// Light as a PNG file in sRGB, which every viewer reads as emission, and what its values are to be multiplied by. So that
/// few bright texels do not make all others dark and coarse, a thousandth may be cut.
///
/// # Errors
/// The encoder fails.
pub(crate) fn emission_png(texels: &[[f32; 3]], (width, height): (u32, u32)) -> Result<(Vec<u8>, f32), BakeError> {
    let mut most: Vec<f32> = texels.iter().map(|texel| texel.iter().copied().fold(0.0, f32::max)).collect();
    most.retain(|value| *value > 0.0 && value.is_finite());
    most.sort_unstable_by(f32::total_cmp);
    let last = most.len().saturating_sub(1);
    let range = most.get(last - (last as f64 * BEYOND_RANGE) as usize).copied().unwrap_or(1.0).min(RADIANCE_MAX);
    let byte = |value: f32| {
        let linear = if value.is_finite() { (value / range).clamp(0.0, 1.0) } else { 0.0 };
        (srgb_from_linear(linear) * 255.0).round() as u8
    };
    let data = texels.iter().flatten().map(|value| byte(*value)).collect();
    let image = image::RgbImage::from_raw(width, height, data);
    Ok((png(&image.ok_or_else(|| BakeError::Encode("texels are missing".into()))?)?, range))
}

/// The smallest alpha with which all three colours fit, and what they are with it.
fn rgbm([r, g, b]: [f32; 3], range: f32) -> [u8; 4] {
    let [r, g, b] = [r, g, b].map(|value| if value.is_finite() { (value / range).clamp(0.0, 1.0) } else { 0.0 });
    let multiplier = (r.max(g).max(b) * 255.0).ceil().clamp(1.0, 255.0);
    let byte = |value: f32| (value * 255.0 * 255.0 / multiplier).round().min(255.0) as u8;
    [byte(r), byte(g), byte(b), multiplier as u8]
}

fn rgbm_png(texels: &[[f32; 3]], width: u32, height: u32, range: f32) -> Result<Vec<u8>, BakeError> {
    let data = texels.iter().flat_map(|texel| rgbm(*texel, range)).collect();
    let image = image::RgbaImage::from_raw(width, height, data);
    let image = image.ok_or_else(|| BakeError::Encode("texels are missing".into()))?;
    png(&image)
}

fn png<P: image::PixelWithColorType<Subpixel = u8>>(
    image: &image::ImageBuffer<P, Vec<u8>>,
) -> Result<Vec<u8>, BakeError> {
    let mut bytes = Vec::new();
    let written = image.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png);
    written.map_err(|error| BakeError::Encode(error.to_string()))?;
    Ok(bytes)
}

/// An OpenEXR file of half floats, of texels that are rows from the top.
///
/// # Errors
/// The encoder fails.
fn exr(texels: &[[f32; 3]], width: u32, height: u32) -> Result<Vec<u8>, BakeError> {
    let half = |value: f32| f16::from_f32(if value.is_finite() { value.clamp(0.0, RADIANCE_MAX) } else { 0.0 });
    let width = width as usize;
    let at = |Vec2(x, y): Vec2<usize>| {
        let [r, g, b] = texels.get(y * width + x).copied().unwrap_or_default().map(half);
        (r, g, b)
    };
    let channels = SpecificChannels::rgb(at);
    let size = (width, height as usize);
    let layer = Layer::new(size, LayerAttributes::default(), exr::prelude::Encoding::SMALL_LOSSLESS, channels);
    let mut bytes = Vec::new();
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(Cursor::new(&mut bytes));
    written.map_err(|error| BakeError::Encode(error.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass_scene::{Image, ImageSource};

    #[test]
    fn every_encoding_comes_back() {
        let texels: Vec<[f32; 3]> =
            (0..64).map(|at| [0.01 * at as f32, 3.0 - 0.04 * at as f32, if at % 9 == 0 { 0.0 } else { 0.7 }]).collect();
        for (encoding, share) in [(Encoding::Exr, 0.0006), (Encoding::Rgbe, 0.009), (Encoding::Rgbm, 0.009)] {
            let file = light_file(encoding, &texels, (16, 4)).unwrap();
            let image = Image { name: String::new(), source: ImageSource::Encoded(file.bytes.into()) };
            let light = if encoding == Encoding::Rgbm { image.decode_rgbm() } else { image.decode_light() }.unwrap();
            assert_eq!((light.width, light.height), (16, 4));
            for (found, expected) in light.texels.iter().zip(&texels) {
                let most = expected.iter().copied().fold(0.0, f32::max);
                for (found, expected) in found.iter().zip(expected) {
                    let found = found.to_f32() * file.factor;
                    assert!((found - expected).abs() <= share * most, "{encoding:?}: {found} is not {expected}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_number_is_black() {
        for encoding in [Encoding::Exr, Encoding::Rgbe, Encoding::Rgbm] {
            assert!(light_file(encoding, &[[f32::NAN, f32::INFINITY, -1.0]], (1, 1)).is_ok());
        }
    }
}
