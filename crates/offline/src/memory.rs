//! How much memory it takes to read a picture back and to write it, so that one that does not fit can be refused before
//! it is drawn.
//!
//! The numbers are upper bounds of what was measured on pictures up to 3840 × 2160: of one picture, beyond what the
//! scene, the driver and the textures of the frame take.

use crate::Format;
use crate::exr_file::BAND_BYTES;
use manypass::Aov;

/// What is in memory of a band of an EXR file: the mapped rows, a copy without padding, the values, their planes, and
/// the blocks that are being compressed.
const BAND_COPIES: u64 = 5;

/// Values a pixel of an AOV.
fn component_count(aov: Aov) -> u64 {
    aov.info().channels.len() as u64
}

/// Bytes of the targets that AOVs are decoded from. They stay on the device while further samples are drawn, so that
/// the frame's own are made again.
pub fn kept_bytes(width: u32, height: u32, aovs: &[Aov]) -> u64 {
    let per_pixel = |bytes: u64, is_there: bool| if is_there { bytes } else { 0 };
    // Base colour, normal, material and depth; then emission, ids, motion and occlusion.
    let kept = per_pixel(16, !aovs.is_empty())
        + per_pixel(8, aovs.contains(&Aov::Emission))
        + per_pixel(8, aovs.contains(&Aov::ObjectId) || aovs.contains(&Aov::MaterialId))
        + per_pixel(8, aovs.contains(&Aov::Motion))
        + per_pixel(4, aovs.contains(&Aov::OcclusionScreen));
    pixels(width, height) * kept
}

/// Bytes that it takes to read a picture and its AOVs and to write them, at the moment that takes most. Where
/// `is_gathered`, as for standard output, the file is put together in memory.
pub fn delivery_bytes(format: Format, width: u32, height: u32, aovs: &[Aov], is_gathered: bool) -> u64 {
    if format == Format::Exr {
        let channels = 4 + aovs.iter().map(|aov| component_count(*aov)).sum::<u64>();
        let band = BAND_BYTES.min(16 * pixels(width, height));
        return BAND_COPIES * band + if is_gathered { 4 * channels * pixels(width, height) } else { 0 };
    }
    // The mapped buffer and its rows without padding; the values, with depth beside positions; 16 bits a value, twice.
    let aov_bytes = |aov: &Aov| {
        let read = if *aov == Aov::Radiance { 32 } else { 16 };
        let values = 4 * component_count(*aov);
        let depth = if *aov == Aov::Position { 12 } else { 0 };
        read + values + depth + values
    };
    // The mapped buffer, its rows, and what the encoder makes of them.
    let picture_bytes = match format {
        Format::Webp => 8 + 16,
        Format::Png | Format::Jpg | Format::Exr => 8 + 4,
    };
    pixels(width, height) * aovs.iter().map(aov_bytes).chain([picture_bytes]).max().unwrap_or(0)
}

fn pixels(width: u32, height: u32) -> u64 {
    u64::from(width) * u64::from(height)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variable_counts() {
        assert_eq!(kept_bytes(10, 10, &[]), 0);
        assert_eq!(kept_bytes(10, 10, &[Aov::Depth, Aov::Motion]), 100 * 24);
        assert_eq!(kept_bytes(10, 10, Aov::ALL), 4400);
        assert_eq!(delivery_bytes(Format::Png, 10, 10, &[], false), 1200);
        assert_eq!(delivery_bytes(Format::Png, 10, 10, Aov::ALL, false), 100 * 64);
        // A large EXR file takes a few bands, unless it has nowhere to go back in.
        assert_eq!(delivery_bytes(Format::Exr, 8192, 8192, Aov::ALL, false), 5 * BAND_BYTES);
        assert!(delivery_bytes(Format::Exr, 8192, 8192, Aov::ALL, true) > 31 * 4 * 8192 * 8192);
    }
}
