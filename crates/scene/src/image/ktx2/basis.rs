//! Basis Universal, and ASTC, to texels and to blocks that devices sample.

use crate::BlockFormat;
use basisu::{DecodeFlags, TargetFormat, Transcoder};

/// The texels of the first level, four bytes each.
///
/// # Errors
/// The data are broken, or of a kind that cannot become such.
pub(super) fn texels(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let refused = |error| match error {
        basisu::Error::Unsupported { source, .. } => {
            format!("its format {source:?} cannot become eight bits a channel")
        }
        error => format!("its Basis Universal data are broken or of a kind that is not supported ({error:?})"),
    };
    let transcoder = Transcoder::new(bytes).map_err(refused)?;
    transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(refused)
}

/// The blocks of the first `count` levels, the largest first; none where one cannot become such.
pub(super) fn levels(bytes: &[u8], count: u32, format: BlockFormat) -> Option<Vec<Vec<u8>>> {
    let target = match format {
        BlockFormat::Bc7 => TargetFormat::Bc7Rgba,
        BlockFormat::Etc2 => TargetFormat::Etc2Rgba,
        BlockFormat::Astc => TargetFormat::Astc4x4Rgba,
    };
    let transcoder = Transcoder::new(bytes).ok()?;
    (0..count).map(|level| transcoder.transcode(level, target, DecodeFlags::NONE).ok()).collect()
}
