//! Which accessors the extension stands in for.

use crate::gltf_file::document::Document;
use crate::gltf_file::error::LoadError;
use crate::gltf_file::json::Json;

/// The attributes that are packed: where the extension names each, its accessor, and its number in the packed data; and
/// the accessor of the indices, without a number.
pub(super) fn packed_accessors(
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
