//! The container KTX2: its header and its levels.
//!
//! Source: KTX File Format Specification 2.0 (Khronos).

#[cfg(not(feature = "ktx2"))]
#[path = "ktx2/zstandard_absent.rs"]
mod zstandard;
#[cfg(feature = "ktx2")]
mod zstandard;

use std::borrow::Cow;

/// The first bytes of a file.
const MAGIC: &[u8; 12] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// Where the index of levels begins.
const LEVELS_OFFSET: usize = 80;

/// What the header says.
pub(crate) struct Header {
    /// The format of texels, a number of Vulkan; 0 for those that only the descriptor names.
    pub format: u32,
    /// Width in texels, which may be 0.
    pub width: u32,
    /// Height in texels, which may be 0.
    pub height: u32,
    /// Depth in texels; 0 of what is no volume.
    pub depth: u32,
    /// Layers of an array; 0 of what is none.
    pub layers: u32,
    /// 6 of a cube map, else 1.
    pub faces: u32,
    /// How many levels there are; 0 if they are yet to be made of one.
    pub levels: u32,
    /// How levels are packed once more; 2 is Zstandard.
    supercompression: u32,
}

/// Whether `bytes` begin as a KTX2 container does.
pub(crate) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

fn read_u32(bytes: &[u8], at: usize) -> Result<u32, String> {
    let word = bytes.get(at..).and_then(|rest| rest.first_chunk());
    word.map(|word| u32::from_le_bytes(*word)).ok_or_else(|| "the KTX2 container ends early".to_owned())
}

fn read_u64(bytes: &[u8], at: usize) -> Result<u64, String> {
    Ok(u64::from(read_u32(bytes, at)?) | u64::from(read_u32(bytes, at + 4)?) << 32)
}

pub(crate) fn header(bytes: &[u8]) -> Result<Header, String> {
    let word = |index: usize| read_u32(bytes, MAGIC.len() + 4 * index);
    Ok(Header {
        format: word(0)?,
        width: word(2)?,
        height: word(3)?,
        depth: word(4)?,
        layers: word(5)?,
        faces: word(6)?,
        levels: word(7)?,
        supercompression: word(8)?,
    })
}

/// How many bytes a level says that it has when it is unpacked.
pub(crate) fn unpacked_bytes(bytes: &[u8], level: u32) -> Result<u64, String> {
    read_u64(bytes, LEVELS_OFFSET + 24 * level as usize + 16)
}

/// What the descriptor says of the colours of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DeclaredColors {
    /// The primaries: a number of the Khronos Data Format Specification.
    primaries: u8,
    /// The transfer function: likewise.
    transfer: u8,
}

/// Source: Khronos Data Format Specification 1.4, the basic descriptor block.
impl DeclaredColors {
    const LINEAR: u8 = 1;
    const SRGB: u8 = 2;
    const REC_709: u8 = 1;

    /// None where there is no basic descriptor block.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        // After the length of all blocks, the vendor and kind of the first, both 0, its version and its length.
        let block = usize::try_from(read_u32(bytes, 48).ok()?).ok()?.checked_add(4)?;
        let is_basic = read_u32(bytes, block).ok()? == 0;
        let [_, primaries, transfer, _] = read_u32(bytes, block.checked_add(8)?).ok()?.to_le_bytes();
        is_basic.then_some(Self { primaries, transfer })
    }

    /// What texels are declared as, in words, if that is something else than what they are read as.
    pub fn other_than(self, is_srgb: bool) -> Option<String> {
        // What says nothing is as it is read; data have no primaries.
        let transfer_differs = self.transfer > 0 && self.transfer != if is_srgb { Self::SRGB } else { Self::LINEAR };
        let primaries_differ = is_srgb && self.primaries > Self::REC_709;
        let transfer = match self.transfer {
            0 => "texels without a transfer function".to_owned(),
            Self::LINEAR => "linear texels".to_owned(),
            Self::SRGB => "sRGB texels".to_owned(),
            other => format!("texels of the transfer function {other}"),
        };
        let primaries = match self.primaries {
            0 => "no primaries".to_owned(),
            Self::REC_709 => "the primaries of Rec. 709".to_owned(),
            2 | 3 => "the primaries of Rec. 601".to_owned(),
            4 => "the primaries of Rec. 2020".to_owned(),
            10 => "the primaries of Display P3".to_owned(),
            11 => "the primaries of Adobe RGB".to_owned(),
            other => format!("the primaries {other} of the Khronos Data Format"),
        };
        let declared = if primaries_differ { format!("{transfer} with {primaries}") } else { transfer };
        (transfer_differs || primaries_differ).then_some(declared)
    }
}

/// Fails unless all that the container names lies inside it.
pub(crate) fn check_ranges(bytes: &[u8]) -> Result<(), String> {
    let level_count = header(bytes)?.levels.max(1);
    // The descriptor, the key values, the data that all levels share, and the levels.
    let shared = [
        (u64::from(read_u32(bytes, 48)?), u64::from(read_u32(bytes, 52)?)),
        (u64::from(read_u32(bytes, 56)?), u64::from(read_u32(bytes, 60)?)),
        (read_u64(bytes, 64)?, read_u64(bytes, 72)?),
    ];
    let check = |(offset, length): (u64, u64)| {
        let is_inside = offset.checked_add(length).is_some_and(|end| end <= bytes.len() as u64);
        if is_inside { Ok(()) } else { Err("a part of the KTX2 container lies outside the file".to_owned()) }
    };
    shared.into_iter().try_for_each(check)?;
    (0..level_count as usize).try_for_each(|level| {
        let at = LEVELS_OFFSET + 24 * level;
        check((read_u64(bytes, at)?, read_u64(bytes, at + 8)?))
    })
}

/// The `expected` bytes of a level, which are not compressed, or by Zstandard alone.
pub(crate) fn level<'a>(
    bytes: &'a [u8],
    header: &Header,
    level: u32,
    expected: usize,
) -> Result<Cow<'a, [u8]>, String> {
    let at = LEVELS_OFFSET + 24 * level as usize;
    let (offset, length) = (read_u64(bytes, at)?, read_u64(bytes, at + 8)?);
    let end = offset.checked_add(length).and_then(|end| usize::try_from(end).ok());
    let packed = end.and_then(|end| bytes.get(usize::try_from(offset).ok()?..end));
    let packed = packed.ok_or_else(|| format!("level {level} of the KTX2 container lies outside the file"))?;
    let unpacked = match header.supercompression {
        0 => Cow::Borrowed(packed),
        // One byte more than there should be tells that there are too many.
        2 => Cow::Owned(zstandard::unpack(packed, expected as u64 + 1)?),
        other => return Err(format!("expected no supercompression or Zstandard, 0 or 2, found {other}")),
    };
    if unpacked.len() != expected {
        return Err(format!("expected {expected} bytes of texels in level {level}, found {}", unpacked.len()));
    }
    Ok(unpacked)
}
