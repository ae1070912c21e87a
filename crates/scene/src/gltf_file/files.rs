//! The files of a model: which may be read, and how large they may be.

use crate::input_file::{self, InputError};
use std::path::{Component, Path};

/// The largest file that is read, the model's own or one beside it: 1 GiB.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// What all images of a file may take as texels: 1 GiB, and more for a file with many bytes of images. So a few
/// kilobytes cannot claim all memory, and honest models, whose images are seldom packed more tightly, stay far below.
pub(crate) fn texel_budget_bytes(encoded_bytes: u64) -> u64 {
    (1 << 30) + encoded_bytes.saturating_mul(64)
}

/// The file beside the model that a decoded URI names.
pub(crate) fn checked_relative_path(uri: &str) -> Result<&Path, String> {
    let path = Path::new(uri);
    let is_plain = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if uri.is_empty() || !is_plain || uri.contains([':', '\\', '\0']) {
        return Err(format!(
            "\"{uri}\" is not a path inside the model's folder; put the file there and name it plainly"
        ));
    }
    Ok(path)
}

pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    input_file::read(path, MAX_FILE_BYTES).map_err(|error| match error {
        InputError::NotRegular | InputError::Folder => {
            let hint = "a model can be piped in as `-`";
            format!("\"{}\" is not a regular file; {hint}", path.display())
        }
        InputError::TooLarge(_) => format!("\"{}\" is larger than 1 GiB; split it", path.display()),
        error => format!("cannot read \"{}\": {error}", path.display()),
    })
}
