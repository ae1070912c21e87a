//! Pictures in KTX2 containers: Basis Universal (ETC1S and UASTC) as `KHR_texture_basisu` has them, and bytes that are
//! not compressed, which some exporters write. The first level alone is taken; the renderer makes the others itself.
//!
//! Basis Universal is transcoded by the crate `basisu`.

#[cfg(feature = "ktx2")]
mod basis;
#[cfg(not(feature = "ktx2"))]
#[path = "ktx2/basis_absent.rs"]
mod basis;

use super::texels::{BlockFormat, Blocks};
use crate::ktx2::{Header, check_ranges, header, level, unpacked_bytes};

/// The header of a flat picture.
fn flat(bytes: &[u8]) -> Result<Header, String> {
    let header = header(bytes)?;
    if header.height == 0 || header.depth > 0 || header.layers > 1 || header.faces != 1 {
        return Err(
            "expected a KTX2 container of one flat picture, not of a line, a volume, layers or a cube".to_owned()
        );
    }
    Ok(header)
}

/// Width and height in texels, which may be 0.
pub(super) fn dimensions(bytes: &[u8]) -> Result<(u32, u32), String> {
    flat(bytes).map(|header| (header.width, header.height))
}

/// The texels of the first level, four bytes each. Whoever calls has found the size to be acceptable.
pub(super) fn decode(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let header = flat(bytes)?;
    // R8, R8G8, R8G8B8 and R8G8B8A8, each as numbers and as sRGB.
    match header.format {
        9 | 15 => return plain(bytes, &header, 1),
        16 | 22 => return plain(bytes, &header, 2),
        23 | 29 => return plain(bytes, &header, 3),
        37 | 43 => return plain(bytes, &header, 4),
        // What Basis Universal packs, and ASTC, whose kinds of floats the transcoder names.
        0 | 157..=184 | 1_000_066_000..=1_000_066_013 => {}
        other => {
            return Err(format!(
                "its format {} cannot be read; textures of materials have eight bits a channel \
                 (R8, R8G8, R8G8B8, R8G8B8A8), or are ASTC or Basis Universal (ETC1S, UASTC)",
                format_name(other)
            ));
        }
    }
    check_ranges(bytes)?;
    // A level that is packed once more says itself how much it becomes, of which this is four times the honest most.
    let most_bytes = 4 * u64::from(header.width.next_multiple_of(12)) * u64::from(header.height.next_multiple_of(12));
    if unpacked_bytes(bytes, 0)? > most_bytes {
        return Err("its first level claims to hold more than its texels".to_owned());
    }
    let texels = basis::texels(bytes)?;
    let expected = u64::from(header.width) * u64::from(header.height) * 4;
    if texels.len() as u64 != expected {
        return Err("its Basis Universal data are of another size than the container says".to_owned());
    }
    Ok(texels)
}

/// The name that Vulkan has for a format, where it is one that containers often hold, and its number.
fn format_name(format: u32) -> String {
    let name = match format {
        70 => "R16_UNORM",
        76 => "R16_SFLOAT",
        77 => "R16G16_UNORM",
        83 => "R16G16_SFLOAT",
        84 => "R16G16B16_UNORM",
        90 => "R16G16B16_SFLOAT",
        91 => "R16G16B16A16_UNORM",
        97 => "R16G16B16A16_SFLOAT",
        100 => "R32_SFLOAT",
        103 => "R32G32_SFLOAT",
        106 => "R32G32B32_SFLOAT",
        109 => "R32G32B32A32_SFLOAT",
        122 => "B10G11R11_UFLOAT",
        123 => "E5B9G9R9_UFLOAT",
        30 | 36 | 44 | 50 => "of blue before red",
        131..=138 => "of BC1, BC2 or BC3",
        139..=142 => "of BC4 or BC5",
        143 | 144 => "of BC6H",
        145 | 146 => "of BC7",
        147..=156 => "of ETC2 or EAC",
        other => return format!("{other} (a number of Vulkan)"),
    };
    format!("{name} ({format})")
}

/// What the sides become in level `level`.
fn sides(header: &Header, level: u32) -> (u32, u32) {
    ((header.width >> level).max(1), (header.height >> level).max(1))
}

/// All levels of a Basis Universal picture as blocks; none if it is none, is broken, or lacks levels. Whoever calls has
/// found the size to be acceptable.
pub(super) fn transcode(bytes: &[u8], format: BlockFormat) -> Option<Vec<Blocks>> {
    let header = flat(bytes).ok()?;
    let is_whole = header.levels == header.width.max(header.height).max(1).ilog2() + 1;
    if header.format != 0 || !is_whole || check_ranges(bytes).is_err() {
        return None;
    }
    // As where eight bits a channel are made.
    let is_honest = |level: u32| {
        let (width, height) = sides(&header, level);
        let most_bytes = 4 * u64::from(width.next_multiple_of(12)) * u64::from(height.next_multiple_of(12));
        unpacked_bytes(bytes, level).is_ok_and(|said| said <= most_bytes)
    };
    if !(0..header.levels).all(is_honest) {
        return None;
    }
    let level = |(level, data): (u32, Vec<u8>)| {
        let (width, height) = sides(&header, level);
        let blocks = width.div_ceil(BlockFormat::SIDE) as usize * height.div_ceil(BlockFormat::SIDE) as usize;
        (data.len() == blocks * BlockFormat::BYTES as usize).then_some(Blocks { width, height, data })
    };
    (0..).zip(basis::levels(bytes, header.levels, format)?).map(level).collect()
}

/// Bytes that are not compressed, or by Zstandard alone.
fn plain(bytes: &[u8], header: &Header, channels: usize) -> Result<Vec<u8>, String> {
    let count = header.width as usize * header.height as usize;
    let unpacked = level(bytes, header, 0, count * channels)?;
    if channels == 4 {
        return Ok(unpacked.into_owned());
    }
    let texels = unpacked.chunks_exact(channels).flat_map(|texel| {
        // Channels that are not there are 0, alpha is 1, as Vulkan has it.
        let channel = |index: usize| texel.get(index).copied().unwrap_or(0);
        [channel(0), channel(1), channel(2), 255]
    });
    Ok(texels.collect())
}
