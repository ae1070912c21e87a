//! Every model of the shared files is drawn but for those of `models.rs`, which compares pictures of the sample models,
//! and those of the broken sets, which the command line's tests go through.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{self, framed, ids, skies};
use glam::Vec3;
use manypass::{Aov, FrameRequest};
use manypass_scene::{Aabb, formats};
use manypass_testkit::needs::{assets, assets_folder};
use std::path::{Path, PathBuf};

const SIZE_PX: u32 = 48;

/// They have tests of their own.
const FOLDERS_ELSEWHERE: [&str; 4] = ["khronos-validator", "khronos-sample-assets", "assimp", "hostile"];

/// Models of which next to nothing is seen, and why.
const SPARSE: [(&str, &str); 2] =
    [("mtl_tr_1_alone.obj", "its material lets all through, with a warning"), ("gaussian_splat_header.ply", "points")];

/// Models that are refused, and a word of the error.
const REFUSED: [(&str, &str); 1] = [("ok_cycle_of_nodes_refused.glb", "/nodes/0")];

/// Models in which there is nothing to see, and why.
const EMPTY: [(&str, &str); 1] = [("four_spotlights.glb", "it has lights alone")];

/// Files with one of these ends, in order.
fn files(ends: &[&str]) -> Vec<PathBuf> {
    let (mut folders, mut found) = (vec![assets_folder()], Vec::new());
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() && !FOLDERS_ELSEWHERE.iter().any(|name| path.ends_with(name)) {
                folders.push(path);
            } else if path.extension().is_some_and(|end| ends.iter().any(|known| end.eq_ignore_ascii_case(known))) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// How many pixels show something; none where there is nothing to see.
fn seen(renderer: &mut manypass::Renderer, path: &Path) -> Result<Option<usize>, String> {
    let mut scene = formats::load_path(path).map_err(|error| error.to_string())?.scene;
    scene.update_transforms();
    let bounds = scene.posed_bounds_world();
    let seen = if bounds.is_empty() { Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE } } else { bounds };
    renderer.load(&scene).map_err(|error| error.to_string())?;
    let mut request = FrameRequest::new(SIZE_PX, SIZE_PX, framed(&seen));
    request.settings.shadows.enabled = false;
    request.settings.aov.first_surface = true;
    request.want_aovs = vec![Aov::ObjectId];
    renderer.render(&scene, &request).map_err(|error| error.to_string())?;
    let count = ids(renderer.read_aov(Aov::ObjectId).unwrap()).into_iter().filter(|id| *id != 0).count();
    Ok((!bounds.is_empty()).then_some(count))
}

#[test]
fn every_file_is_drawn() {
    if assets("bevy").is_none() {
        return;
    }
    let started = std::time::Instant::now();
    let mut renderer = common::renderer();
    let mut wrong = Vec::new();
    let models = files(&["gltf", "glb", "obj", "ply", "stl", "3mf"]);
    for path in &models {
        let model_started = started.elapsed();
        let reason = EMPTY.iter().find(|(name, _)| path.ends_with(name)).map(|(_, reason)| reason);
        match (seen(&mut renderer, path), reason) {
            (Ok(None), Some(reason)) => println!("{}: nothing to see, {reason}", path.display()),
            (Ok(None), None) => wrong.push(format!("{}: nothing to see", path.display())),
            (Ok(Some(_)), Some(reason)) => wrong.push(format!("{}: something to see, though {reason}", path.display())),
            (Ok(Some(count)), None) if count > 20 || SPARSE.iter().any(|(name, _)| path.ends_with(name)) => (),
            (Ok(Some(count)), None) => wrong.push(format!("{}: {count} pixels show something", path.display())),
            (Err(error), _) if REFUSED.iter().any(|(name, said)| path.ends_with(name) && error.contains(said)) => (),
            (Err(error), _) => wrong.push(error),
        }
        println!("{}: {:.2} s", path.display(), (started.elapsed() - model_started).as_secs_f32());
    }
    // Those are drawn, and measured, in `environment_lobes.rs`.
    let environments = files(&["hdr", "exr"]);
    for path in &environments {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        assert!(skies::FILES.contains(&&*name), "{name} is measured in no test");
    }
    let count = models.len() + environments.len();
    println!("{count} files in {:.1} s", started.elapsed().as_secs_f32());
    assert!(count > 25, "{count} files");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
