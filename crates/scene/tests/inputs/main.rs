//! What the readers of OBJ, STL, PLY and 3MF make of files, right and wrong ones.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

mod far;
mod forgiving;
mod obj;
mod ply;
mod stl;
mod threemf;

use manypass_scene::{LoadError, LoadedScene, Primitive, load_bytes};
use std::collections::BTreeMap;

/// A model without files beside it.
fn load(name: &str, bytes: &[u8]) -> Result<LoadedScene, LoadError> {
    load_bytes(bytes, &mut |uri| Err(format!("there is no {uri}")), name)
}

/// A model with files beside it.
fn load_with(name: &str, bytes: &[u8], files: &[(&str, &[u8])]) -> LoadedScene {
    let files: BTreeMap<&str, &[u8]> = files.iter().copied().collect();
    let mut resolve =
        |uri: &str| files.get(uri).map(|bytes| bytes.to_vec()).ok_or_else(|| format!("there is no {uri}"));
    load_bytes(bytes, &mut resolve, name).unwrap()
}

/// The error of a file that is refused.
#[track_caller]
fn refusal(name: &str, bytes: &[u8]) -> String {
    match load(name, bytes) {
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with(name) && !message.contains('\n'), "{message}");
            message
        }
        Ok(loaded) => panic!("{name} is read: {:?}", loaded.warnings),
    }
}

/// All primitives, of the meshes in their order.
fn primitives(loaded: &LoadedScene) -> Vec<&Primitive> {
    loaded.scene.meshes.iter().flat_map(|mesh| &mesh.primitives).collect()
}

/// Every attribute is empty or as long as the positions, indices are below that, and nothing is without end.
fn check(loaded: &LoadedScene) {
    for primitive in primitives(loaded) {
        let count = primitive.positions.len();
        let lengths = [
            primitive.normals.len(),
            primitive.tangents.len(),
            primitive.uv0.len(),
            primitive.uv1.len(),
            primitive.colors.len(),
        ];
        assert!(lengths.iter().all(|length| [0, count].contains(length)), "{lengths:?} of {count}");
        assert!(primitive.indices.iter().all(|&index| (index as usize) < count));
        assert!(primitive.positions.iter().chain(&primitive.normals).flatten().all(|value| value.is_finite()));
        assert!(primitive.material.is_some_and(|material| material < loaded.scene.materials.len()));
    }
}

/// Changes bytes of `file`, cuts it, or repeats a part: whatever comes of it, reading ends without a panic.
fn survives(name: &str, file: &[u8], changes: &[(usize, u8)], cut: usize) {
    let mut bytes = file.to_vec();
    for &(place, byte) in changes {
        let place = place % bytes.len();
        bytes[place] = byte;
    }
    for bytes in [&bytes[..], &bytes[..cut % (bytes.len() + 1)]] {
        if let Ok(loaded) = load(name, bytes) {
            check(&loaded);
        }
    }
}
