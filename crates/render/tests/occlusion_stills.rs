//! Stills of several samples whose first ones find occlusion for all.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use common::{framed, plain_request, renderer};
use glam::Vec3;
use manypass::{Averaging, Background, Environment, FrameRequest, Renderer};
use manypass_scene::{Aabb, Scene};
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
