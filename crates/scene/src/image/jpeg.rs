//! JPEG files in colour, whose texels come out of the decoder as the device takes them: `image` would make three bytes a
//! texel, and a copy of them with four.

use std::io::Cursor;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// What a JPEG file begins with.
const START: [u8; 3] = [0xff, 0xd8, 0xff];

/// The texels of a file of `size`, red, green, blue and 255. None of a file that is no JPEG in colour, or is broken,
/// which `image` has better words for.
pub(super) fn decode((width, height): (u32, u32), bytes: &[u8]) -> Option<Vec<u8>> {
    if !bytes.starts_with(&START) {
        return None;
    }
    let options = DecoderOptions::default().set_strict_mode(false).jpeg_set_out_colorspace(ColorSpace::RGBA);
    let options = options.set_max_width(width as usize).set_max_height(height as usize);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    decoder.decode_headers().ok()?;
    if decoder.input_colorspace() != Some(ColorSpace::YCbCr) {
        return None;
    }
    let texels = decoder.decode().ok()?;
    (texels.len() as u64 == u64::from(width) * u64::from(height) * 4).then_some(texels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ExtendedColorType, ImageEncoder};

    /// A file of 33 × 17 pixels.
    fn encoded(color: ExtendedColorType, channels: u32) -> Vec<u8> {
        let pixels: Vec<u8> = (0..33 * 17 * channels).map(|i| (i * 37 % 251) as u8).collect();
        let mut bytes = Vec::new();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 90);
        encoder.write_image(&pixels, 33, 17, color).expect("encoded");
        bytes
    }

    #[test]
    fn texels_are_those_that_image_decodes() {
        let bytes = encoded(ExtendedColorType::Rgb8, 3);
        let expected = image::load_from_memory(&bytes).expect("decoded").into_rgba8().into_raw();
        assert_eq!(decode((33, 17), &bytes), Some(expected));
    }

    #[test]
    fn what_is_not_colour_or_is_broken_is_left_to_image() {
        assert_eq!(decode((33, 17), &encoded(ExtendedColorType::L8, 1)), None);
        let bytes = encoded(ExtendedColorType::Rgb8, 3);
        assert_eq!(decode((33, 18), &bytes), None);
        assert_eq!(decode((32, 17), &bytes), None);
        assert_eq!(decode((33, 17), &bytes[..40]), None);
        assert_eq!(decode((33, 17), b"\x89PNG\r\n"), None);
    }
}
