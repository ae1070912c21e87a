//! Pictures of the light that comes from all directions: Radiance (.hdr) and OpenEXR (.exr) files, equirectangular; and
//! the six faces of a cube, in a folder or a KTX2 container (.ktx2).
//!
//! Values are linear radiance with the primaries of Rec. 709. Texels are kept as half floats, which is what devices
//! take.

mod brdf;
mod cube;
#[cfg(not(feature = "exr"))]
#[path = "environment/exr_absent.rs"]
mod exr_file;
#[cfg(feature = "exr")]
mod exr_file;
mod ktx2;
mod map;
mod parts;
mod picture;
mod radiance;
pub mod suns;

pub use brdf::BrdfTable;
pub use cube::{CUBE_FACES, FACE_SIDE_MAX, face_files, files_of};
#[cfg(feature = "exr")]
pub use exr_file::{exr_fault, missing_channels};
pub(crate) use map::cut;
pub use map::{
    EnvironmentError, EnvironmentLayout, EnvironmentLight, EnvironmentMap, KEPT_WIDTH_MAX, LightPicture,
    PrefilteredEnvironment, RADIANCE_MAX, WIDTH_MAX, equirectangular_direction, equirectangular_direction_within,
};
pub(crate) use parts::LEVEL;
pub use parts::prefiltered_files;
pub(crate) use picture::{decode_light, holds_light, light_size};

use crate::ktx2::is_ktx2;
use exr_file::decode_exr;
use picture::is_exr;
use radiance::{decode_radiance, is_radiance};

impl EnvironmentMap {
    /// Reads the bytes of a file; `name` appears in messages.
    ///
    /// # Errors
    /// They are of another kind, broken, or of a picture that is neither an equirectangular one (twice as wide as high)
    /// nor a cube map, or too large.
    pub fn decode(name: &str, bytes: &[u8]) -> Result<Self, EnvironmentError> {
        let failed = |message: String| EnvironmentError { name: name.into(), message };
        if is_ktx2(bytes) {
            return ktx2::decode(name, bytes);
        }
        let decoded = if is_exr(bytes) {
            decode_exr(bytes, check_size)
        } else if is_radiance(bytes) {
            decode_radiance(bytes, check_size)
        } else {
            Err("it is neither Radiance (.hdr) nor OpenEXR (.exr) nor a cube map in KTX2 (.ktx2)".into())
        };
        Ok(Self::from_decoded(name, &decoded.map_err(failed)?, KEPT_WIDTH_MAX))
    }
}

fn check_size(width: u32, height: u32) -> Result<(), String> {
    if width == 0 || height == 0 || width > WIDTH_MAX || height > WIDTH_MAX / 2 {
        return Err(format!("its {width}x{height} pixels cannot be read, at most {WIDTH_MAX}x{}", WIDTH_MAX / 2));
    }
    if width != 2 * height && (width, height) != (1, 1) {
        return Err(format!("an equirectangular picture is twice as wide as high, and it has {width}x{height} pixels"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::map::UncheckedPicture;
    use super::*;
    use exr::prelude::write_rgb_file;
    use glam::Vec3;

    fn radiance_file(width: u32, height: u32, texels: &[[f32; 3]]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let texels: Vec<_> = texels.iter().map(|rgb| image::Rgb(*rgb)).collect();
        let encoder = image::codecs::hdr::HdrEncoder::new(&mut bytes);
        encoder.encode(&texels, width as usize, height as usize).unwrap();
        bytes
    }

    fn floats(map: &EnvironmentMap) -> Vec<[f32; 3]> {
        map.texels.iter().map(|[r, g, b, _]| [r, g, b].map(|value| value.to_f32())).collect()
    }

    #[test]
    fn what_was_written_is_read() {
        let texels: Vec<[f32; 3]> = (0..32u8).map(|i| [f32::from(i) * 8.0, 1.0, 0.5]).collect();
        let map = EnvironmentMap::decode("a.hdr", &radiance_file(8, 4, &texels)).unwrap();
        assert_eq!((map.width, map.height, map.notes.len()), (8, 4, 0));
        assert!(floats(&map).iter().zip(&texels).all(|(a, b)| (a[0] - b[0]).abs() <= b[0] / 100.0 + 0.01));
        let folder = std::env::temp_dir().join(format!("manypass_environment_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.exr");
        let value = |x: usize, y: usize| texels[y * 8 + x];
        write_rgb_file(&path, 8, 4, |x, y| value(x, y).into()).unwrap();
        let map = EnvironmentMap::decode("a.exr", &std::fs::read(&path).unwrap()).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(floats(&map), texels);
    }

    #[test]
    fn what_is_no_radiance_is_cut_and_noted() {
        let rgb = vec![[f32::NAN, f32::INFINITY, -1.0], [1e9, 0.0, 3.0]];
        let map = EnvironmentMap::from_decoded("a", &UncheckedPicture { width: 2, height: 1, rgb }, 4096);
        let [first, second] = floats(&map)[..] else { panic!("two texels") };
        assert!(first[0] == 0.0 && first[2] == 0.0 && (first[1] - RADIANCE_MAX).abs() < 32.0, "{first:?}");
        assert!((second[0] - RADIANCE_MAX).abs() < 32.0 && second[1..] == [0.0, 3.0], "{second:?}");
        assert!(map.notes[0].contains("3 values"), "{:?}", map.notes);
        // What texels cannot hold is not lost.
        let [(1, beyond)] = map.peaks[..] else { panic!("{:?}", map.peaks) };
        assert!((beyond.x / (1e9 - RADIANCE_MAX) - 1.0).abs() < 1e-3 && (beyond.y, beyond.z) == (0.0, 0.0), "{beyond}");
    }

    #[test]
    fn wide_pictures_are_made_smaller() {
        let rgb = (0..32u8).map(|i| [f32::from(i % 8), 0.0, 0.0]).collect();
        let map = EnvironmentMap::from_decoded("a", &UncheckedPicture { width: 8, height: 4, rgb }, 4);
        assert_eq!((map.width, map.height), (4, 2));
        assert_eq!(floats(&map)[..4].iter().map(|texel| texel[0]).collect::<Vec<_>>(), [0.5, 2.5, 4.5, 6.5]);
        assert!(map.notes[0].contains("8x4 is made smaller, 4x2"), "{:?}", map.notes);
    }

    #[test]
    fn every_column_and_row_counts_once_where_the_factor_leaves_a_remainder() {
        // Thirds of 10 by 5: 3 by 1. Red is the column, green the row, blue 7 in the last column alone.
        let texel = |i: u8| [f32::from(i % 10), f32::from(i / 10), if i % 10 == 9 { 7.0 } else { 0.0 }];
        let map = EnvironmentMap::from_decoded(
            "a",
            &UncheckedPicture { width: 10, height: 5, rgb: (0..50).map(texel).collect() },
            4,
        );
        assert_eq!((map.width, map.height), (3, 1));
        // A texel covers three columns and a third: (0 + 1 + 2 + 3 / 3) / (10 / 3).
        let expected = [[1.2, 2.0, 0.0], [4.5, 2.0, 0.0], [7.8, 2.0, 2.1]];
        for (found, expected) in floats(&map).iter().zip(expected) {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-3 * b), "{found:?} {expected:?}");
        }
        let mean: Vec3 = floats(&map).into_iter().map(Vec3::from).sum::<Vec3>() / 3.0;
        assert!((mean - Vec3::new(4.5, 2.0, 0.7)).abs().max_element() < 5e-3, "{mean}");

        // A column that lies in two texels is one value.
        let mut rgb = vec![[1.0; 3]; 50];
        rgb[3] = [1.0, f32::NAN, 1.0];
        let map = EnvironmentMap::from_decoded("a", &UncheckedPicture { width: 10, height: 5, rgb }, 4);
        assert!(map.notes[1].contains(": 1 values"), "{:?}", map.notes);
    }

    #[test]
    fn what_is_no_environment_is_refused() {
        let refused = |bytes: &[u8]| EnvironmentMap::decode("a.hdr", bytes).unwrap_err().to_string();
        assert!(refused(b"").contains("neither Radiance"));
        assert!(refused(b"\x89PNG").contains("neither Radiance"));
        assert!(refused(&radiance_file(4, 4, &[[1.0; 3]; 16])).contains("twice as wide as high, and it has 4x4"));
        let whole = radiance_file(8, 4, &[[1.0; 3]; 32]);
        for length in 0..whole.len() {
            assert!(EnvironmentMap::decode("a.hdr", &whole[..length]).is_err(), "{length} bytes");
        }
        assert!(EnvironmentMap::decode("a.hdr", &radiance_file(1, 1, &[[2.0; 3]])).is_ok());
        let huge = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 20000 +X 40000\n";
        assert!(refused(huge).contains("40000x20000"), "{}", refused(huge));
        assert!(refused(&[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]).starts_with("environment \"a.hdr\""));
    }
}
