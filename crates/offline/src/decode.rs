//! Pictures from the bytes of PNG, JPEG, WebP and EXR files, to compare them.

use exr::prelude::{ReadChannels, ReadLayers, read};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use manypass_scene::environment::{exr_fault, missing_channels};
use std::io::Cursor;

/// The largest width and height in pixels.
pub const MAX_SIDE_PX: usize = 32_768;
/// The most pixels: 8192 by 8192, which take 1 GiB.
pub const MAX_PIXELS: usize = 1 << 26;

/// What the numbers of a picture stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// sRGB values from 0 to 1 for a display, beside their alpha.
    Display,
    /// Linear radiance, already multiplied by alpha, as EXR files have it.
    Scene,
}

/// A picture that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedPicture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// What the numbers stand for.
    pub light: Light,
    /// Red, green, blue and alpha of `width · height` pixels, rows from the top. Alpha is 1 where the file has none.
    pub rgba: Vec<[f32; 4]>,
}

/// Why a picture cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// The bytes begin like no file that is read.
    #[error("it is neither PNG, JPEG, WebP nor EXR")]
    Unknown,
    /// The picture is larger than [`MAX_SIDE_PX`] or [`MAX_PIXELS`] allow.
    #[error("its {width}x{height} pixels are more than can be read ({MAX_SIDE_PX} a side, {MAX_PIXELS} in all)")]
    TooLarge {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
    },
    /// The decoder refused.
    #[error("it cannot be read as {format}: {reason}")]
    Decoder {
        /// The kind of file.
        format: &'static str,
        /// What the decoder said.
        reason: String,
    },
}

/// How an EXR file begins.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Whether a file that begins with `bytes`, 16 of them or all that there are, is of a kind that is read.
pub fn is_known(bytes: &[u8]) -> bool {
    bytes.starts_with(&EXR_MAGIC) || display_format(bytes).is_some()
}

/// The kind of a picture for a display, and its name.
fn display_format(bytes: &[u8]) -> Option<(ImageFormat, &'static str)> {
    let format = image::guess_format(bytes).ok()?;
    let names = [(ImageFormat::Png, "PNG"), (ImageFormat::Jpeg, "JPEG"), (ImageFormat::WebP, "WebP")];
    names.into_iter().find(|(known, _)| *known == format)
}

/// Reads a picture; its bytes say which kind it is. Of an EXR file the first part with channels R, G and B (and A) is
/// read. Colour profiles are not: numbers are taken as sRGB, or as linear with the primaries of sRGB.
///
/// # Errors
/// If the kind is not known, the picture is too large, or its bytes are broken.
pub fn decode(bytes: &[u8]) -> Result<DecodedPicture, DecodeError> {
    if bytes.starts_with(&EXR_MAGIC) {
        return decode_exr(bytes);
    }
    let (format, name) = display_format(bytes).ok_or(DecodeError::Unknown)?;
    let failed = |error: image::ImageError| DecodeError::Decoder { format: name, reason: error.to_string() };
    let reader = || {
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = Limits::default();
        // A decoder has at most 16 bits of four channels, and as much again to work with.
        limits.max_alloc = Some(MAX_PIXELS as u64 * 16);
        reader.limits(limits);
        reader
    };
    let (width, height) = reader().into_dimensions().map_err(failed)?;
    check_size(width as usize, height as usize)?;
    let rgba = match reader().decode().map_err(failed)? {
        DynamicImage::ImageRgb8(image) => {
            let value = |byte: u8| f32::from(byte) / 255.0;
            image.pixels().map(|pixel| [value(pixel[0]), value(pixel[1]), value(pixel[2]), 1.0]).collect()
        }
        other => other.into_rgba32f().pixels().map(|pixel| pixel.0).collect(),
    };
    Ok(DecodedPicture { width: width as usize, height: height as usize, light: Light::Display, rgba })
}

fn check_size(width: usize, height: usize) -> Result<(), DecodeError> {
    let fits = width.max(height) <= MAX_SIDE_PX && width * height <= MAX_PIXELS;
    if fits { Ok(()) } else { Err(DecodeError::TooLarge { width, height }) }
}

fn decode_exr(bytes: &[u8]) -> Result<DecodedPicture, DecodeError> {
    let failed = |error: exr::error::Error| DecodeError::Decoder { format: "EXR", reason: exr_fault(&error) };
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(failed)?;
    meta.headers.iter().try_for_each(|header| check_size(header.layer_size.0, header.layer_size.1))?;
    if let Some(reason) = missing_channels(&meta.headers) {
        return Err(DecodeError::Decoder { format: "EXR", reason });
    }
    let reader = read().no_deep_data().largest_resolution_level().rgba_channels(
        |size, _| (size.0, vec![[0.0, 0.0, 0.0, 1.0]; size.0 * size.1]),
        |(width, pixels), position, (r, g, b, a): (f32, f32, f32, f32)| {
            if let Some(pixel) = pixels.get_mut(position.1 * *width + position.0) {
                *pixel = [r, g, b, a];
            }
        },
    );
    let image = reader.first_valid_layer().all_attributes().non_parallel().from_buffered(Cursor::new(bytes));
    let layer = image.map_err(failed)?.layer_data;
    let (width, height) = (layer.size.0, layer.size.1);
    Ok(DecodedPicture { width, height, light: Light::Scene, rgba: layer.channel_data.pixels.1 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode;
    use exr::prelude::{SpecificChannels, WritableImage};

    #[test]
    fn what_was_encoded_is_decoded() {
        let rgba8: Vec<u8> = (0..5 * 3).flat_map(|i: u8| [i * 17, 255 - i, 40 + i, 200 + i]).collect();
        for bytes in [encode::png_rgba8(5, 3, &rgba8), encode::webp(5, 3, &rgba8)] {
            let picture = decode(&bytes.expect("encoded")).expect("decoded");
            assert_eq!((picture.width, picture.height, picture.light), (5, 3, Light::Display));
            let bytes: Vec<u8> = picture.rgba.iter().flatten().map(|value| (value * 255.0).round() as u8).collect();
            assert_eq!(bytes, rgba8);
        }
        let picture = decode(&encode::jpg(5, 3, &[128; 60]).expect("encoded")).expect("decoded");
        assert!(picture.rgba.iter().all(|[r, .., a]| (r - 128.0 / 255.0).abs() < 0.02 && *a == 1.0));
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        assert_eq!(decode(b""), Err(DecodeError::Unknown));
        assert_eq!(decode(b"GIF89a.............."), Err(DecodeError::Unknown));
        let png = encode::png_rgba8(2, 2, &[9; 16]).expect("encoded");
        assert!(matches!(decode(&png[..png.len() / 2]), Err(DecodeError::Decoder { format: "PNG", .. })));
        assert!(matches!(decode(&[0x76, 0x2f, 0x31, 0x01, 2]), Err(DecodeError::Decoder { format: "EXR", .. })));
        let grey = SpecificChannels::build().with_channel("Y").with_pixel_fn(|_: exr::prelude::Vec2<usize>| (0.5f32,));
        let mut bytes = Cursor::new(Vec::new());
        exr::prelude::Image::from_channels((2, 2), grey).write().to_buffered(&mut bytes).expect("written");
        let refused = decode(bytes.get_ref()).expect_err("one channel").to_string();
        assert!(refused.contains("channels R, G and B in one part, and it has Y"), "{refused}");
        assert!(
            check_size(MAX_SIDE_PX + 1, 1).is_err()
                && check_size(8193, 8193).is_err()
                && check_size(8192, 8192).is_ok()
        );
    }
}
