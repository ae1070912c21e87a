//! Pictures in Radiance files (.hdr).
//!
//! Source: Ward, "Real Pixels", Graphics Gems II, 1991, and the file format reference of Radiance. What a header calls
//! EXPOSURE and COLORCORR was multiplied into the texels, every line of them, and is divided out of them again.

use super::map::{CheckSize, UncheckedPicture};
use image::codecs::hdr::{HdrDecoder, HdrMetadata};
use image::{ImageDecoder, ImageError};
use std::io::{ErrorKind, Read};

/// How files begin; the decoder knows the first alone.
const MAGIC: [&[u8]; 2] = [b"#?RADIANCE", b"#?RGBE"];

pub(super) fn is_radiance(bytes: &[u8]) -> bool {
    MAGIC.iter().any(|magic| bytes.starts_with(magic))
}

/// Width and height of a file, from its header.
pub(super) fn size(bytes: &[u8]) -> Result<(u32, u32), String> {
    decoder(bytes).map(|decoder| decoder.dimensions())
}

pub(super) fn decode_radiance(bytes: &[u8], check_size: CheckSize) -> Result<UncheckedPicture, String> {
    let decoder = decoder(bytes)?;
    let (width, height) = decoder.dimensions();
    check_size(width, height)?;
    let written = written_factors(&decoder.metadata())?;
    let mut rgb = vec![[0.0f32; 3]; width as usize * height as usize];
    decoder.read_image(bytemuck::cast_slice_mut(&mut rgb)).map_err(|error| match error {
        ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => format!(
            "the file ends early, is it cut off? Its header says {width}x{height} pixels, and its {} bytes do not hold them",
            bytes.len()
        ),
        error => error.to_string(),
    })?;
    if written != [1.0; 3] {
        for texel in &mut rgb {
            for (value, factor) in texel.iter_mut().zip(written) {
                *value /= factor;
            }
        }
    }
    Ok(UncheckedPicture { width, height, rgb })
}

/// A decoder that has read the header.
fn decoder(bytes: &[u8]) -> Result<HdrDecoder<impl Read>, String> {
    let rest = MAGIC.iter().find_map(|magic| bytes.strip_prefix(*magic)).unwrap_or_default();
    let end = rest.windows(2).position(|pair| pair == b"\n\n").and_then(|end| rest.get(end + 2..));
    if !end.is_some_and(|end| end.contains(&b'\n')) {
        let expected = "an empty line, and after it the size, such as -Y 512 +X 1024";
        return Err(format!("the file ends early, is it cut off? Its header does not end; expected {expected}"));
    }
    HdrDecoder::new(MAGIC[0].chain(rest)).map_err(|error| error.to_string())
}

/// By how much red, green and blue were multiplied when the texels were written.
fn written_factors(header: &HdrMetadata) -> Result<[f32; 3], String> {
    let exposure = header.exposure.unwrap_or(1.0);
    let (r, g, b) = header.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let factors = [r, g, b].map(|correction| exposure * correction);
    let is_usable = |value: &f32| value.is_normal() && *value > 0.0;
    let refused = |what: &str, value: f32| {
        format!(
            "its header multiplies texels by {what} {value}, which cannot be divided out of them; \
             expected numbers above 0, or no such line"
        )
    };
    let lines = header.custom_attributes.iter().filter(|(name, _)| name == "EXPOSURE" || name == "COLORCORR");
    for (name, line) in lines {
        let mut values = line.split_whitespace().filter_map(|value| value.parse().ok());
        if let Some(value) = values.find(|value| !is_usable(value)) {
            return Err(refused(name, value));
        }
    }
    // Numbers that are each good may have a product that is none.
    if let Some(value) = factors.iter().find(|value| !is_usable(value)) {
        return Err(refused("the product of EXPOSURE and COLORCORR,", *value));
    }
    Ok(factors)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    /// Two texels of 2, 1 and 0.5 under a header with `lines`.
    fn file(lines: &str) -> Vec<u8> {
        let mut bytes = format!("#?RADIANCE\n{lines}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n").into_bytes();
        bytes.extend([128, 64, 32, 130].repeat(2));
        bytes
    }

    fn read(lines: &str) -> Result<Vec<[f32; 3]>, String> {
        decode_radiance(&file(lines), |_, _| Ok(())).map(|decoded| decoded.rgb)
    }

    #[test]
    fn exposures_and_corrections_are_divided_out() {
        assert_eq!(read("").unwrap(), [[2.0, 1.0, 0.5]; 2]);
        assert_eq!(read("EXPOSURE=2\n").unwrap(), [[1.0, 0.5, 0.25]; 2]);
        assert_eq!(read("EXPOSURE= 2\nEXPOSURE=0.25\n").unwrap(), [[4.0, 2.0, 1.0]; 2]);
        let both = "COLORCORR= 2 1 0.5\nEXPOSURE=2\nCOLORCORR= 1 1 0.25\n";
        assert_eq!(read(both).unwrap(), [[0.5, 0.5, 2.0]; 2]);
    }

    #[test]
    fn factors_that_nothing_can_be_divided_by_are_refused() {
        for lines in ["EXPOSURE=0\n", "EXPOSURE=-1\n", "EXPOSURE=nan\n", "EXPOSURE=inf\n", "COLORCORR=1 0 1\n"] {
            let message = read(lines).unwrap_err();
            let name = lines.split('=').next().unwrap();
            assert!(message.contains(name) && message.contains("expected numbers above 0"), "{lines}: {message}");
        }
        // Neither minus by minus nor what becomes too small or too large.
        for lines in
            ["EXPOSURE=-2\nEXPOSURE=-2\n", "EXPOSURE=1e-30\nEXPOSURE=1e-30\n", "EXPOSURE=1e30\nCOLORCORR=1e30 1 1\n"]
        {
            assert!(read(lines).unwrap_err().contains("EXPOSURE"), "{lines}");
        }
        assert!(read("EXPOSURE=bright\n").unwrap_err().contains("EXPOSURE"));
    }

    #[test]
    fn what_is_cut_off_says_so() {
        let whole = file("");
        for length in 0..whole.len() {
            let cut = whole.get(..length).unwrap();
            let message = decode_radiance(cut, |_, _| Ok(())).err().unwrap();
            assert!(message.contains("the file ends early"), "{length}: {message}");
            assert!(length < whole.len() - 8 || message.contains("2x1 pixels"), "{length}: {message}");
        }
    }

    #[test]
    fn both_beginnings_are_known() {
        let other = [b"#?RGBE", file("").strip_prefix(MAGIC[0]).unwrap()].concat();
        assert!(is_radiance(&other));
        assert_eq!((size(&other), size(&file(""))), (Ok((2, 1)), Ok((2, 1))));
    }
}
