//! Loads every model of the shared assets. Without that folder the tests say so and pass.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use manypass_scene::{LoadError, Loaded, Scene, gltf_file};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn assets() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
    if !folder.is_dir() {
        println!("SKIPPED: there are no shared assets");
        return None;
    }
    Some(folder)
}

fn models(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut pending) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                pending.push(path);
            } else if path.extension().is_some_and(|end| end == "gltf" || end == "glb") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Loads on another thread, so that a panic or an endless loop fails with the model's name.
fn load(path: &Path) -> Result<Loaded, LoadError> {
    let (sender, receiver) = std::sync::mpsc::channel();
    let owned = path.to_owned();
    std::thread::spawn(move || {
        // Nobody listens any more once the time is up.
        let _ = sender.send(gltf_file::load_path(&owned));
    });
    match receiver.recv_timeout(Duration::from_secs(60)) {
        Ok(result) => result,
        Err(error) => panic!("{}: panicked or took over 60 s: {error}", path.display()),
    }
}

fn check_invariants(scene: &Scene) {
    for primitive in scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let count = primitive.positions.len();
        let lengths = [
            primitive.normals.len(),
            primitive.tangents.len(),
            primitive.uv0.len(),
            primitive.uv1.len(),
            primitive.colors.len(),
            primitive.joints.len(),
            primitive.weights.len(),
        ];
        assert!(lengths.into_iter().all(|length| length == 0 || length == count));
        assert!(primitive.indices.iter().all(|&index| (index as usize) < count));
        assert!(primitive.positions.iter().flatten().all(|value| value.is_finite()));
        assert!(primitive.material.is_none_or(|material| material < scene.materials.len()));
    }
    assert!(scene.textures.iter().all(|texture| texture.image < scene.images.len()));
}

#[test]
fn every_model_loads_or_names_what_it_requires() {
    let Some(assets) = assets() else { return };
    let (mut loaded, mut refused) = (0, Vec::new());
    for path in models(&assets) {
        let relative = path.strip_prefix(&assets).unwrap();
        if relative.starts_with("khronos-validator") || relative.starts_with("assimp") {
            continue;
        }
        let start = Instant::now();
        match load(&path) {
            Ok(Loaded { mut scene, warnings }) => {
                check_invariants(&scene);
                for animation in 0..scene.animations.len() {
                    scene.pose(animation, 0.5 * scene.animations[animation].duration_secs());
                }
                scene.update_transforms();
                let draws = !warnings.iter().any(|warning| warning.contains("draws nothing"));
                assert_eq!(scene.posed_bounds_world().is_empty(), !draws, "{}", relative.display());
                loaded += 1;
            }
            Err(LoadError::UnsupportedExtension { extension, .. }) => {
                assert!(!gltf_file::SUPPORTED_EXTENSIONS.contains(&extension.as_str()));
                refused.push(format!("{}: {extension}", relative.display()));
            }
            Err(error) => panic!("{error}"),
        }
        assert!(start.elapsed() < Duration::from_secs(30), "{} is slow", relative.display());
    }
    println!("{loaded} loaded, refused: {refused:#?}");
    assert!(loaded > 50);
}

/// Codes of the validator that leave nothing sensible to draw.
const STRUCTURAL: [&str; 16] = [
    "UNRESOLVED_REFERENCE",
    "TYPE_MISMATCH",
    "ARRAY_TYPE_MISMATCH",
    "INVALID_JSON",
    "GLB_UNEXPECTED_FIRST_CHUNK",
    "GLB_UNEXPECTED_END_OF_HEADER",
    "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
    "GLB_CHUNK_TOO_BIG",
    "GLB_DUPLICATE_CHUNK",
    "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
    "ACCESSOR_SMALL_BYTESTRIDE",
    "BUFFER_VIEW_TOO_LONG",
    "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
    "NODE_PARENT_OVERRIDE",
    "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT",
    "UNKNOWN_ASSET_MAJOR_VERSION",
];

#[test]
fn structural_errors_of_the_validator_set_are_reported() {
    let Some(assets) = assets() else { return };
    let expected = std::fs::read(assets.join("khronos-validator/expected.json")).unwrap();
    let expected: Vec<serde_json::Value> = serde_json::from_slice(&expected).unwrap();
    let mut silent = Vec::new();
    for entry in expected {
        let file = entry["file"].as_str().unwrap();
        let result = load(&assets.join(file));
        if let Ok(loaded) = &result {
            check_invariants(&loaded.scene);
        }
        let codes = entry["codes"].as_array().unwrap();
        let structural = codes.iter().any(|code| STRUCTURAL.contains(&code.as_str().unwrap()));
        // An empty scene always warns, so that only other warnings count.
        let reported =
            result.as_ref().map_or(true, |loaded| loaded.warnings.iter().any(|w| !w.contains("draws nothing")));
        if structural && !reported {
            silent.push(format!("{file}: {codes:?}"));
        }
        if entry["errors"] == 0
            && let Err(error) = result
            && !matches!(error, LoadError::UnsupportedExtension { .. })
        {
            println!("valid, yet refused: {error}");
        }
    }
    assert!(silent.is_empty(), "{silent:#?}");
}

#[test]
fn broken_models_of_assimp_are_refused() {
    let Some(assets) = assets() else { return };
    for path in models(&assets.join("assimp")) {
        match load(&path) {
            Ok(loaded) => {
                check_invariants(&loaded.scene);
                println!("{} loads with {:?}", path.display(), loaded.warnings);
            }
            Err(error) => println!("{error}"),
        }
    }
    for file in [
        "RecursiveNodes/RecursiveNodes.gltf",
        "IndexOutOfRange/IndexOutOfRange.gltf",
        "IndexOutOfRange/AllIndicesOutOfRange.gltf",
        "MissingBin/BoxTextured.gltf",
    ] {
        assert!(load(&assets.join("assimp").join(file)).is_err(), "{file}");
    }
}
