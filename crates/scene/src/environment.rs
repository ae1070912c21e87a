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
mod parts;
mod radiance;
pub mod suns;

pub use brdf::BrdfTable;
pub use cube::{CUBE_FACES, FACE_SIDE_MAX, face_files, files_of};
#[cfg(feature = "exr")]
pub use exr_file::{exr_fault, missing_channels};
pub(crate) use parts::LEVEL;
pub use parts::{LightPicture, PrefilteredEnvironment, prefiltered_files};

use crate::ktx2::is_ktx2;
use exr_file::decode_exr;
use glam::Vec3;
use half::f16;
use radiance::{decode_radiance, is_radiance};

/// The widest picture that is kept: 4096 by 2048, 64 MiB. A wider one is made smaller by whole factors.
pub const KEPT_WIDTH_MAX: u32 = 4096;
/// The widest picture that is read, which takes 1.5 GiB while it is decoded.
pub const WIDTH_MAX: u32 = 16_384;
/// Radiance of texels ends here: half floats end at 65,504.
pub const RADIANCE_MAX: f32 = 65_000.0;
/// Radiance beyond this is cut, wherever it is kept.
const PEAK_MAX: f32 = 1e10;
/// The most texels of which more than [`RADIANCE_MAX`] is kept: a sun has few.
const PEAKS_MAX: usize = 1 << 16;

/// The mapping of directions to texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnvironmentLayout {
    /// All directions in one picture: u = 0.5 + atan2(z, x) / 2π, v = acos(y) / π.
    Equirectangular,
}

/// A light that belongs to an environment but is not in its texels. It is parallel, and casts shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentLight {
    /// Where it is seen, of length 1.
    pub direction: Vec3,
    /// What a plane across the direction gets of it, linear Rec. 709: radiance of its source times the source's solid
    /// angle.
    pub irradiance: Vec3,
    /// The tangent of half the angle that its source takes in the sky, for the width of penumbrae; 0 is a point.
    pub half_angle_tan: f32,
}

/// An environment map: light from all directions.
#[derive(Clone, PartialEq)]
pub struct EnvironmentMap {
    /// The file, for messages.
    pub name: String,
    /// How directions lie in the texels.
    pub layout: EnvironmentLayout,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Red, green, blue, 1: rows from the top; finite, from 0 to [`RADIANCE_MAX`].
    pub texels: Vec<[f16; 4]>,
    /// What texels, by their index, have beyond [`RADIANCE_MAX`]: the middle of a sun.
    pub peaks: Vec<(u32, Vec3)>,
    /// What rough surfaces reflect of it, where a file brings that; else the renderer works it out.
    pub prefiltered: Option<PrefilteredEnvironment>,
    /// Irradiance divided by π by the direction of normals, where a file brings that; else the renderer works it out.
    pub irradiance: Option<LightPicture>,
    /// The light that is not in the texels, if there is one.
    pub light: Option<EnvironmentLight>,
    /// What was changed when it was read; one line each.
    pub notes: Vec<String>,
}

impl std::fmt::Debug for EnvironmentMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "EnvironmentMap({}, {}x{})", self.name, self.width, self.height)
    }
}

/// The error of an environment file that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("environment \"{name}\": {message}")]
pub struct EnvironmentError {
    /// The file.
    pub name: String,
    /// What went wrong, and what is expected.
    pub message: String,
}

/// A picture before it is checked.
pub(crate) struct Decoded {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) rgb: Vec<[f32; 3]>,
}

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

    /// Made by code: `width` by `height` texels, equirectangular, of what `radiance` gives for the unit direction of
    /// each.
    pub fn from_fn(name: &str, width: u32, height: u32, radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let texel = |i: u32| {
            let direction = equirectangular_direction((i % width, i / width), (width, height));
            let [r, g, b] = radiance(direction).to_array().map(|value| f16::from_f32(cut(value).0.min(RADIANCE_MAX)));
            [r, g, b, f16::ONE]
        };
        Self {
            name: name.into(),
            layout: EnvironmentLayout::Equirectangular,
            width,
            height,
            texels: (0..width * height).map(texel).collect(),
            peaks: Vec::new(),
            prefiltered: None,
            irradiance: None,
            light: None,
            notes: Vec::new(),
        }
    }

    /// Made smaller if it is wider than `kept_width`, without what is no radiance.
    fn from_decoded(name: &str, decoded: &Decoded, kept_width: u32) -> Self {
        let factor = decoded.width.div_ceil(kept_width).max(1);
        let (width, height) = ((decoded.width / factor).max(1), (decoded.height / factor).max(1));
        let mut notes = Vec::new();
        if factor > 1 {
            let Decoded { width: from_width, height: from_height, .. } = decoded;
            notes.push(format!("environment \"{name}\": {from_width}x{from_height} is made smaller, {width}x{height}"));
        }
        let mut cut_count = decoded.rgb.iter().flatten().filter(|value| cut(**value).1).count();
        // How many texels of the file lie in one that is kept.
        let area = (decoded.width as f32 / width as f32) * (decoded.height as f32 / height as f32);
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        let mut peaks = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0f32; 3];
                for (row, row_share) in covered(y, decoded.height, height) {
                    for (column, column_share) in covered(x, decoded.width, width) {
                        let texel = &decoded.rgb[(row * decoded.width + column) as usize];
                        for (sum, value) in sum.iter_mut().zip(texel) {
                            *sum += row_share * column_share * cut(*value).0;
                        }
                    }
                }
                let mean = Vec3::from(sum) / area;
                let kept = mean.min(Vec3::splat(RADIANCE_MAX));
                if kept != mean && peaks.len() < PEAKS_MAX {
                    peaks.push((texels.len() as u32, mean - kept));
                } else if kept != mean {
                    cut_count += 1;
                }
                let [r, g, b] = kept.to_array().map(f16::from_f32);
                texels.push([r, g, b, f16::ONE]);
            }
        }
        if cut_count > 0 {
            notes.push(format!(
                "environment \"{name}\": {cut_count} values are not valid radiance, or too bright; NaN counts as 0"
            ));
        }
        Self {
            name: name.into(),
            layout: EnvironmentLayout::Equirectangular,
            width,
            height,
            texels,
            peaks,
            prefiltered: None,
            irradiance: None,
            light: None,
            notes,
        }
    }
}

/// The columns (or rows) of a picture, of which there are `from`, that one of `to` equal parts covers, each with the
/// share of it that lies in the part. Together all parts have each column once.
fn covered(part: u32, from: u32, to: u32) -> impl Iterator<Item = (u32, f32)> {
    // In units of which a column has `to`, and a part `from`.
    let (start, end) = (part * from, (part + 1) * from);
    (start / to..end.div_ceil(to)).map(move |column| {
        let inside = end.min((column + 1) * to) - start.max(column * to);
        (column, inside as f32 / to as f32)
    })
}

/// The unit direction of the middle of a texel of an equirectangular picture.
pub fn equirectangular_direction((x, y): (u32, u32), size: (u32, u32)) -> Vec3 {
    equirectangular_direction_within((x as f32 + 0.5, y as f32 + 0.5), size)
}

/// The unit direction of a place of an equirectangular picture, in texels from its upper left corner.
pub fn equirectangular_direction_within((x, y): (f32, f32), (width, height): (u32, u32)) -> Vec3 {
    let around = std::f32::consts::TAU * (x / width as f32 - 0.5);
    let down = std::f32::consts::PI * y / height as f32;
    Vec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin())
}

/// A value as radiance, and whether that is another one. Infinity is as bright as texels are.
pub(crate) fn cut(value: f32) -> (f32, bool) {
    match value {
        _ if value.is_nan() => (0.0, true),
        f32::INFINITY => (RADIANCE_MAX, true),
        _ => (value.clamp(0.0, PEAK_MAX), !(0.0..=PEAK_MAX).contains(&value)),
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

/// How OpenEXR files begin.
const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(EXR_MAGIC)
}

/// Whether bytes are a Radiance or an OpenEXR file, whose values are light.
pub(crate) fn holds_light(bytes: &[u8]) -> bool {
    is_exr(bytes) || is_radiance(bytes)
}

/// A Radiance or an OpenEXR file of a size that `check_size` allows.
pub(crate) fn decode_light(bytes: &[u8], check_size: CheckSize) -> Result<Decoded, String> {
    if is_exr(bytes) { decode_exr(bytes, check_size) } else { decode_radiance(bytes, check_size) }
}

/// Width and height of such a file, from its header; of an OpenEXR file with several parts the first one's.
pub(crate) fn light_size(bytes: &[u8]) -> Result<(u32, u32), String> {
    if is_exr(bytes) { exr_file::size(bytes) } else { radiance::size(bytes) }
}

/// What says whether a width and height can be read.
pub(crate) type CheckSize = fn(u32, u32) -> Result<(), String>;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use exr::prelude::write_rgb_file;

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
        let map = EnvironmentMap::from_decoded("a", &Decoded { width: 2, height: 1, rgb }, 4096);
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
        let map = EnvironmentMap::from_decoded("a", &Decoded { width: 8, height: 4, rgb }, 4);
        assert_eq!((map.width, map.height), (4, 2));
        assert_eq!(floats(&map)[..4].iter().map(|texel| texel[0]).collect::<Vec<_>>(), [0.5, 2.5, 4.5, 6.5]);
        assert!(map.notes[0].contains("8x4 is made smaller, 4x2"), "{:?}", map.notes);
    }

    #[test]
    fn every_column_and_row_counts_once_where_the_factor_leaves_a_remainder() {
        // Thirds of 10 by 5: 3 by 1. Red is the column, green the row, blue 7 in the last column alone.
        let texel = |i: u8| [f32::from(i % 10), f32::from(i / 10), if i % 10 == 9 { 7.0 } else { 0.0 }];
        let map =
            EnvironmentMap::from_decoded("a", &Decoded { width: 10, height: 5, rgb: (0..50).map(texel).collect() }, 4);
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
        let map = EnvironmentMap::from_decoded("a", &Decoded { width: 10, height: 5, rgb }, 4);
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
