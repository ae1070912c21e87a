//! Pictures as bytes of PNG, JPEG and WebP files.

use crate::png_stream::compressed;
use image::{ExtendedColorType, ImageEncoder};

/// The kinds of file that pictures are written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8 bits, sRGB, with alpha.
    Png,
    /// 8 bits, sRGB, without alpha.
    Jpg,
    /// 8 bits, sRGB, with alpha, lossless.
    Webp,
    /// Scene-linear floats in layers.
    Exr,
}

impl Format {
    /// The format of a file-name extension (without its dot), in any case.
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpg),
            "webp" => Some(Self::Webp),
            "exr" => Some(Self::Exr),
            _ => None,
        }
    }

    /// The usual extension, without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpg => "jpg",
            Self::Webp => "webp",
            Self::Exr => "exr",
        }
    }
}

/// Why a picture could not be encoded.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    /// The number of values does not fit the size.
    #[error("a picture of {width}x{height} needs {expected} values, but there are {found}")]
    Length {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// How many values the size asks for.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// The encoder refused.
    #[error("cannot encode {format}: {reason}")]
    Encoder {
        /// The kind of file.
        format: &'static str,
        /// What the encoder said.
        reason: String,
    },
}

/// Fails unless `found` is `width · height · per_pixel`.
pub(crate) fn check_length(width: u32, height: u32, per_pixel: usize, found: usize) -> Result<(), EncodeError> {
    let expected = width as usize * height as usize * per_pixel;
    if found == expected { Ok(()) } else { Err(EncodeError::Length { width, height, expected, found }) }
}

fn failed(format: &'static str) -> impl Fn(&dyn std::fmt::Display) -> EncodeError {
    move |reason| EncodeError::Encoder { format, reason: reason.to_string() }
}

/// A PNG of 8-bit sRGB colour and unassociated alpha, marked as sRGB.
///
/// # Errors
/// If the number of bytes does not fit the size.
pub fn png_rgba8(width: u32, height: u32, rgba8: &[u8]) -> Result<Vec<u8>, EncodeError> {
    check_length(width, height, 4, rgba8.len())?;
    png_bytes((width, height), png::ColorType::Rgba, png::BitDepth::Eight, true, None, rgba8)
}

/// A PNG of `size` pixels, whose `depth` is whole bytes. `note` becomes a text chunk called `manypass`; it must be ASCII.
pub(crate) fn png_bytes(
    (width, height): (u32, u32),
    color: png::ColorType,
    depth: png::BitDepth,
    is_srgb: bool,
    note: Option<&str>,
    data: &[u8],
) -> Result<Vec<u8>, EncodeError> {
    let failed = failed("PNG");
    let texel_bytes = color.samples() * depth as usize / 8;
    check_length(width, height, texel_bytes, data.len())?;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if is_srgb {
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    }
    if let Some(note) = note {
        encoder.add_text_chunk("manypass".into(), note.into()).map_err(|error| failed(&error))?;
    }
    let mut writer = encoder.write_header().map_err(|error| failed(&error))?;
    let stream = compressed(data, width as usize * texel_bytes, texel_bytes).map_err(|error| failed(&error))?;
    // A chunk may have no more than a signed number says.
    for part in stream.chunks(1 << 30) {
        writer.write_chunk(png::chunk::IDAT, part).map_err(|error| failed(&error))?;
    }
    writer.finish().map_err(|error| failed(&error))?;
    Ok(bytes)
}

/// A JPEG of quality 92; alpha is left out.
///
/// # Errors
/// If the number of bytes does not fit the size, or a side is longer than 65535 pixels.
pub fn jpg(width: u32, height: u32, rgba8: &[u8]) -> Result<Vec<u8>, EncodeError> {
    check_length(width, height, 4, rgba8.len())?;
    let rgb: Vec<u8> = rgba8.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 92)
        .write_image(&rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| failed("JPEG")(&error))?;
    Ok(bytes)
}

/// A lossless WebP.
///
/// # Errors
/// If the number of bytes does not fit the size, or a side is longer than 16384 pixels.
pub fn webp(width: u32, height: u32, rgba8: &[u8]) -> Result<Vec<u8>, EncodeError> {
    check_length(width, height, 4, rgba8.len())?;
    let mut bytes = Vec::new();
    image::codecs::webp::WebPEncoder::new_lossless(&mut bytes)
        .write_image(rgba8, width, height, ExtendedColorType::Rgba8)
        .map_err(|error| failed("WebP")(&error))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: [u8; 16] = [255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 0, 9, 8, 7, 255];

    #[test]
    fn png_and_webp_give_back_every_byte() {
        for bytes in [png_rgba8(2, 2, &PIXELS), webp(2, 2, &PIXELS)] {
            let decoded = image::load_from_memory(&bytes.expect("encoded")).expect("decoded");
            assert_eq!(decoded.to_rgba8().as_raw().as_slice(), PIXELS);
        }
    }

    #[test]
    fn png_says_that_it_is_srgb() {
        let bytes = png_rgba8(2, 2, &PIXELS).expect("encoded");
        assert!(bytes.windows(4).any(|window| window == b"sRGB"));
    }

    #[test]
    fn jpg_is_near_and_has_no_alpha() {
        let pixels = [200, 100, 50, 0].repeat(64);
        let decoded = image::load_from_memory(&jpg(8, 8, &pixels).expect("encoded")).expect("decoded");
        assert_eq!(decoded.color().channel_count(), 3);
        let pixel = decoded.to_rgb8().get_pixel(3, 3).0;
        assert!(pixel.iter().zip([200u8, 100, 50]).all(|(a, b)| a.abs_diff(b) <= 4), "{pixel:?}");
    }

    #[test]
    fn wrong_lengths_are_errors() {
        assert!(matches!(png_rgba8(2, 3, &PIXELS), Err(EncodeError::Length { expected: 24, found: 16, .. })));
        assert!(jpg(1, 1, &PIXELS).is_err() && webp(1, 1, &PIXELS).is_err());
    }
}
