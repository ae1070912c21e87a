//! Cube maps in KTX2 containers. Levels below the first are taken to be prefiltered: what a surface reflects whose
//! perceptual roughness is the level divided by the number of the last one, as tools that prefilter write them.

use super::cube::FACE_SIDE_MAX;
use super::map::{Cube, EnvironmentError, EnvironmentMap, Level, PrefilteredEnvironment, UncheckedPicture};
use crate::ktx2::{Header, header, level};
use half::f16;

/// The widest faces that are kept of levels below the first.
const KEPT_SIDE_MAX: u32 = 512;

/// How texels lie in bytes: numbers of Vulkan.
#[derive(Clone, Copy, Debug)]
enum TexelFormat {
    /// Eight bits a channel, of so many channels, linear or sRGB.
    Bytes(usize, bool),
    /// Half floats, of so many channels.
    Halves(usize),
    /// Floats, of so many channels.
    Floats(usize),
    /// Unsigned floats of 11, 11 and 10 bits.
    Packed,
    /// Nine bits a channel and an exponent for all.
    SharedExponent,
}

impl TexelFormat {
    fn of(header: &Header) -> Result<Self, String> {
        Ok(match header.format {
            23 | 29 => Self::Bytes(3, header.format == 29),
            37 | 43 => Self::Bytes(4, header.format == 43),
            90 => Self::Halves(3),
            97 => Self::Halves(4),
            106 => Self::Floats(3),
            109 => Self::Floats(4),
            122 => Self::Packed,
            123 => Self::SharedExponent,
            other => {
                return Err(format!(
                    "its format {other} is not among R8G8B8(A8), R16G16B16(A16)_SFLOAT, R32G32B32(A32)_SFLOAT, B10G11R11_UFLOAT and E5B9G9R9_UFLOAT; \
                     write a cube map of one of these, without supercompression or with Zstandard"
                ));
            }
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::Bytes(channels, _) => channels,
            Self::Halves(channels) => 2 * channels,
            Self::Floats(channels) => 4 * channels,
            Self::Packed | Self::SharedExponent => 4,
        }
    }

    /// Red, green and blue of the bytes of a texel.
    fn read(self, bytes: &[u8]) -> [f32; 3] {
        let part = |at: usize| bytes.get(at).copied().unwrap_or(0);
        let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|byte| part(at + byte)));
        [0usize, 1, 2].map(|channel| match self {
            Self::Bytes(_, is_srgb) => {
                let value = f32::from(part(channel)) / 255.0;
                if is_srgb { crate::colour::linear_from_srgb(value) } else { value }
            }
            Self::Halves(_) => f16::from_le_bytes([part(2 * channel), part(2 * channel + 1)]).to_f32(),
            Self::Floats(_) => f32::from_bits(word(4 * channel)),
            // The exponent of half floats, with fewer bits behind it and no sign.
            Self::Packed => {
                let bits = match channel {
                    0 => (word(0) & 0x7ff) << 4,
                    1 => (word(0) >> 11 & 0x7ff) << 4,
                    _ => (word(0) >> 22) << 5,
                };
                f16::from_bits(bits as u16).to_f32()
            }
            Self::SharedExponent => {
                let mantissa = word(0) >> (9 * channel as u32) & 0x1ff;
                mantissa as f32 * f32::from(i16::from(part(3) >> 3) - 24).exp2()
            }
        })
    }
}

/// The six faces of a level.
fn faces(bytes: &[u8], header: &Header, index: u32) -> Result<Vec<UncheckedPicture>, String> {
    let format = TexelFormat::of(header)?;
    let side = (header.width >> index).max(1);
    let face_bytes = side as usize * side as usize * format.bytes();
    let texels = level(bytes, header, index, 6 * face_bytes)?;
    let face = |bytes: &[u8]| UncheckedPicture {
        width: side,
        height: side,
        rgb: bytes.chunks_exact(format.bytes()).map(|texel| format.read(texel)).collect(),
    };
    Ok(texels.chunks_exact(face_bytes).map(face).collect())
}

fn check(header: &Header) -> Result<(), String> {
    let Header { width, height, depth, layers, faces, levels, .. } = *header;
    if faces != 6 || depth > 0 || layers > 1 {
        return Err("it is a KTX2 container, and of no cube map; six faces and no layers are an environment".into());
    }
    if width != height || width == 0 || width > FACE_SIDE_MAX {
        return Err(format!(
            "a face is square, of at most {FACE_SIDE_MAX} pixels a side, and this has {width}x{height}"
        ));
    }
    if levels > width.ilog2() + 1 {
        return Err(format!("it says that {width} pixels a side have {levels} levels"));
    }
    Ok(())
}

/// The environment in a KTX2 container.
pub(super) fn decode(name: &str, bytes: &[u8]) -> Result<EnvironmentMap, EnvironmentError> {
    let failed = |message: String| EnvironmentError { name: name.into(), message };
    let header = header(bytes).map_err(failed)?;
    check(&header).map_err(failed)?;
    let first = faces(bytes, &header, 0).map_err(failed)?;
    let mut map = EnvironmentMap::of_cube(name, &first);
    if header.levels > 1 {
        let mut levels = Vec::with_capacity(header.levels as usize);
        levels.push(Level::Cube(Cube::made_smaller(&first, KEPT_SIDE_MAX).0));
        drop(first);
        for index in 1..header.levels {
            let faces = faces(bytes, &header, index).map_err(failed)?;
            levels.push(Level::Cube(Cube::made_smaller(&faces, KEPT_SIDE_MAX).0));
        }
        map.prefiltered = Some(PrefilteredEnvironment { name: name.into(), levels });
    }
    Ok(map)
}
