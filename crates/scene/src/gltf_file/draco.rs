//! `KHR_draco_mesh_compression`: primitives whose triangles and attributes are packed together. They are unpacked when
//! the primitive is read, and stand in for its accessors meanwhile.
//!
//! Source: the specification of that name (Khronos 3D Formats); the bitstream is Google's Draco 2.2, by `draco-core`.

mod accessors;
#[cfg(not(feature = "draco"))]
#[path = "draco/absent.rs"]
mod decode;
#[cfg(feature = "draco")]
mod decode;

use super::document::Document;
use super::error::LoadError;
use super::json::Json;
use accessors::packed_accessors;

const NAME: &str = "KHR_draco_mesh_compression";

/// Unpacks the primitive at `json`, so that [`Document::read`] finds its accessors; says whether it is packed. Broken
/// data are a warning where the file does not require the extension and every accessor has bytes of its own.
///
/// # Errors
/// If the data are broken and nothing is in their stead.
pub(super) fn unpack(document: &mut Document, json: &Json) -> Result<bool, LoadError> {
    let Some(extension) = json.extension(NAME)? else { return Ok(false) };
    match decode::unpack_accessors(document, json, &extension) {
        Ok(unpacked) => {
            document.unpacked = unpacked;
            Ok(true)
        }
        Err(error) if document.root.strings("extensionsRequired")?.contains(&NAME) => Err(error),
        Err(error) => {
            let accessors = packed_accessors(document, json, &extension);
            let has_bytes = |index: &usize| document.accessors.get(*index).is_some_and(|json| json.has("bufferView"));
            if !accessors.is_ok_and(|accessors| accessors.iter().all(|(_, accessor, _)| has_bytes(accessor))) {
                return Err(error);
            }
            let message = format!("{}; the accessors that are not packed are used", error.into_message());
            document.warn(&extension.pointer, &message);
            Ok(false)
        }
    }
}
