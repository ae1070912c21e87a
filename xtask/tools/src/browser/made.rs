//! Files that are written for the browser's tests: a page is given one file of a model, and nothing beside it.

use crate::step::{check, program, root};
use anyhow::{Context, Result};
use manypass_testkit::data_uri;
use manypass_testkit::ktx2::cube_map;
use serde_json::Value;
use std::cell::Cell;
use std::path::{Path, PathBuf};

/// A picture of the environment as a cube map, seen from the repository.
pub(super) const CUBE: &str = "target/browser/cube.ktx2";
/// The texels along a side of its faces.
const SIDE: u32 = 32;

/// A file that the program bakes, seen from the repository.
pub(super) const BAKED: &str = "target/browser/baked.glb";

/// Others, with probes in place of maps.
pub(super) const PROBES: &str = "target/browser/probes.glb";
pub(super) const CUBES: &str = "target/browser/ambient_cubes.glb";

/// Another, whose probes frames find the light of.
pub(super) const LIVE_PROBES: &str = "target/browser/live_probes.stage.toml";
const LIVE_STAGE: &str = "model = \"demo:cornell\"\n[[probes]]\ncounts = [2, 2, 2]\nbounces = 8\n";

/// Writes the Cornell box as a case has it, if it is one that is made.
///
/// # Errors
/// It cannot be written.
pub(super) fn write_cornell(model: &str) -> Result<()> {
    let what = match model {
        BAKED => "lightmap,occlusion",
        PROBES => "probes",
        CUBES => "ambient-cubes",
        LIVE_PROBES => return write(&root().join(model), LIVE_STAGE.as_bytes()),
        _ => return Ok(()),
    };
    // One of an earlier version would not be replaced.
    let _ = std::fs::remove_file(root().join(model).with_extension("stage.toml"));
    let mut command = program()?;
    command.args(["bake", "demo:cornell", "-o", model]);
    // Directions lie in the same texture as light, which has no other test in browsers; nothing of the box is bent.
    command.args(if model == BAKED { &["--directional"][..] } else { &[] });
    check(command.args(["--what", what, "--density", "32", "--samples", "64", "--quiet"]))
}

/// Writes [`CUBE`]: a colour for each face, squares on it, and one bright corner each, so that a face that is turned or
/// mistaken for another is seen.
///
/// # Errors
/// It cannot be written.
pub(super) fn write_cube() -> Result<()> {
    const COLORS: [[u8; 3]; 6] =
        [[200, 60, 50], [50, 160, 170], [150, 180, 240], [90, 70, 50], [220, 190, 80], [120, 60, 170]];
    // Red, green, blue and alpha as plain bytes.
    const R8G8B8A8_SRGB: u32 = 43;
    let count = Cell::new(0);
    let bytes = cube_map(R8G8B8A8_SRGB, SIDE, 1, |_| {
        let place = count.replace(count.get() + 1);
        let (face, x, y) = (place / (SIDE * SIDE), place % SIDE, place / SIDE % SIDE);
        let is_corner = x < SIDE / 4 && y < SIDE / 4;
        let is_dark = (x / 8 + y / 8) % 2 == 1;
        let [r, g, b] = COLORS[face as usize].map(|value| {
            if is_corner {
                255
            } else if is_dark {
                value / 2
            } else {
                value
            }
        });
        vec![r, g, b, 255]
    });
    write(&root().join(CUBE), &bytes)
}

/// A .gltf whose buffers and images are in it: itself if they are, else a copy in `target/browser`. Other files are
/// left alone.
///
/// # Errors
/// It cannot be read or written.
pub(super) fn whole(path: PathBuf, name: &str) -> Result<PathBuf> {
    if path.extension().is_none_or(|extension| extension != "gltf") {
        return Ok(path);
    }
    let read = |path: &Path| std::fs::read(path).with_context(|| format!("reading {}", path.display()));
    let mut json: Value =
        serde_json::from_slice(&read(&path)?).with_context(|| format!("reading {}", path.display()))?;
    let mut is_whole = true;
    for kind in ["buffers", "images"] {
        for part in json[kind].as_array_mut().into_iter().flatten() {
            let Some(uri) = part["uri"].as_str().filter(|uri| !uri.starts_with("data:")) else { continue };
            is_whole = false;
            let mime = match uri.rsplit('.').next() {
                Some("png") => "image/png",
                Some("jpg" | "jpeg") => "image/jpeg",
                Some("ktx2") => "image/ktx2",
                _ => "application/octet-stream",
            };
            part["uri"] = data_uri(mime, &read(&path.with_file_name(uri))?).into();
        }
    }
    if is_whole {
        return Ok(path);
    }
    let copy = root().join(format!("target/browser/{name}.gltf"));
    write(&copy, json.to_string().as_bytes())?;
    Ok(copy)
}

/// Writes a stage that draws `items` over the model at `model`; gives its path.
///
/// # Errors
/// It cannot be written.
pub(super) fn write_stage(name: &str, model: &str, items: &Value) -> Result<String> {
    // Values of JSON are values of TOML.
    let mut text = format!("model = {}\n", Value::from(model));
    for item in items.as_array().into_iter().flatten().filter_map(Value::as_object) {
        text.push_str("[[overlay]]\n");
        for (key, value) in item {
            text.push_str(&format!("{key} = {value}\n"));
        }
    }
    let path = root().join(format!("target/browser/{name}.stage.toml"));
    write(&path, text.as_bytes())?;
    Ok(path.display().to_string())
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let failed = || format!("writing {}", path.display());
    std::fs::create_dir_all(root().join("target/browser")).with_context(failed)?;
    std::fs::write(path, bytes).with_context(failed)
}
