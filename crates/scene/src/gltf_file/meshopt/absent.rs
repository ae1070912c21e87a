//! Stands in for the decoder where the feature `meshopt` is off.

use crate::gltf_file::document::Document;
use crate::gltf_file::error::LoadError;
use crate::gltf_file::json::Json;

pub(super) fn unpack(
    _document: &Document,
    json: &Json,
    _view: usize,
    _budget_bytes: &mut u64,
) -> Result<Vec<u8>, LoadError> {
    let message = "the data are packed by meshoptimizer, and this program was built without the feature `meshopt`";
    Err(LoadError::invalid(&json.pointer, message))
}
