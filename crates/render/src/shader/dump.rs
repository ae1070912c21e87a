//! The texts of programs as files, for whoever looks for an error in one: what the device is given, under names that
//! tell the program and its axes.

use super::program::ProgramError;

/// The variable that names the folder. Without it, or where it is empty, nothing is written.
#[cfg(not(target_arch = "wasm32"))]
const FOLDER: &str = "MANYPASS_SHADER_DUMP";

/// Writes the text of a program with these axes on if the environment names a folder: `geometry.textures.wgsl`.
///
/// # Errors
/// The folder cannot be made or written.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn write(program: &str, axes_on: &[&str], text: &str) -> Result<(), ProgramError> {
    match std::env::var_os(FOLDER) {
        Some(folder) if !folder.is_empty() => files::write(folder.as_ref(), program, axes_on, text),
        _ => Ok(()),
    }
}

/// Nothing: browsers have no folders.
#[cfg(target_arch = "wasm32")]
pub(crate) fn write(_: &str, _: &[&str], _: &str) -> Result<(), ProgramError> {
    Ok(())
}

#[cfg(not(target_arch = "wasm32"))]
mod files {
    use super::{FOLDER, ProgramError};
    use std::fs;
    use std::path::Path;

    pub fn write(folder: &Path, program: &str, axes_on: &[&str], text: &str) -> Result<(), ProgramError> {
        let file = folder.join(name(program, axes_on));
        fs::create_dir_all(folder).and_then(|()| fs::write(file, text)).map_err(|error| ProgramError::Dump {
            pass: program.to_owned(),
            folder: folder.display().to_string(),
            variable: FOLDER,
            message: error.to_string(),
        })
    }

    /// The name of a file. An effect's is the user's, and may have anything in it.
    fn name(program: &str, axes_on: &[&str]) -> String {
        let mut axes = axes_on.to_vec();
        axes.sort_unstable();
        let is_kept = |letter: char| letter.is_alphanumeric() || ['_', '-', '.'].contains(&letter);
        let name = [&[program], &axes[..], &["wgsl"]].concat().join(".");
        name.chars().map(|letter| if is_kept(letter) { letter } else { '_' }).collect()
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn files_are_called_like_programs_and_axes() {
            assert_eq!(name("geometry", &[]), "geometry.wgsl");
            assert_eq!(name("forward", &["textures", "skins"]), "forward.skins.textures.wgsl");
            assert_eq!(name("effect.a/b c", &[]), "effect.a_b_c.wgsl");
        }

        #[test]
        fn texts_are_written_and_errors_name_the_folder() {
            let folder = std::env::temp_dir().join(format!("manypass_dump_{}", std::process::id()));
            let inner = folder.join("of/shaders");
            write(&inner, "meter", &[], "fn f() {}\n").unwrap();
            assert_eq!(fs::read_to_string(inner.join("meter.wgsl")).unwrap(), "fn f() {}\n");
            let error = write(&inner.join("meter.wgsl"), "ids", &["masks"], "").unwrap_err().to_string();
            assert!(error.contains("meter.wgsl") && error.contains("`ids`") && error.contains(FOLDER), "{error}");
            fs::remove_dir_all(&folder).unwrap();
        }
    }
}
