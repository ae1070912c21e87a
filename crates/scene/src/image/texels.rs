//! What images decode to, and how large they may be.

use half::f16;

/// The largest width and height of an image in texels.
pub const MAX_IMAGE_SIZE_TEXELS: u32 = 16384;

/// The most memory that decoding one image may take: 512 MiB.
pub(super) const MAX_DECODE_BYTES: u64 = 512 << 20;

/// Compressed blocks that devices sample: of 4 by 4 texels with alpha, in 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockFormat {
    /// BC7.
    Bc7,
    /// ETC2 with EAC alpha.
    Etc2,
    /// ASTC, low dynamic range.
    Astc,
}

impl BlockFormat {
    /// Texels along the side of a block.
    pub const SIDE: u32 = 4;
    /// Bytes of a block.
    pub const BYTES: u32 = 16;
}

/// A level of a compressed image: blocks, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// The bytes of all blocks; those at the right and lower edge may hold more than there are texels.
    pub data: Vec<u8>,
}

/// Linear light in half floats, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfFloats {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Red, green, blue, 1: linear, finite, from 0 to [`RADIANCE_MAX`](crate::environment::RADIANCE_MAX).
    pub texels: Vec<[f16; 4]>,
    /// How many values of the file were no such, and were cut.
    pub cut_count: u64,
}
