//! How much memory a picture takes in the process, so that one that does not fit can be refused before it is drawn.
//!
//! The numbers are upper bounds of what was measured on pictures up to 3840 × 2160: of one picture, beyond what the
//! scene, the driver and the textures of the frame take.

use crate::Format;
use manypass::Aov;

/// Values a pixel of an AOV.
fn component_count(aov: Aov) -> u64 {
    match aov {
        Aov::BaseColor | Aov::Normal | Aov::NormalView | Aov::Position | Aov::Emission => 3,
        Aov::Motion => 2,
        Aov::Radiance => 4,
        Aov::Occlusion | Aov::Depth | Aov::Metallic | Aov::Roughness | Aov::ObjectId | Aov::MaterialId => 1,
    }
}

/// Bytes of [`crate::Picture`]: display colours, linear radiance if it is wanted, 32 bits a value of an AOV.
pub fn picture_bytes(width: u32, height: u32, aovs: &[Aov], want_radiance: bool) -> u64 {
    let values: u64 = aovs.iter().map(|aov| component_count(*aov)).sum();
    pixels(width, height) * (4 + 4 * values + if want_radiance { 16 } else { 0 })
}

/// Bytes that reading the picture back takes beside the picture: the targets that AOVs are decoded from, which stay,
/// and a copy on its way, which does not.
pub fn readback_bytes(width: u32, height: u32, aovs: &[Aov], want_radiance: bool) -> (u64, u64) {
    let per_pixel = |bytes: u64, is_there: bool| if is_there { bytes } else { 0 };
    // Base colour, normal, material and depth; then emission, ids and motion.
    let kept = per_pixel(16, !aovs.is_empty())
        + per_pixel(8, aovs.contains(&Aov::Emission))
        + per_pixel(8, aovs.contains(&Aov::ObjectId) || aovs.contains(&Aov::MaterialId))
        + per_pixel(8, aovs.contains(&Aov::Motion));
    // The mapped buffer and its rows without padding.
    let passing = if want_radiance || aovs.contains(&Aov::Radiance) { 32 } else { 8 };
    (pixels(width, height) * kept, pixels(width, height) * passing)
}

/// Bytes that the encoder of a picture takes, with those of the finished file, if nothing compresses well.
pub fn encoder_bytes(format: Format, width: u32, height: u32, aovs: &[Aov]) -> u64 {
    let channels = 4 + aovs.iter().map(|aov| component_count(*aov)).sum::<u64>();
    let per_pixel = match format {
        // The file; then one AOV at a time as eight-bit colour, and its file.
        Format::Png => 4 + if aovs.is_empty() { 0 } else { 8 },
        Format::Jpg => 4,
        // The file, and the encoder's tokens and tables.
        Format::Webp => 12,
        // A plane of 32 bits for every channel, and the file.
        Format::Exr => 4 * channels + 4 * channels,
    };
    pixels(width, height) * per_pixel
}

fn pixels(width: u32, height: u32) -> u64 {
    u64::from(width) * u64::from(height)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variable_counts() {
        assert_eq!(picture_bytes(10, 10, &[], false), 400);
        assert_eq!(picture_bytes(10, 10, &[Aov::Depth, Aov::Normal], true), 100 * (4 + 16 + 16));
        assert_eq!(readback_bytes(10, 10, &[], false), (0, 800));
        assert_eq!(readback_bytes(10, 10, Aov::ALL, true), (4000, 3200));
        assert_eq!(encoder_bytes(Format::Exr, 10, 10, Aov::ALL), 100 * 8 * 31);
        assert!(encoder_bytes(Format::Png, 10, 10, Aov::ALL) < encoder_bytes(Format::Exr, 10, 10, Aov::ALL));
    }
}
