//! What stages are called.

use std::path::Path;

/// What the names of stages end in, whatever the case of its letters.
const ENDING: &str = ".stage.toml";

/// Whether a path is called as stages are.
pub fn is_stage(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let end = name.len().checked_sub(ENDING.len()).and_then(|at| name.get(at..));
    end.is_some_and(|end| end.eq_ignore_ascii_case(ENDING))
}
