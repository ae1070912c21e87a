//! Loads every model of the shared assets. Without that folder the tests are skipped.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use manypass_scene::{LoadError, LoadedScene, Scene, gltf_file};
use manypass_testkit::needs::{assets, assets_folder};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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
fn load(path: &Path) -> Result<LoadedScene, LoadError> {
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
    let Some(assets) = assets("") else { return };
    let (mut loaded, mut refused) = (0, Vec::new());
    for path in models(&assets) {
        let relative = path.strip_prefix(&assets).unwrap();
        if relative.starts_with("khronos-validator") || relative.starts_with("assimp") {
            continue;
        }
        let start = Instant::now();
        if let Some((_, place)) = REFUSED_REPORTS.iter().find(|(file, _)| relative == Path::new(file)) {
            let error = load(&path).unwrap_err();
            check_error(&error, &relative.to_string_lossy());
            assert!(matches!(&error, LoadError::Invalid { pointer, .. } if pointer == place), "{error}");
            continue;
        }
        match load(&path) {
            Ok(LoadedScene { mut scene, warnings }) => {
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
    // What is here needs nothing that is not ratified.
    assert_eq!(refused, [""; 0], "of {loaded}");
    assert!(loaded > 50);
}

/// Reports whose files must be refused, and the place that the error names.
const REFUSED_REPORTS: [(&str, &str); 1] = [("reports/ok_cycle_of_nodes_refused.glb", "/nodes/0")];

/// Codes of the validator that leave nothing sensible to draw; a file with one of them is refused.
const FATAL: [&str; 14] = [
    "ACCESSOR_JOINTS_INDEX_OOB",
    "ASSET_MIN_VERSION_GREATER_THAN_VERSION",
    "GLB_CHUNK_TOO_BIG",
    "GLB_DUPLICATE_CHUNK",
    "GLB_LENGTH_MISMATCH",
    "GLB_LENGTH_TOO_SMALL",
    "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
    "GLB_UNEXPECTED_END_OF_HEADER",
    "GLB_UNEXPECTED_FIRST_CHUNK",
    "INVALID_JSON",
    "NODE_PARENT_OVERRIDE",
    "ROTATION_NON_UNIT",
    "UNKNOWN_ASSET_MAJOR_VERSION",
    "UNUSED_EXTENSION_REQUIRED",
];

/// Codes of what is broken beyond repair. A file is refused for it where it is shown, and is loaded with a warning
/// where nothing that is shown needs it, which in nearly all files of the validator nothing does.
const FATAL_IF_SHOWN: [&str; 22] = [
    "ACCESSOR_ANIMATION_INPUT_NEGATIVE",
    "ACCESSOR_ANIMATION_INPUT_NON_INCREASING",
    "ACCESSOR_SMALL_BYTESTRIDE",
    "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
    "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT",
    "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT",
    "ARRAY_TYPE_MISMATCH",
    "BUFFER_BYTE_LENGTH_MISMATCH",
    "BUFFER_VIEW_TOO_LONG",
    "INVALID_IBM_ACCESSOR_COUNT",
    "INVALID_URI",
    "IO_ERROR",
    "MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT",
    "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH",
    "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
    "SKIN_IBM_INVALID_FORMAT",
    // Nodes that are shown without their parents.
    "SCENE_NON_ROOT_NODE",
    "TYPE_MISMATCH",
    "UNDEFINED_PROPERTY",
    "UNRESOLVED_REFERENCE",
    // Some files with these two have nothing that is broken; they are named in `EXCEPTIONS`.
    "UNSATISFIED_DEPENDENCY",
    "EMPTY_ENTITY",
];

/// Files whose scene needs what such a code tells of, or that are no files of glTF without it; they are refused.
const NEEDED: [&str; 14] = [
    "/asset/empty_array.gltf",
    "/buffer/invalid_object.gltf",
    "/glb/empty_json_object.glb",
    "/json/invalid_object.gltf",
    "/mesh_data/joints_no_weights.gltf",
    "/node/unresolved_child_node.gltf",
    "/node/unresolved_light_empty_root_array.gltf",
    "/node/unresolved_light_empty_root_ext.gltf",
    "/node/unresolved_mesh.gltf",
    "/root/invalid_array_elements.gltf",
    "/root/invalid_collection_type.gltf",
    "/scene/unresolved_child_node.gltf",
    "/scene/unresolved_default_scene.gltf",
    "/scene/unresolved_node.gltf",
];

/// Files whose verdict does not follow from their codes: whether they load, and why.
const EXCEPTIONS: [(&str, bool, &str); 17] = [
    ("json/bom.gltf", true, "a byte order mark is easily passed over"),
    ("image/invalid_data_uri.gltf", true, "the image is white, with a warning"),
    ("image/invalid_data_uri_mime_type.gltf", true, "the bytes tell the format"),
    ("image/missing_mime_type_buffer_view.gltf", true, "the bytes tell the format"),
    ("node/skin_with_no_mesh.gltf", true, "a skin without a mesh moves nothing"),
    ("root/extensions_non_objects.gltf", true, "nobody reads these extensions"),
    ("light/empty_object.gltf", true, "no light is no light"),
    ("KHR_lights_punctual/data/node/empty_object.gltf", true, "no light is no light"),
    ("variant/empty_object.gltf", true, "a variant without a name has its number"),
    // Empty arrays hold nothing, so that nothing is missing.
    ("accessor/empty_array.gltf", true, "empty"),
    ("camera/empty_array.gltf", true, "empty"),
    ("image/empty_array.gltf", true, "empty"),
    ("data/node/empty_", true, "empty"),
    ("scene/empty_array.gltf", true, "empty"),
    ("skin/empty_array.gltf", true, "empty"),
    ("texture/empty_array.gltf", true, "empty"),
    ("light/empty_lights_array.gltf", true, "empty"),
];

#[test]
fn every_file_of_the_validator_gets_the_verdict_that_its_errors_deserve() {
    let Some(validator) = assets("khronos-validator") else { return };
    let expected = std::fs::read(validator.join("expected.json")).unwrap();
    let expected: Vec<serde_json::Value> = serde_json::from_slice(&expected).unwrap();
    let (mut wrong, mut loaded_count) = (Vec::new(), 0);
    for entry in &expected {
        let file = entry["file"].as_str().unwrap();
        let codes: Vec<&str> = entry["codes"].as_array().unwrap().iter().filter_map(|code| code.as_str()).collect();
        let exception = EXCEPTIONS.iter().find(|(part, ..)| file.contains(part));
        let has = |list: &[&str]| codes.iter().any(|code| list.contains(code));
        let is_broken = exception.is_none() && has(&FATAL_IF_SHOWN);
        let is_needed = NEEDED.iter().any(|part| file.ends_with(part));
        let is_fatal = has(&FATAL) || (is_broken && is_needed);
        let should_load = exception.map_or(!is_fatal, |exception| exception.1);
        let result = load(&assets_folder().join(file));
        // That nothing is drawn says nothing of what is broken.
        let tells = |loaded: &LoadedScene| loaded.warnings.iter().any(|warning| !warning.contains("draws nothing"));
        let is_silent = is_broken && result.as_ref().is_ok_and(|loaded| !tells(loaded));
        if result.is_ok() != should_load || is_silent {
            wrong.push(format!("{file}: {codes:?}: {:?}", result.as_ref().map(|loaded| &loaded.warnings)));
        }
        match result {
            Ok(loaded) => {
                check_invariants(&loaded.scene);
                assert!(loaded.warnings.iter().all(|warning| !warning.is_empty() && !warning.contains('\n')), "{file}");
                loaded_count += 1;
            }
            Err(error) => check_error(&error, file),
        }
    }
    println!("{} files: {loaded_count} load, {} are refused", expected.len(), expected.len() - loaded_count);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// An error is one line that names the file and, unless all of it is broken, the place.
fn check_error(error: &LoadError, file: &str) {
    let text = error.to_string();
    let name = file.rsplit('/').next().unwrap();
    assert!(text.contains(name) && !text.contains('\n') && text.len() < 500, "{text}");
    if let LoadError::Invalid { pointer, message, .. } = error {
        assert!(pointer.starts_with('/') || message.contains("GLB") || message.contains("JSON"), "{text}");
        assert!(!message.is_empty() && !text.contains(": :") && !text.contains("\"\""), "{text}");
    }
}

#[test]
fn broken_models_of_assimp_are_refused_or_warned_of() {
    let Some(folder) = assets("assimp") else { return };
    // In `IncorrectVertexArrays` the broken accessors are those of nothing that is drawn; what is drawn is in order.
    let refused = [
        "IndexOutOfRange/AllIndicesOutOfRange.gltf",
        "IndexOutOfRange/IndexOutOfRange.gltf",
        "MissingBin/BoxTextured.gltf",
        "RecursiveNodes/RecursiveNodes.gltf",
        "SchemaFailures/sceneWrongType.gltf",
        "TestNoRootNode/NoScene.gltf",
        "wrongTypes/badArray.gltf",
        "wrongTypes/badExtension.gltf",
        "wrongTypes/badNumber.gltf",
        "wrongTypes/badObject.gltf",
        "wrongTypes/badUint.gltf",
    ];
    let mut found = Vec::new();
    for path in models(&folder) {
        let file = path.strip_prefix(&folder).unwrap().to_string_lossy().into_owned();
        match load(&path) {
            Ok(loaded) => {
                check_invariants(&loaded.scene);
                // There the name of a scene is a number, and nobody reads it.
                assert!(!loaded.warnings.is_empty() || file == "wrongTypes/badString.gltf", "{file}");
            }
            Err(error) => {
                check_error(&error, &file);
                found.push(file);
            }
        }
    }
    assert_eq!(found, refused);
}
