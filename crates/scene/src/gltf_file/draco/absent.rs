//! Stands in for the decoder where the feature `draco` is off.

use crate::gltf_file::document::{DecodedAccessor, Document};
use crate::gltf_file::error::LoadError;
use crate::gltf_file::json::Json;
use std::collections::BTreeMap;

pub(super) fn unpack_accessors(
    _document: &mut Document,
    _json: &Json,
    extension: &Json,
) -> Result<BTreeMap<usize, DecodedAccessor>, LoadError> {
    let message = "the data are packed by Draco, and this program was built without the feature `draco`";
    Err(LoadError::invalid(&extension.pointer, message))
}
