//! What buffers and bufferViews say of `EXT_meshopt_compression` and its successor.

use super::error::LoadError;
use super::json::Json;

/// The extension and its successor; the latter wins where a bufferView has both.
pub(super) const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// The extension on a bufferView or a buffer; none without it.
pub(super) fn extension<'a>(json: &Json<'a>) -> Result<Option<Json<'a>>, LoadError> {
    for name in NAMES {
        if let Some(extension) = json.extension(name)? {
            return Ok(Some(extension));
        }
    }
    Ok(None)
}

/// Whether a buffer holds only what the packed bufferViews hold too, so that it is read only where one of them is
/// broken.
pub(super) fn is_fallback(buffer: &Json) -> Result<bool, LoadError> {
    extension(buffer)?.map_or(Ok(false), |extension| extension.bool("fallback", false))
}
