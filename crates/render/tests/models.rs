//! Every sample model, posed by its first animation: clustered lights against brute force, the deferred path against
//! the forward path, and surfaces drawn again against those of the G-buffer.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{self, floats, framed, ids};
use glam::Vec3;
use manypass::{Aov, Environment, FrameRequest, LightCulling, Pose, Renderer, Tonemap};
use manypass_scene::{Aabb, Light, LightKind, Node, Scene, gltf_file};
use manypass_testkit::compare::{Difference, Picture, Tolerance, assert_rejects_mutations, difference};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const SIDE_PX: u32 = 96;

/// Every .glb and .gltf of the sample models, in order; none where they are not on this machine: the test is skipped.
fn models() -> Option<Vec<PathBuf>> {
    let mut folders = vec![common::sample_models()?];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
                found.push(path);
            }
        }
    }
    found.sort();
    Some(found)
}

/// Twenty-four coloured lamps around `bounds`, of ranges that reach a part of it each, so that lists differ by cluster.
fn add_lamps(scene: &mut Scene, bounds: &Aabb) {
    let radius_m = bounds.corners().iter().map(|c| c.distance(bounds.center())).fold(1e-4, f32::max);
    for i in 0..24u32 {
        // The golden angle spreads points over a sphere.
        let y = 1.0 - (2.0 * i as f32 + 1.0) / 24.0;
        let (sin, cos) = (2.399_963 * i as f32).sin_cos();
        let direction = Vec3::new(cos, 0.0, sin) * (1.0 - y * y).sqrt() + Vec3::Y * y;
        let hue = Vec3::new(sin, cos, -sin) * 0.4 + 0.6;
        let light = Some(scene.lights.len());
        scene.lights.push(Light {
            name: String::new(),
            color_linear: hue,
            // About one lux at half the radius.
            intensity: 0.25 * radius_m * radius_m,
            range_m: Some((0.6 + 0.03 * i as f32) * radius_m),
            kind: LightKind::Point,
            ..Light::default()
        });
        let translation = bounds.center() + 0.8 * radius_m * direction;
        scene.add_node(None, Node { translation, light, ..Node::default() });
    }
}

fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Picture {
    renderer.render(scene, request).unwrap();
    Picture::from_rgba8(SIDE_PX as usize, SIDE_PX as usize, &renderer.read_display().unwrap())
}

/// Passes that draw surfaces again hit exactly the pixels of the G-buffer, and what stands still has no motion.
fn assert_drawn_again(renderer: &mut Renderer, path: &Path) {
    let depth = floats(renderer.read_aov(Aov::Depth).unwrap());
    let objects = ids(renderer.read_aov(Aov::ObjectId).unwrap());
    let motion = floats(renderer.read_aov(Aov::Motion).unwrap());
    let missed = depth.iter().zip(&objects).filter(|(depth, id)| depth.is_finite() != (**id != 0)).count();
    assert_eq!(missed, 0, "{}: pixels without their id", path.display());
    let largest = motion.iter().fold(0.0f32, |largest, value| largest.max(value.abs()));
    assert!(largest == 0.0, "{}: stands still, yet moved by {largest} px", path.display());
}

/// Clustered against brute force, and deferred against forward; none for a file that is refused.
fn differences(renderer: &mut Renderer, path: &Path) -> Option<(Difference, Difference)> {
    let mut scene = match gltf_file::load_path(path) {
        Ok(loaded) => loaded.scene,
        Err(error) => {
            println!("refused: {error}");
            return None;
        }
    };
    scene.pose(0, 0.3);
    scene.update_transforms();
    let bounds = scene.posed_bounds_world();
    let bounds = if bounds.is_empty() { Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE } } else { bounds };
    add_lamps(&mut scene, &bounds);
    scene.update_transforms();
    renderer.load(&scene).unwrap();
    let mut request = FrameRequest::new(SIDE_PX, SIDE_PX, framed(&bounds));
    request.settings.environment.source = Environment::Studio;
    request.settings.tone_map.curve = Tonemap::None;
    // The deferred path finds the triangles' planes from distances, so that edges of shadows differ by a part of a
    // texel: `shadows.rs` judges both.
    request.settings.shadows.enabled = false;
    request.settings.tone_map.dither = 0.0;
    request.want_aovs = vec![Aov::Depth, Aov::ObjectId, Aov::Motion];
    request.previous = Some(Arc::new(Pose::capture(&scene, request.camera)));
    let clustered = picture(renderer, &scene, &request);
    assert_drawn_again(renderer, path);
    request.want_aovs.clear();
    let brute_force = request.with(|settings| settings.lights.culling = LightCulling::None);
    let brute_force = picture(renderer, &scene, &brute_force);
    let forward = picture(renderer, &scene, &request.with(|settings| settings.render.path = manypass::Path::Forward));
    if path.ends_with("DamagedHelmet.glb") {
        assert_rejects_mutations(&clustered, Tolerance::default());
        let half = FrameRequest { light_subset: Some((0, 2)), ..request.clone() };
        let half = picture(renderer, &scene, &half);
        assert!(!difference(&clustered, &half, 2).is_within(Tolerance::default()), "lamps make no difference");
    }
    Some((difference(&clustered, &brute_force, 1), difference(&clustered, &forward, 2)))
}

#[test]
fn every_model_is_the_same_clustered_and_forward() {
    let started = std::time::Instant::now();
    // Sums in another order round differently: one level, hardly ever.
    let exact = Tolerance { within: 1, share: 1.0, share_between: 1.0, mean: 0.01, ..Tolerance::default() };
    // Base colour and roughness have 8 bits in the G-buffer: half a step is up to 0.5/255 of a lit surface.
    let eight_bits = Tolerance::default();
    let Some(models) = models() else { return };
    let mut renderer = common::renderer();
    let (mut compared, mut wrong) = (0, Vec::new());
    let mut worst: Option<(f64, String)> = None;
    for path in models {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let Some((culling, shading)) = differences(&mut renderer, &path) else { continue };
        compared += 1;
        if !culling.is_within(exact) {
            wrong.push(format!("{name}: clustered against brute force: {culling}; {:?}", culling.worst));
        }
        if !shading.is_within(eight_bits) {
            wrong.push(format!("{name}: deferred against forward: {shading}; {:?}", shading.worst));
        }
        if worst.as_ref().is_none_or(|(share, _)| shading.share < *share) {
            worst = Some((shading.share, format!("{name}: {shading}")));
        }
    }
    println!(
        "{compared} models in {:.1} s; the worst, deferred against forward: {worst:?}",
        started.elapsed().as_secs_f32()
    );
    assert!(compared > 20, "{compared} models");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
