//! `KHR_draco_mesh_compression`: primitives whose triangles and attributes are packed together. They are unpacked when
//! the primitive is read, and stand in for its accessors meanwhile.
//!
//! Source: the specification of that name (Khronos 3D Formats); the bitstream is Google's Draco 2.2, by `draco-core`.

#[cfg(not(feature = "draco"))]
#[path = "draco/absent.rs"]
mod decode;
#[cfg(feature = "draco")]
mod decode;

use super::accessor::Component;
use super::{Document, LoadError, json::Json};

const NAME: &str = "KHR_draco_mesh_compression";

/// The elements of an accessor, tightly packed.
pub(super) struct Unpacked {
    pub(super) component: Component,
    pub(super) count: usize,
    pub(super) bytes: Vec<u8>,
}

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

/// The attributes that are packed: where the extension names each, its accessor, and its number in the packed data; and
/// the accessor of the indices, without a number.
fn packed_accessors(
    document: &Document,
    json: &Json,
    extension: &Json,
) -> Result<Vec<(String, usize, Option<u32>)>, LoadError> {
    let (attributes, packed) = (json.require_object("attributes")?, extension.require_object("attributes")?);
    let mut accessors = Vec::new();
    for key in packed.keys() {
        let unique_id = packed.require_integer(key)?;
        let unique_id = u32::try_from(unique_id).map_err(|_| packed.error(key, "expected an integer of 32 bits"))?;
        let accessor = attributes.index(key, document.accessors.len(), "accessor")?;
        let accessor = accessor.ok_or_else(|| packed.error(key, "the primitive has no such attribute"))?;
        accessors.push((packed.at(key), accessor, Some(unique_id)));
    }
    let indices = json.index("indices", document.accessors.len(), "accessor")?;
    let indices = indices.ok_or_else(|| json.error("indices", "expected the accessor that the triangles stand for"))?;
    accessors.push((json.at("indices"), indices, None));
    Ok(accessors)
}
