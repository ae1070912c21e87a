//! Stills through a lens against the closed form of a thin lens.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Quat, Vec2, Vec3};
use manypass::{Aov, Averaging, FrameRequest, LightCulling, RenderError, Renderer};
use manypass_scene::{Material, Node, Projection, Scene, primitives};
use manypass_testkit::build::SceneBuilder;
use manypass_testkit::scenes;

const SIZE: (u32, u32) = (240, 180);
const FOV_Y_RAD: f32 = 0.6;
const FOCUS_M: f32 = 4.0;
const LENS: Projection = Projection::Perspective { fov_y_rad: FOV_Y_RAD, near_m: 0.1, far_m: None };

/// Squares of `side_m` that glow, before the camera, which stands at the origin and looks along −Z.
fn squares(places: &[Vec3], side_m: f32) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::ZERO, Vec3::NEG_Z, LENS);
    for place in places {
        let material = Material { emissive_factor: Vec3::splat(4.0), ..Material::default() };
        let rotation = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        builder.put(primitives::plane(side_m), material, Node { translation: *place, rotation, ..Node::default() });
    }
    builder.finish()
}

fn request(scene: &Scene, f_stop: f32, sample_count: u32) -> FrameRequest {
    let mut request = FrameRequest { sample_count, ..plain_request(scene, SIZE) };
    (request.settings.camera.f_stop, request.settings.camera.focus_m) = (f_stop, FOCUS_M);
    request
}

/// Adds up all samples; their mean is to be read.
fn draw(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) {
    for sample_index in 0..request.sample_count {
        let request = FrameRequest { sample_index, ..request.clone() };
        if sample_index + 1 < request.sample_count {
            renderer.accumulate(scene, &request).unwrap();
        } else {
            renderer.render(scene, &request).unwrap();
        }
    }
}

/// Red of the mean radiance.
fn still(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    draw(renderer, scene, request);
    renderer.read_radiance().unwrap().chunks_exact(4).map(|pixel| pixel[0]).collect()
}

/// The sum of a picture, its middle, and the variance along x and y, in pixels.
fn moments(picture: &[f32]) -> (f64, Vec2, Vec2) {
    let at = |index: usize| Vec2::new((index % SIZE.0 as usize) as f32 + 0.5, (index / SIZE.0 as usize) as f32 + 0.5);
    let sum: f64 = picture.iter().map(|value| f64::from(*value)).sum();
    let mean = |of: &dyn Fn(Vec2) -> Vec2| {
        let weighted = picture.iter().enumerate().map(|(index, value)| (of(at(index)) * *value).as_dvec2());
        (weighted.sum::<glam::DVec2>() / sum).as_vec2()
    };
    let middle = mean(&|place| place);
    (sum, middle, mean(&|place| (place - middle) * (place - middle)))
}

/// Pixels a metre at a distance of 1 m.
fn focal_px() -> f32 {
    0.5 * SIZE.1 as f32 / (0.5 * FOV_Y_RAD).tan()
}

#[test]
fn circles_of_confusion_are_those_of_a_thin_lens_and_keep_their_light() {
    let mut renderer = renderer();
    // Before and behind the plane in focus, and not in the middle.
    for (place, f_stop) in [
        (Vec3::new(0.0, 0.0, -8.0), 0.1),
        (Vec3::new(0.6, -0.4, -12.0), 0.14),
        (Vec3::new(-0.2, 0.15, -2.5), 0.13),
        (Vec3::new(0.2, 0.15, -1.6), 0.35),
    ] {
        let side_m = 8.0 * -place.z / focal_px();
        let scene = squares(&[place], side_m);
        renderer.load(&scene).unwrap();
        let (pinhole_sum, pinhole_middle, pinhole_variance) =
            moments(&still(&mut renderer, &scene, &request(&scene, 0.0, 128)));
        let (sum, middle, variance) = moments(&still(&mut renderer, &scene, &request(&scene, f_stop, 128)));
        // The diameter of the lens, of 24 mm of sensor; of the circle in the picture.
        let diameter_m = 0.024 / (2.0 * (0.5 * FOV_Y_RAD).tan()) / f_stop;
        let circle_px = focal_px() * diameter_m * (-place.z - FOCUS_M).abs() / (-place.z * FOCUS_M);
        // The variance of a disc is a sixteenth of its diameter's square, and adds to that of the square.
        let found_px = 4.0 * (variance - pinhole_variance).map(f32::sqrt);
        println!("f/{f_stop} at {} m: {circle_px:.2} px, found {found_px:.2}", -place.z);
        assert!(circle_px > 10.0 && (found_px - circle_px).abs().max_element() < 0.5, "{circle_px} {found_px}");
        assert!(middle.distance(pinhole_middle) < 0.3, "{middle} {pinhole_middle}");
        assert!((sum / pinhole_sum - 1.0).abs() < 2e-3, "{sum} {pinhole_sum}");
    }
}

#[test]
fn what_is_in_focus_is_as_sharp_as_through_a_pinhole() {
    let places = [Vec3::new(0.0, 0.0, -FOCUS_M), Vec3::new(0.7, 0.5, -FOCUS_M), Vec3::new(-0.9, -0.6, -FOCUS_M)];
    let scene = squares(&places, 0.53);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let pinhole = still(&mut renderer, &scene, &request(&scene, 0.0, 16));
    let lens = still(&mut renderer, &scene, &request(&scene, 0.25, 16));
    let most = pinhole.iter().zip(&lens).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    // A sample is a sixteenth of 4; none may fall to the other side of an edge.
    assert!(most < 4.0 / 255.0, "{most}");
    // The same at another distance is blurred: the test can fail.
    let far = request(&scene, 0.25, 16).with(|settings| settings.camera.focus_m = 8.0);
    let far = still(&mut renderer, &scene, &far);
    assert!(pinhole.iter().zip(&far).any(|(a, b)| (a - b).abs() > 1.0));
    // Where nobody says, the middle of what is drawn is in focus.
    let automatic = request(&scene, 0.25, 16).with(|settings| settings.camera.focus_m = 0.0);
    assert!(still(&mut renderer, &scene, &automatic) == lens);
}

#[test]
fn lights_reach_what_a_lens_shows() {
    let scene = scenes::many_points(300).scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let through = |culling| {
        let mut request = FrameRequest { sample_count: 4, ..plain_request(&scene, SIZE) };
        (request.settings.camera.f_stop, request.settings.camera.focus_m) = (0.1, 5.0);
        request.settings.lights.culling = culling;
        request.averaging = Averaging::Radiance;
        request
    };
    let all = still(&mut renderer, &scene, &through(LightCulling::None));
    let pinhole = through(LightCulling::None).with(|settings| settings.camera.f_stop = 0.0);
    let pinhole = still(&mut renderer, &scene, &pinhole);
    assert!(all.iter().zip(&pinhole).any(|(a, b)| (a - b).abs() > 0.05 * a.max(*b)));
    for culling in [LightCulling::Clustered, LightCulling::Volumes] {
        let picture = still(&mut renderer, &scene, &through(culling));
        let most = all.iter().zip(&picture).map(|(a, b)| (a - b).abs() / a.max(0.05)).fold(0.0, f32::max);
        assert!(most < 0.01, "{culling:?}: {most}");
    }
}

#[test]
fn a_lens_leaves_nothing_out_and_variables_are_of_the_pinhole() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = |f_stop: f32, sample_count| FrameRequest {
        want_aovs: vec![Aov::Depth],
        averaging: Averaging::Display,
        ..request(&scene, f_stop, sample_count)
    };
    draw(&mut renderer, &scene, &request(0.2, 8));
    assert_eq!(renderer.read_samples_mean().unwrap(), 8.0);
    let (lens, depth) = (renderer.read_display().unwrap(), renderer.read_aov(Aov::Depth).unwrap());
    draw(&mut renderer, &scene, &request(0.2, 8));
    assert!(renderer.read_display().unwrap() == lens, "the same again");
    draw(&mut renderer, &scene, &request(0.0, 8));
    assert!(renderer.read_samples_mean().unwrap() < 8.0);
    assert!(renderer.read_aov(Aov::Depth).unwrap() == depth);
    // One sample, and a live view, have a pinhole.
    draw(&mut renderer, &scene, &request(0.0, 1));
    let pinhole = renderer.read_display().unwrap();
    draw(&mut renderer, &scene, &request(0.2, 1));
    assert!(renderer.read_display().unwrap() == pinhole && pinhole != lens);
    let live = |f_stop| FrameRequest { goes_on: true, want_aovs: Vec::new(), ..request(f_stop, 4) };
    draw(&mut renderer, &scene, &live(0.0));
    let pinhole = renderer.read_display().unwrap();
    draw(&mut renderer, &scene, &live(0.2));
    assert!(renderer.read_display().unwrap() == pinhole);
}

#[test]
fn parallel_rays_have_no_lens() {
    let mut scene = squares(&[Vec3::new(0.0, 0.0, -3.0)], 0.5);
    scene.cameras[0].projection = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 9.0 };
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let refused = renderer.accumulate(&scene, &request(&scene, 2.8, 4)).unwrap_err();
    assert!(matches!(refused, RenderError::ParallelLens), "{refused}");
    draw(&mut renderer, &scene, &request(&scene, 2.8, 1));
    for (key, value) in [("camera.f_stop", "0.05"), ("camera.focus_m", "1e-9")] {
        let request = request(&scene, 0.0, 4).with(|settings| settings.set(key, value).unwrap());
        let refused = renderer.accumulate(&scene, &request).unwrap_err().to_string();
        assert!(refused.contains(key) && refused.contains("which takes 0 or a number from"), "{refused}");
    }
    for (key, value) in [("camera.f_stop", "-1"), ("camera.f_stop", "NaN"), ("camera.shutter_deg", "1e9")] {
        assert!(request(&scene, 0.0, 4).settings.set(key, value).is_err(), "{key} {value}");
    }
}
