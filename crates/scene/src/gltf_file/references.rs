//! Which files a model names, without reading them.

use super::container::{self, decoded_uri};
use super::{LoadError, MAX_FILE_BYTES, checked_relative_path, read_file};
use serde_json::Value;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The header of a GLB and that of its first chunk, in bytes.
const GLB_HEADERS_BYTES: usize = 20;

/// The files that [`super::load_path`] would read beside the model at `path`: those of its buffers, then those of its
/// images, whether they are there or not. Data URIs, and places outside the model's folder, are none. Of a `.glb` only
/// the JSON is read.
///
/// # Errors
/// If the model cannot be read or is no JSON. What else may be wrong with it is not looked at.
pub fn references(path: &Path) -> Result<Vec<PathBuf>, LoadError> {
    let name = path.display().to_string();
    let json = read_json(path).map_err(|message| LoadError::Io { file: name.clone(), message })?;
    if !may_name_files(&json) {
        return Ok(Vec::new());
    }
    let root: Value = serde_json::from_slice(&json).map_err(|error| LoadError::Invalid {
        file: name,
        pointer: String::new(),
        message: format!("not a glTF file: its JSON does not parse: {error}"),
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let objects = ["buffers", "images"].into_iter().filter_map(|key| root.get(key)?.as_array()).flatten();
    let uris = objects.filter_map(|object| object.get("uri")?.as_str());
    let files = uris.filter_map(|uri| {
        let decoded = decoded_uri(uri).ok()?;
        checked_relative_path(&decoded).ok().map(|file| folder.join(file))
    });
    Ok(files.collect())
}

/// The JSON of a model, or the whole file if that is not a GLB.
fn read_json(path: &Path) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| format!("cannot read \"{}\": {error}", path.display());
    let metadata = std::fs::metadata(path).map_err(cannot)?;
    if !metadata.is_file() || metadata.len() > MAX_FILE_BYTES {
        return read_file(path);
    }
    let mut file = File::open(path).map_err(cannot)?;
    let mut bytes = Vec::new();
    file.by_ref().take(GLB_HEADERS_BYTES as u64).read_to_end(&mut bytes).map_err(cannot)?;
    let json_bytes = match bytes.get(12..16) {
        Some(&[a, b, c, d]) if bytes.starts_with(container::GLB_MAGIC) => u64::from(u32::from_le_bytes([a, b, c, d])),
        _ => u64::MAX,
    };
    file.take(json_bytes).read_to_end(&mut bytes).map_err(cannot)?;
    let header_bytes = if bytes.starts_with(container::GLB_MAGIC) { GLB_HEADERS_BYTES.min(bytes.len()) } else { 0 };
    bytes.drain(..header_bytes);
    let mark_bytes = if bytes.starts_with(container::BYTE_ORDER_MARK) { container::BYTE_ORDER_MARK.len() } else { 0 };
    bytes.drain(..mark_bytes);
    Ok(bytes)
}

/// False only where no object can have a `uri`: most .glb files, whose JSON then need not be parsed. A key may be
/// written with escapes.
fn may_name_files(json: &[u8]) -> bool {
    json.windows(4).any(|bytes| bytes == b"uri\"") || json.windows(2).any(|bytes| bytes == b"\\u")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(json: &str) -> Vec<u8> {
        let mut bytes = b"glTF".to_vec();
        for word in [2, 20 + json.len() as u32 + 4, json.len() as u32, 0x4e4f_534a] {
            bytes.extend(u32::to_le_bytes(word));
        }
        bytes.extend(json.as_bytes());
        bytes.extend(b"uri\"");
        bytes
    }

    #[test]
    fn buffers_and_images_are_listed_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("manypass-references-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let json = r#"{"buffers":[{"uri":"a.bin"},{"uri":"data:,x"},{}],
            "images":[{"uri":"in/b%20c.png"},{"\u0075ri":"d.png"},{"uri":"../e.png"},{"uri":"http://f/g.png"},{"uri":5}]}"#;
        let expected = ["a.bin", "in/b c.png", "d.png"].map(|name| folder.join(name));
        for (name, bytes) in [
            ("plain.gltf", json.as_bytes().to_vec()),
            ("marked.gltf", [container::BYTE_ORDER_MARK, json.as_bytes()].concat()),
            ("binary.glb", glb(json)),
        ] {
            std::fs::write(folder.join(name), bytes).expect("written");
            assert_eq!(references(&folder.join(name)).expect(name), expected, "{name}");
        }
        for (name, bytes) in [("bare.glb", glb("{}")), ("cut.glb", b"glTF".to_vec()), ("empty.gltf", Vec::new())] {
            std::fs::write(folder.join(name), bytes).expect("written");
            assert_eq!(references(&folder.join(name)).expect(name), Vec::<PathBuf>::new(), "{name}");
        }
        std::fs::write(folder.join("broken.gltf"), b"{\"uri\":").expect("written");
        assert!(references(&folder.join("broken.gltf")).is_err());
        assert!(references(&folder.join("gone.gltf")).is_err() && references(&folder).is_err());
        let _ = std::fs::remove_dir_all(folder);
    }
}
