//! Where a picture comes from: the files that were read, with their hashes.

use crate::input::Input;
use manypass_scene::stage::{is_stage, named_images, named_model};
use manypass_scene::{formats, input_file};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct InputFile {
    /// Its path, as it was opened.
    pub path: String,
    /// Its length.
    pub bytes: u64,
    /// Its SHA-256 in hexadecimal digits.
    pub sha256: String,
}

impl InputFile {
    fn read(path: &Path) -> Option<Self> {
        let mut file = input_file::open(path).ok()?;
        let mut hash = Sha256::new();
        let mut buffer = vec![0; 1 << 20];
        let mut bytes = 0;
        loop {
            match std::io::Read::read(&mut file, &mut buffer).ok()? {
                0 => break,
                count => {
                    hash.update(buffer.get(..count)?);
                    bytes += count as u64;
                }
            }
        }
        let sha256 = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Some(Self { path: path.display().to_string(), bytes, sha256 })
    }
}

/// The stage if there is one, the model's own file, then those that it names, then images that the stage names; those
/// that cannot be read are left out. Standard input and built-in scenes have none. Last come `lights`, the files of the
/// environment.
pub fn input_files(input: &Input, lights: &[PathBuf]) -> Vec<InputFile> {
    let mut files = model_files(input);
    files.extend(lights.iter().filter_map(|path| InputFile::read(path)));
    files
}

fn model_files(input: &Input) -> Vec<InputFile> {
    let Input::File(path) = input else { return Vec::new() };
    let mut paths = vec![path.clone()];
    paths.extend(Some(path).filter(|path| is_stage(path)).and_then(|path| named_model(path)));
    for reference in paths.last().and_then(|model| formats::references(model).ok()).unwrap_or_default() {
        if !paths.contains(&reference) {
            paths.push(reference);
        }
    }
    if is_stage(path) {
        for image in named_images(path) {
            if !paths.contains(&image) {
                paths.push(image);
            }
        }
    }
    paths.iter().filter_map(|path| InputFile::read(path)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_other_programs() {
        let folder = std::env::temp_dir().join(format!("manypass-provenance-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let json =
            r#"{"buffers":[{"uri":"a%20b.bin"},{"uri":"data:,x"}],"images":[{"uri":"gone.png"},{"uri":"a b.bin"}]}"#;
        std::fs::write(folder.join("m.gltf"), json).expect("written");
        std::fs::write(folder.join("a b.bin"), "abc").expect("written");
        let files = input_files(&Input::File(folder.join("m.gltf")), &[]);
        assert_eq!(files.iter().map(|file| file.bytes).collect::<Vec<_>>(), [json.len() as u64, 3]);
        // The example of FIPS 180-4.
        assert_eq!(files[1].sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        let _ = std::fs::remove_dir_all(folder);
    }
}
