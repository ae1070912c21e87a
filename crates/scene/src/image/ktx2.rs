//! Pictures in KTX2 containers: Basis Universal (ETC1S and UASTC) as `KHR_texture_basisu` has them, and bytes that are not
//! compressed, which some exporters write. The first level alone is taken; the renderer makes the others itself.
//!
//! Source: KTX File Format Specification 2.0 (Khronos). Basis Universal is transcoded by the crate `basisu`.

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use std::io::Read;

/// The first bytes of a file.
const MAGIC: &[u8; 12] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// Where the index of levels begins.
const LEVELS_OFFSET: usize = 80;

/// What the header says.
struct Header {
    /// The format of texels, a number of Vulkan; 0 for those that only the descriptor names.
    format: u32,
    width: u32,
    height: u32,
    /// How levels are packed once more; 2 is Zstandard.
    supercompression: u32,
}

/// Whether `bytes` begin as a KTX2 container does.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

fn read_u32(bytes: &[u8], at: usize) -> Result<u32, String> {
    let word = bytes.get(at..).and_then(|rest| rest.first_chunk());
    word.map(|word| u32::from_le_bytes(*word)).ok_or_else(|| "the KTX2 container ends early".to_owned())
}

fn read_u64(bytes: &[u8], at: usize) -> Result<u64, String> {
    Ok(u64::from(read_u32(bytes, at)?) | u64::from(read_u32(bytes, at + 4)?) << 32)
}

fn header(bytes: &[u8]) -> Result<Header, String> {
    let word = |index: usize| read_u32(bytes, MAGIC.len() + 4 * index);
    let (height, depth, layers, faces) = (word(3)?, word(4)?, word(5)?, word(6)?);
    if height == 0 || depth > 0 || layers > 1 || faces != 1 {
        return Err(
            "expected a KTX2 container of one flat picture, not of a line, a volume, layers or a cube".to_owned()
        );
    }
    Ok(Header { format: word(0)?, width: word(2)?, height, supercompression: word(8)? })
}

/// Width and height in texels, which may be 0.
pub(super) fn dimensions(bytes: &[u8]) -> Result<(u32, u32), String> {
    header(bytes).map(|header| (header.width, header.height))
}

/// The texels of the first level, four bytes each. Whoever calls has found the size to be acceptable.
pub(super) fn decode(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let header = header(bytes)?;
    // R8, R8G8, R8G8B8 and R8G8B8A8, each as numbers and as sRGB.
    match header.format {
        9 | 15 => return plain(bytes, &header, 1),
        16 | 22 => return plain(bytes, &header, 2),
        23 | 29 => return plain(bytes, &header, 3),
        37 | 43 => return plain(bytes, &header, 4),
        _ => {}
    }
    let refused = |error| match error {
        basisu::Error::Unsupported { source, .. } => {
            format!("its format {source:?} cannot become eight bits a channel")
        }
        error => format!("its Basis Universal data are broken or of a kind that is not supported ({error:?})"),
    };
    check_ranges(bytes)?;
    // A level that is packed once more says itself how much it becomes, of which this is four times the honest most.
    let most_bytes = 4 * u64::from(header.width.next_multiple_of(12)) * u64::from(header.height.next_multiple_of(12));
    if read_u64(bytes, LEVELS_OFFSET + 16)? > most_bytes {
        return Err("its first level claims to hold more than its texels".to_owned());
    }
    let transcoder = Transcoder::new(bytes).map_err(refused)?;
    let texels = transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(refused)?;
    let expected = u64::from(header.width) * u64::from(header.height) * 4;
    if texels.len() as u64 != expected {
        return Err("its Basis Universal data are of another size than the container says".to_owned());
    }
    Ok(texels)
}

/// Whether all that the container names lies inside it.
fn check_ranges(bytes: &[u8]) -> Result<(), String> {
    let level_count = read_u32(bytes, 40)?.max(1);
    // The descriptor, the key values, the data that all levels share, and the levels.
    let mut ranges = vec![
        (u64::from(read_u32(bytes, 48)?), u64::from(read_u32(bytes, 52)?)),
        (u64::from(read_u32(bytes, 56)?), u64::from(read_u32(bytes, 60)?)),
        (read_u64(bytes, 64)?, read_u64(bytes, 72)?),
    ];
    for level in 0..level_count as usize {
        let at = LEVELS_OFFSET + 24 * level;
        ranges.push((read_u64(bytes, at)?, read_u64(bytes, at + 8)?));
    }
    let is_inside =
        |(offset, length): &(u64, u64)| offset.checked_add(*length).is_some_and(|end| end <= bytes.len() as u64);
    if ranges.iter().all(is_inside) {
        Ok(())
    } else {
        Err("a part of the KTX2 container lies outside the file".to_owned())
    }
}

/// Bytes that are not compressed, or by Zstandard alone.
fn plain(bytes: &[u8], header: &Header, channels: usize) -> Result<Vec<u8>, String> {
    let (offset, length) = (read_u64(bytes, LEVELS_OFFSET)?, read_u64(bytes, LEVELS_OFFSET + 8)?);
    let end = offset.checked_add(length).and_then(|end| usize::try_from(end).ok());
    let level = end.and_then(|end| bytes.get(usize::try_from(offset).ok()?..end));
    let level = level.ok_or("the first level of the KTX2 container lies outside the file")?;
    let count = header.width as usize * header.height as usize;
    let unpacked = match header.supercompression {
        0 => level.to_vec(),
        2 => {
            let stream = ruzstd::StreamingDecoder::new(level).map_err(|error| format!("broken Zstandard: {error}"))?;
            // One byte more than there should be tells that there are too many.
            let mut unpacked = Vec::new();
            let limited = &mut stream.take((count * channels) as u64 + 1);
            limited.read_to_end(&mut unpacked).map_err(|error| format!("broken Zstandard: {error}"))?;
            unpacked
        }
        other => return Err(format!("expected no supercompression or Zstandard, 0 or 2, found {other}")),
    };
    if unpacked.len() != count * channels {
        return Err(format!("expected {} bytes of texels, found {}", count * channels, unpacked.len()));
    }
    if channels == 4 {
        return Ok(unpacked);
    }
    let texels = unpacked.chunks_exact(channels).flat_map(|texel| {
        // Channels that are not there are 0, alpha is 1, as Vulkan has it.
        let channel = |index: usize| texel.get(index).copied().unwrap_or(0);
        [channel(0), channel(1), channel(2), 255]
    });
    Ok(texels.collect())
}
