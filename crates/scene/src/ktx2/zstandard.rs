//! Levels that Zstandard packs.

use std::io::Read;

/// The first `bytes_max` bytes of what is packed.
///
/// # Errors
/// It is broken.
pub(super) fn unpack(packed: &[u8], bytes_max: u64) -> Result<Vec<u8>, String> {
    let stream = ruzstd::StreamingDecoder::new(packed).map_err(|error| format!("broken Zstandard: {error}"))?;
    let mut unpacked = Vec::new();
    stream.take(bytes_max).read_to_end(&mut unpacked).map_err(|error| format!("broken Zstandard: {error}"))?;
    Ok(unpacked)
}
