//! Images of light that was baked: Radiance (.hdr) and OpenEXR (.exr) files, whose values may exceed 1.

use super::texels::{HalfFloats, MAX_DECODE_BYTES, MAX_IMAGE_SIZE_TEXELS};
use super::{Image, ImageError, ImageSource};
use crate::environment::{RADIANCE_MAX, cut, decode_light, holds_light};
use half::f16;

/// Bytes of a texel while it decodes: three floats beside four half floats.
const DECODE_BYTES: u64 = 20;

fn check_size(width: u32, height: u32) -> Result<(), String> {
    if width == 0 || height == 0 || width.max(height) > MAX_IMAGE_SIZE_TEXELS {
        return Err(format!("it has {width} by {height} texels"));
    }
    if u64::from(width) * u64::from(height) * DECODE_BYTES > MAX_DECODE_BYTES {
        return Err(format!("its {width} by {height} texels take more than 512 MiB"));
    }
    Ok(())
}

impl Image {
    /// Whether it is a Radiance or an OpenEXR file, whose values are light; [`Self::decode_light`] reads them.
    pub fn holds_light(&self) -> bool {
        matches!(&self.source, ImageSource::Encoded(bytes) if holds_light(bytes))
    }

    /// Light that is written as colours which alpha multiplies, from 0 to 1. Takes at most 512 MiB while it decodes.
    ///
    /// # Errors
    /// It cannot be decoded, or is too large.
    pub fn decode_rgbm(&self) -> Result<HalfFloats, ImageError> {
        let (width, height) = self.dimensions()?;
        check_size(width, height).map_err(|message| self.error(message))?;
        let pixels = self.decode()?;
        let half = |texel: &[u8]| {
            let value = |part: usize| {
                let steps =
                    f32::from(texel.get(part).copied().unwrap_or(0)) * f32::from(texel.get(3).copied().unwrap_or(0));
                f16::from_f32(steps / (255.0 * 255.0))
            };
            [value(0), value(1), value(2), f16::ONE]
        };
        let texels = pixels.data.chunks_exact(4).map(half).collect();
        Ok(HalfFloats { width, height, texels, cut_count: 0 })
    }

    /// The texels of a Radiance or an OpenEXR file. Takes at most 512 MiB while it decodes.
    ///
    /// # Errors
    /// It is another file, a broken one, or too large.
    pub fn decode_light(&self) -> Result<HalfFloats, ImageError> {
        let ImageSource::Encoded(bytes) = &self.source else { return Err(self.error("it is not a file of light")) };
        if !holds_light(bytes) {
            return Err(self.error("it is neither Radiance (.hdr) nor OpenEXR (.exr)"));
        }
        let decoded = decode_light(bytes, check_size).map_err(|message| self.error(message))?;
        let mut cut_count = 0;
        let mut half = |value: f32| {
            let (value, is_cut) = cut(value);
            cut_count += u64::from(is_cut || value > RADIANCE_MAX);
            f16::from_f32(value.min(RADIANCE_MAX))
        };
        let texels = decoded.rgb.iter().map(|[r, g, b]| [half(*r), half(*g), half(*b), f16::ONE]).collect();
        Ok(HalfFloats { width: decoded.width, height: decoded.height, texels, cut_count })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    fn image(bytes: Vec<u8>) -> Image {
        Image { name: "baked".into(), source: ImageSource::Encoded(bytes.into()) }
    }

    fn radiance_file(width: usize, height: usize, value: f32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let texels = vec![image::Rgb([value, 1.0, 0.5]); width * height];
        image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&texels, width, height).unwrap();
        bytes
    }

    fn exr_file(width: usize, height: usize, value: f32) -> Vec<u8> {
        use exr::prelude::{SpecificChannels, WritableImage};
        let mut bytes = std::io::Cursor::new(Vec::new());
        let channels = SpecificChannels::rgb(|_: exr::prelude::Vec2<usize>| (value, 1.0, 0.5));
        exr::prelude::Image::from_channels((width, height), channels).write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn files_of_light_are_read_as_half_floats() {
        // No picture of an environment: that would be twice as wide as high.
        for bytes in [radiance_file(5, 7, 24.0), exr_file(5, 7, 24.0)] {
            let image = image(bytes);
            assert!(image.holds_light());
            assert_eq!(image.dimensions().unwrap(), (5, 7));
            let light = image.decode_light().unwrap();
            assert_eq!((light.width, light.height, light.texels.len(), light.cut_count), (5, 7, 35, 0));
            assert!(light.texels.iter().all(|texel| texel.map(f16::to_f32) == [24.0, 1.0, 0.5, 1.0]));
        }
    }

    #[test]
    fn what_is_no_light_is_cut_and_counted() {
        let cut = |value| {
            let light = image(exr_file(2, 1, value)).decode_light().unwrap();
            (light.texels[0][0].to_f32(), light.cut_count)
        };
        assert_eq!((cut(f32::NAN), cut(-1.0)), ((0.0, 2), (0.0, 2)));
        for bright in [1e9, f32::INFINITY] {
            let (kept, count) = cut(bright);
            assert!((kept - RADIANCE_MAX).abs() < 32.0 && count == 2, "{bright}: {kept} {count}");
        }
    }

    #[test]
    fn broken_and_huge_files_are_refused() {
        for whole in [radiance_file(9, 5, 3.0), exr_file(9, 5, 3.0)] {
            for length in 0..whole.len() {
                assert!(image(whole[..length].to_vec()).decode_light().is_err(), "{length} of {} bytes", whole.len());
            }
        }
        let huge = image(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16000 +X 16000\n".to_vec());
        let message = huge.decode_light().unwrap_err().to_string();
        assert!(message.contains("16000 by 16000 texels take more than 512 MiB"), "{message}");
        let wide = image(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 40000\n".to_vec());
        assert!(wide.dimensions().unwrap_err().to_string().contains("40000 by 1 texels"));
        assert!(image(b"\x89PNG".to_vec()).decode_light().unwrap_err().to_string().contains("neither Radiance"));
    }
}
