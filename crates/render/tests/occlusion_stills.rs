//! Stills of several samples whose first ones find occlusion for all.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{framed, plain_request, renderer};
use glam::{Quat, Vec3};
use manypass::{Averaging, Background, Environment, FrameRequest, Renderer};
use manypass_scene::{Aabb, Node, Projection, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::scenes;

const SIZE: (u32, u32) = (319, 201);

fn request(scene: &Scene, samples: u32) -> FrameRequest {
    // From above: a plane that is seen at a grazing angle has few texels of a smaller picture.
    let camera = framed(&Aabb { min: Vec3::new(-3.0, 0.0, -2.0), max: Vec3::new(3.0, 2.0, 2.0) });
    let request =
        FrameRequest { averaging: Averaging::Display, sample_count: samples, camera, ..plain_request(scene, SIZE) };
    request.with(|settings| {
        settings.environment.source = Environment::Color([0.6; 3]);
        settings.background.source = Background::Transparent;
        settings.occlusion.enabled = true.into();
        // Wide enough that spheres occlude each other.
        settings.occlusion.radius_m = 1.0;
    })
}

/// The picture, and how many samples its pixels have on average.
fn still(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> (Vec<u8>, f64) {
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

/// Root mean square of the differences of channels, of 255.
fn rms(a: &[u8], b: &[u8]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>();
    (squares / a.len() as f64).sqrt()
}

#[test]
fn later_samples_have_the_occlusion_that_the_first_found() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    // Few samples take the mean of a pattern, more the mean of noise.
    for samples in [16, 32] {
        let adaptive = request(&scene, samples);
        let every = adaptive.with(|settings| settings.adaptive.threshold = 0.0);
        let (of_every, all) = still(&mut renderer, &scene, &every);
        assert_eq!(all, f64::from(samples));
        let (of_first, mean) = still(&mut renderer, &scene, &adaptive);
        let open = every.with(|settings| settings.occlusion.enabled = false.into());
        let (of_none, _) = still(&mut renderer, &scene, &open);
        let (apart, lost) = (rms(&of_every, &of_first), rms(&of_every, &of_none));
        println!("{samples} samples: {mean:.2} drawn, {apart:.3}/255 from each its own, {lost:.3} from no occlusion");
        assert!(mean < 0.7 * f64::from(samples), "{mean}");
        assert!(apart < 0.5 * lost, "{apart} {lost}");
        // The same again, from the same textures.
        assert!(still(&mut renderer, &scene, &adaptive).0 == of_first);
    }
}

#[test]
fn another_still_begins_anew() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let near = request(&scene, 16);
    let far = near.with(|settings| settings.occlusion.radius_m = 0.05);
    let (fresh, _) = still(&mut renderer, &scene, &far);
    still(&mut renderer, &scene, &near);
    let (after, _) = still(&mut renderer, &scene, &far);
    assert!(after == fresh);
    // In another size, too.
    let small = FrameRequest { width: 64, height: 1, ..near };
    still(&mut renderer, &scene, &small);
    let last = still(&mut renderer, &scene, &far).0;
    assert!(last == fresh, "{}", rms(&last, &fresh));
}

/// Strips of a plate with grooves between them, of which a line of walls is seen that is thinner than a pixel.
fn grooves() -> Scene {
    let (gap_m, depth_m) = (0.02, 0.06);
    let projection = Projection::Orthographic { height_m: 2.25, near_m: 0.1, far_m: 100.0 };
    let mut builder = SceneBuilder::new(Vec3::new(3.0, 1.5, 0.3), Vec3::ZERO, projection);
    builder.put(primitives::cube(Vec3::new(4.0, 0.1, 4.0)), grey(0.5), at(Vec3::new(0.0, -depth_m - 0.05, 0.0)));
    let rotation = Quat::from_rotation_y(0.12);
    for strip in -7..8_i8 {
        let place = rotation * Vec3::X * (0.2 * f32::from(strip)) - Vec3::Y * (0.5 * depth_m);
        let size_m = Vec3::new(0.2 - gap_m, depth_m, 3.0);
        builder.put(primitives::cube(size_m), grey(0.5), Node { rotation, ..at(place) });
    }
    builder.finish()
}

#[test]
fn grooves_thinner_than_a_pixel_leave_no_specks() {
    let scene = grooves();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = FrameRequest { averaging: Averaging::Display, sample_count: 8, ..plain_request(&scene, (300, 225)) };
    let request = request.with(|settings| {
        settings.environment.source = Environment::Color([0.6; 3]);
        settings.background.source = Background::Transparent;
        settings.occlusion.enabled = true.into();
        settings.occlusion.radius_m = 0.3;
    });
    let (found, _) = still(&mut renderer, &scene, &request);
    let (open, _) = still(&mut renderer, &scene, &request.with(|settings| settings.occlusion.enabled = false.into()));
    let pixels = found.chunks_exact(4).zip(open.chunks_exact(4)).filter(|(_, open)| open[3] == 255);
    let shares: Vec<f32> = pixels.map(|(found, open)| f32::from(found[1]) / f32::from(open[1].max(1))).collect();
    let dark = shares.iter().filter(|share| **share < 0.85).count();
    let lost = shares.iter().filter(|share| **share < 0.98).count();
    println!("{dark} specks, {lost} pixels of {} lose light", shares.len());
    assert!(shares.len() > 20_000 && lost > 100, "nothing to look at");
    // Texels of the grooves that stood for what lies beside them left 1,300.
    assert!(dark < 200, "{dark} specks");
}
