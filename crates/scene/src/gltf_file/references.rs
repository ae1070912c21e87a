//! Which files a model names, without reading them.

use super::container::{self, decoded_uri, percent_decode};
use super::error::LoadError;
use super::files::{MAX_FILE_BYTES, checked_relative_path, read_file};
use serde_json::Value;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// The header of a GLB and that of its first chunk, in bytes.
const GLB_HEADERS_BYTES: usize = 20;

/// The files that [`super::load_path`] would read beside the model at `path`: those of its buffers, then those of its
/// images, whether they are there or not. Data URIs, and places outside the model's folder, are none. Of a `.glb` only
/// the JSON is read.
///
/// # Errors
/// If the model cannot be read or is no JSON. What else may be wrong with it is not looked at.
pub fn references(path: &Path) -> Result<Vec<PathBuf>, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let uris = uris(path)?;
    let files = uris.iter().filter_map(|uri| {
        let decoded = decoded_uri(uri).ok()?;
        checked_relative_path(&decoded).ok().map(|file| folder.join(file))
    });
    Ok(files.collect())
}

/// Every path that a buffer or an image of the model at `path` could mean, also where [`super::load_path`] refuses to
/// read it: outside the model's folder, absolute, a `file:` URI, with backslashes or with `..` through a folder that is
/// not there. For whoever must not write to any of them. A URI gives one or more paths, whether they are there or not.
///
/// # Errors
/// As [`references`].
pub fn mentions(path: &Path) -> Result<Vec<PathBuf>, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(meant_paths(folder, &uris(path)?))
}

/// Every path that names in a model of this folder may mean.
pub(crate) fn meant_paths(folder: &Path, names: &[String]) -> Vec<PathBuf> {
    let mut paths = Vec::new();
    for name in names {
        for meaning in meanings(name) {
            let file = folder.join(meaning);
            paths.extend([without_dots(&file), file]);
        }
    }
    // Models may name one file often.
    paths.sort();
    paths.dedup();
    paths
}

/// What a URI may mean as a path: as it is written, and without percent signs, scheme, query and fragment, each with
/// backslashes and with slashes. Data URIs and those of other schemes mean none.
fn meanings(uri: &str) -> Vec<String> {
    let prefix = |prefix: &str| uri.get(..prefix.len()).is_some_and(|start| start.eq_ignore_ascii_case(prefix));
    if prefix("data:") {
        return Vec::new();
    }
    let mut found = vec![uri.to_owned()];
    if prefix("file:") {
        let rest = uri.get(5..).unwrap_or_default();
        found.push(rest.to_owned());
        if let Some(rest) = rest.strip_prefix("//") {
            // What stands before the path is the machine; `file://name` is also written for `file:name`.
            found.push(rest.to_owned());
            found.extend(rest.find('/').and_then(|at| rest.get(at..)).map(str::to_owned));
        }
    }
    let cut = |text: &String| text.find(['?', '#']).and_then(|at| text.get(..at)).map(str::to_owned);
    found.extend(found.iter().filter_map(cut).collect::<Vec<_>>());
    let decoded = |text: &String| percent_decode(text).and_then(|bytes| String::from_utf8(bytes).ok());
    found.extend(found.iter().filter(|text| text.contains('%')).filter_map(decoded).collect::<Vec<_>>());
    let slashed = |text: &String| text.contains('\\').then(|| text.replace('\\', "/"));
    found.extend(found.iter().filter_map(slashed).collect::<Vec<_>>());
    found.retain(|text| !text.is_empty() && !text.contains('\0'));
    found
}

/// The path with `..` taken from the names before it, whether those are there or not.
fn without_dots(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(plain.components().next_back(), Some(Component::Normal(_))) => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}

/// The URIs of the buffers, then those of the images.
fn uris(path: &Path) -> Result<Vec<String>, LoadError> {
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
    let objects = ["buffers", "images"].into_iter().filter_map(|key| root.get(key)?.as_array()).flatten();
    Ok(objects.filter_map(|object| object.get("uri")?.as_str().map(str::to_owned)).collect())
}

/// The JSON of a model, or the whole file if that is not a GLB.
fn read_json(path: &Path) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| format!("cannot read \"{}\": {error}", path.display());
    let metadata = std::fs::metadata(path).map_err(cannot)?;
    if !metadata.is_file() || metadata.len() > MAX_FILE_BYTES {
        return read_file(path);
    }
    let mut file =
        crate::input_file::open(path).map_err(|error| format!("cannot read \"{}\": {error}", path.display()))?;
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

    #[test]
    fn every_path_that_a_uri_could_mean_is_mentioned() {
        let folder = std::env::temp_dir().join(format!("manypass-mentions-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("in")).expect("a folder");
        let elsewhere = folder.join("tex/a b.png");
        let absolute = elsewhere.display().to_string();
        let encoded = absolute.replace(' ', "%20");
        for uri in [
            "../tex/a b.png".into(),
            "../tex/a%20b.png?v=1#x".into(),
            "./gone/../../tex/a b.png".into(),
            "..\\\\tex\\\\a b.png".into(),
            absolute,
            format!("file://{encoded}"),
            format!("FILE:{encoded}"),
            format!("file://localhost{encoded}"),
            "file:../tex/a%20b.png".into(),
        ] {
            let model = folder.join("in/m.gltf");
            std::fs::write(&model, format!(r#"{{"images":[{{"uri":"data:,x"}},{{"uri":"{uri}"}}]}}"#))
                .expect("written");
            let found = mentions(&model).expect("read");
            assert!(found.contains(&elsewhere), "{uri}: {found:?}");
            assert!(references(&model).expect("read").is_empty(), "{uri}");
        }
        assert!(meanings("data:,x").is_empty() && meanings("DATA:,x").is_empty());
        let _ = std::fs::remove_dir_all(folder);
    }
}
