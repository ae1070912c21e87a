//! Stills whose later samples leave out the tiles that the earlier ones agree on.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use manypass::{Averaging, FrameRequest, LightCulling, Path, Renderer};
use manypass_scene::Scene;
use manypass_testkit::scenes;

const SIZE: (u32, u32) = (191, 125);
const SAMPLES: u32 = 16;

fn request(scene: &Scene) -> FrameRequest {
    let averaging = Averaging::Display;
    FrameRequest { averaging, sample_count: SAMPLES, ..plain_request(scene, SIZE) }
}

/// The picture, and how many samples its pixels have on average.
fn still(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, threshold: f32) -> (Vec<u8>, f64) {
    let request = request.with(|settings| settings.adaptive.threshold = threshold);
    for sample_index in 0..request.sample_count {
        let request = FrameRequest { sample_index, ..request.clone() };
        if sample_index + 1 < request.sample_count {
            renderer.accumulate(scene, &request).unwrap();
        } else {
            renderer.render(scene, &request).unwrap();
        }
    }
    (renderer.read_display().unwrap(), renderer.read_samples_mean().unwrap())
}

/// Root mean square of the differences of channels, of 255, and the share of them beyond 8.
fn differences(a: &[u8], b: &[u8]) -> (f64, f64) {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>();
    let far = a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 8).count();
    ((squares / a.len() as f64).sqrt(), far as f64 / a.len() as f64)
}

#[test]
fn what_is_left_out_is_not_missed() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    for path in [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud] {
        let request = request(&scene).with(|settings| settings.render.path = path);
        let (whole, all) = still(&mut renderer, &scene, &request, 0.0);
        assert_eq!(all, f64::from(SAMPLES), "{path:?}");
        let (adaptive, mean) = still(&mut renderer, &scene, &request, 2.0);
        let (rms, far) = differences(&whole, &adaptive);
        println!("{path:?}: {mean:.2} samples, rms {rms:.3}/255, {:.3} % of channels by more than 8", 100.0 * far);
        // Four are the fewest; silhouettes need all.
        assert!(mean > 4.0 && mean < 0.7 * f64::from(SAMPLES), "{path:?}: {mean}");
        assert!(rms < 0.6 && far < 1e-3, "{path:?}: {rms}, {far}");
        // Fewer samples for all pixels are worse: the test can fail.
        let fewer = FrameRequest { sample_count: mean.round() as u32, ..request.clone() };
        let (uniform, _) = still(&mut renderer, &scene, &fewer, 0.0);
        assert!(differences(&whole, &uniform).0 > 1.5 * rms, "{path:?}: {:?}", differences(&whole, &uniform));
        // The same again, from the same textures.
        assert!(still(&mut renderer, &scene, &request, 2.0).0 == adaptive, "{path:?}");
    }
}

#[test]
fn lights_in_lists_and_volumes_know_what_is_left_out() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    for culling in [LightCulling::Tiled, LightCulling::Volumes, LightCulling::VolumesStencil] {
        let request = request(&scene).with(|settings| settings.lights.culling = culling);
        let (whole, _) = still(&mut renderer, &scene, &request, 0.0);
        let (adaptive, mean) = still(&mut renderer, &scene, &request, 2.0);
        assert!(mean < 0.8 * f64::from(SAMPLES), "{culling:?}: {mean}");
        let (rms, far) = differences(&whole, &adaptive);
        assert!(rms < 0.6 && far < 1e-3, "{culling:?}: {rms}, {far}");
    }
}

#[test]
fn a_greater_threshold_leaves_out_more() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = request(&scene);
    let means = [0.0, 0.5, 2.0, 16.0].map(|threshold| still(&mut renderer, &scene, &request, threshold).1);
    assert!(means.is_sorted_by(|a, b| a > b), "{means:?}");
    // A live view leaves them out by depth alone; the picture differs by how its first sample is filtered, which plain
    // surfaces do not show.
    let live = FrameRequest { goes_on: true, ..request.clone() };
    assert_eq!(still(&mut renderer, &scene, &live, 2.0), still(&mut renderer, &scene, &request, 2.0));
}

#[test]
fn pictures_that_look_beside_their_pixels_have_all_samples() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let whole = f64::from(SAMPLES);
    let request = request(&scene);
    let linear = FrameRequest { averaging: Averaging::Radiance, ..request.clone() };
    assert_eq!(still(&mut renderer, &scene, &linear, 2.0).1, whole);
    let scaled = request.with(|settings| settings.render.scale = 0.5);
    assert_eq!(still(&mut renderer, &scene, &scaled, 2.0).1, whole);
    let lit_fog = request.with(|settings| {
        for (key, value) in [("fog.mode", "exponential"), ("fog.scattering", "1"), ("fog.density_per_m", "0.1")] {
            settings.set(key, value).unwrap();
        }
    });
    assert_eq!(still(&mut renderer, &scene, &lit_fog, 2.0).1, whole);
    let bent = [("occlusion.enabled", "true"), ("occlusion.bent_normals", "true")];
    let forward = [("occlusion.enabled", "true"), ("render.path", "forward")];
    let reflected = [("reflections.enabled", "true"), ("render.path", "forward")];
    let bounced = [("gi.enabled", "true"), ("gi.steps", "2")];
    for found in [bent, forward, reflected, bounced] {
        let request = request.with(|settings| found.iter().for_each(|(key, value)| settings.set(key, value).unwrap()));
        assert_eq!(still(&mut renderer, &scene, &request, 2.0).1, whole);
    }
    let few = FrameRequest { sample_count: 4, ..request.clone() };
    assert_eq!(still(&mut renderer, &scene, &few, 2.0).1, 4.0);
}
