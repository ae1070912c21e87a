//! Stands in for the readers of all formats but glTF where the feature `formats` is off.

use super::format::Format;
use crate::gltf_file::{LoadError, LoadedScene};

type Resolve<'r> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'r;

pub(super) fn load(_format: Format, _bytes: &[u8], _resolve: &mut Resolve) -> Result<LoadedScene, LoadError> {
    let message =
        "expected glTF: OBJ, STL, PLY and 3MF need the feature `formats`, without which this program was built";
    Err(LoadError::malformed("", message))
}

pub(super) const fn names(_format: Format, _bytes: &[u8], _resolve: &mut Resolve) -> Vec<String> {
    Vec::new()
}
