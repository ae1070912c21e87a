//! Pictures of light in files, Radiance or OpenEXR.

use super::exr_file::{self, decode_exr};
use super::map::{CheckSize, UncheckedPicture};
use super::radiance::{self, decode_radiance, is_radiance};

/// How OpenEXR files begin.
const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

pub(super) fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(EXR_MAGIC)
}

/// Whether bytes are a Radiance or an OpenEXR file, whose values are light.
pub(crate) fn holds_light(bytes: &[u8]) -> bool {
    is_exr(bytes) || is_radiance(bytes)
}

/// A Radiance or an OpenEXR file of a size that `check_size` allows.
pub(crate) fn decode_light(bytes: &[u8], check_size: CheckSize) -> Result<UncheckedPicture, String> {
    if is_exr(bytes) { decode_exr(bytes, check_size) } else { decode_radiance(bytes, check_size) }
}

/// Width and height of such a file, from its header; of an OpenEXR file with several parts the first one's.
pub(crate) fn light_size(bytes: &[u8]) -> Result<(u32, u32), String> {
    if is_exr(bytes) { exr_file::size(bytes) } else { radiance::size(bytes) }
}
