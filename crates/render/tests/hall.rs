//! The hall, with all its triangles, panes of glass and lights, against the ray caster.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{inner_pixels, plain_request, renderer};
use manypass::{FrameRequest, Path};
use manypass_testkit::compare::linear_difference;
use manypass_testkit::radiance_file::RadiancePicture;
use manypass_testkit::raycast::{Camera, Frame, Options, PixelPattern, World};
use std::path::Path as FilePath;

fn hall() -> (manypass_scene::Scene, World) {
    let scene = manypass_scene::demo::hall();
    let world = World::of_scene(&scene, Camera::of_scene(&scene).unwrap());
    (scene, world)
}

#[test]
fn the_hall_without_shadows_is_that_of_the_ray_caster() {
    const SIZE: (u32, u32) = (96, 54);
    let (scene, mut world) = hall();
    let truth = world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default()).radiance;
    // The test can fail: without a twentieth of the lights the hall is another.
    let mut number = 0;
    world.lights.retain(|_| {
        number += 1;
        number % 20 > 0
    });
    let dimmer = world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default()).radiance;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mean = truth.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / (3 * truth.len()) as f64;
    // Half floats have 11 bits, the G-buffer's colours and roughness 8. All pixels count, at edges too.
    for (path, mean_max, within, share_min) in
        [(Path::Forward, 0.002, 0.01, 0.999), (Path::Deferred, 0.008, 0.02, 0.99)]
    {
        let request = plain_request(&scene, SIZE).with(|settings| settings.render.path = path);
        renderer.render(&scene, &request).unwrap();
        let found: Vec<[f32; 3]> =
            renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect();
        let judge = |truth: &[[f32; 3]]| {
            let difference = linear_difference(truth, &found, 0.01 * mean);
            (difference.mean, difference.share_within(within))
        };
        let (mean, share) = judge(&truth);
        println!("{path:?}: mean error {:.4} %, within {within}: {:.3} %", 100.0 * mean, 100.0 * share);
        assert!(mean < mean_max && share > share_min, "{path:?}: mean error {mean}, share {share}");
        let (mean, share) = judge(&dimmer);
        assert!(mean > mean_max && share < share_min, "{path:?}: the test cannot fail");
    }
}

#[test]
fn the_reference_of_the_hall_is_what_the_ray_caster_gives() {
    let path = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("tests/references/hall.exr");
    let reference = RadiancePicture::read(&path).unwrap();
    let (_, world) = hall();
    let options =
        Options { shadows: true, samples_per_axis: 4, pixel_pattern: PixelPattern::Sequence, ..Options::default() };
    let size = (reference.width, reference.height);
    for row in [20, 75, 120] {
        let found = world.render_rows(size, row..row + 1, options).radiance;
        let kept = &reference.pixels[row * size.0..(row + 1) * size.0];
        // Half floats are rounded by up to 2⁻¹¹ of themselves.
        let near = |a: f32, b: f32| (a - b).abs() <= 5e-4 * a + 1e-6;
        let wrong = found.iter().zip(kept).filter(|(a, b)| !(0..3).all(|c| near(a[c], b[c]))).count();
        assert_eq!(wrong, 0, "row {row}: make it anew, see tests/references/README.md");
    }
}

/// Pixels of which all neighbours show the same object, turned and placed nearly alike.
fn away_from_edges(frame: &Frame) -> Vec<usize> {
    let is_alike = |a: usize, b: usize| {
        let offset = frame.position_world[b] - frame.position_world[a];
        frame.normal_world[a].dot(frame.normal_world[b]) > 0.9
            && offset.dot(frame.normal_world[a]).abs() < 0.02 * frame.depth_view_m[a]
    };
    let neighbours = |pixel: usize| [pixel - frame.width - 1, pixel - frame.width, pixel - frame.width + 1, pixel - 1];
    let all = |pixel: usize| neighbours(pixel).into_iter().chain(neighbours(pixel).map(|other| 2 * pixel - other));
    let mut inner = inner_pixels(&frame.object_id, (frame.width, frame.height));
    inner.retain(|pixel| all(*pixel).all(|other| is_alike(*pixel, other)));
    inner
}

#[test]
fn the_hall_with_every_light_shadowed_is_that_of_the_ray_caster() {
    const SAMPLES: u32 = 16;
    let path = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("tests/references/hall.exr");
    let reference = RadiancePicture::read(&path).unwrap();
    let (scene, mut world) = hall();
    let size = (reference.width, reference.height);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request =
        plain_request(&scene, (size.0 as u32, size.1 as u32)).with(|settings| settings.shadows.enabled = true);
    let light_rounds = renderer.light_rounds(&scene, &request).unwrap();
    let frames_per_sample = light_rounds.unwrap_or(1).div_ceil(SAMPLES);
    let sample_count = SAMPLES * frames_per_sample;
    for sample_index in 0..sample_count {
        let of_sample = FrameRequest { sample_index, sample_count, frames_per_sample, light_rounds, ..request.clone() };
        renderer.render(&scene, &of_sample).unwrap();
    }
    let found: Vec<[f32; 3]> = renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect();
    let total = |pixels: &[[f32; 3]]| pixels.iter().flatten().map(|v| f64::from(*v)).sum::<f64>();
    let pairs = reference.pixels.iter().flatten().zip(found.iter().flatten());
    let absolute = pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / total(&reference.pixels);
    world.lights.clear();
    let options = Options { multiple_scattering: false, ..Options::default() };
    let inner = away_from_edges(&world.render(size.0, size.1, options));
    let pick = |pixels: &[[f32; 3]]| inner.iter().map(|at| pixels[*at]).collect::<Vec<_>>();
    // What is darker than a tenth of the mean counts as that.
    let floor = 0.1 * total(&reference.pixels) / (3 * found.len()) as f64;
    let share = linear_difference(&pick(&reference.pixels), &pick(&found), floor).share_within(0.1);
    println!(
        "{light_rounds:?} rounds, mean absolute {absolute:.4}, {} inner pixels, within 10 %: {share:.4}",
        inner.len()
    );
    assert!(absolute <= 0.02, "mean absolute difference {absolute} of the mean");
    assert!(share >= 0.99, "{share} of pixels within 10 %");
}
