//! Stands in for the decoder where the feature `draco` is off.

use super::Unpacked;
use crate::gltf_file::{Document, LoadError, json::Json};
use std::collections::BTreeMap;

pub(super) fn unpack_accessors(
    _document: &mut Document,
    _json: &Json,
    extension: &Json,
) -> Result<BTreeMap<usize, Unpacked>, LoadError> {
    let message = "the data are packed by Draco, and this program was built without the feature `draco`";
    Err(LoadError::invalid(&extension.pointer, message))
}
