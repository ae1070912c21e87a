//! Physics and equalities in linear light, against a ray caster that shares no code with the renderer.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, inner_pixels, plain_request, renderer};
use manypass::{Aov, FrameRequest, LightCulling, Path, Renderer};
use manypass_scene::Scene;
use manypass_testkit::compare::{Picture, Tolerance, assert_rejects_mutations, assert_same, linear_difference};
use manypass_testkit::raycast::{Frame, Options};
use manypass_testkit::scenes::{self, TestScene};

const SIZE: (u32, u32) = (128, 96);

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}

fn display(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Picture {
    renderer.render(scene, request).unwrap();
    let bytes = renderer.read_display().unwrap();
    Picture::from_rgba8(request.width as usize, request.height as usize, &bytes)
}

fn against_ray_caster(test: &TestScene, path: Path) -> (f64, f64) {
    let truth = test.world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default());
    let request = plain_request(&test.scene, SIZE).with(|settings| settings.render.path = path);
    against(&truth, test, &request)
}

/// The mean relative error against the ray caster's picture, and the share of pixels within one per cent.
fn against(truth: &Frame, test: &TestScene, request: &FrameRequest) -> (f64, f64) {
    let (width, height) = (truth.width, truth.height);
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let found = radiance(&mut renderer, &test.scene, request);
    let inner = inner_pixels(&truth.object_id, (width, height));
    assert!(inner.len() > width * height / 2);
    let pick = |pixels: &[[f32; 3]]| inner.iter().map(|at| pixels[*at]).collect::<Vec<_>>();
    let (truth, found) = (pick(&truth.radiance), pick(&found));
    // Errors count relative to the pixel, or to a hundredth of the picture's mean where it is darker than that.
    let mean = truth.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / (3 * truth.len()) as f64;
    let difference = linear_difference(&truth, &found, 0.01 * mean);
    println!(
        "{} {:?}: mean error {:.4} %, 99th percentile {:.3} %, within 1 %: {:.3} %",
        test.name,
        request.settings.render.path,
        100.0 * difference.mean,
        100.0 * difference.percentile(0.99),
        100.0 * difference.share_within(0.01)
    );
    // The test can fail: three per cent more light is too much, and so is a picture whose pixels moved.
    let brighter: Vec<_> = found.iter().map(|pixel| pixel.map(|v| v * 1.03)).collect();
    let moved: Vec<_> = found.iter().skip(40).chain(&found[..40]).copied().collect();
    for wrong in [brighter, moved] {
        assert!(linear_difference(&truth, &wrong, 0.01 * mean).mean > 0.01, "{}: the test cannot fail", test.name);
    }
    (difference.mean, difference.share_within(0.01))
}

#[test]
fn forward_agrees_with_the_ray_caster() {
    for test in scenes::all() {
        let (mean, share) = against_ray_caster(&test, Path::Forward);
        // Half floats have 11 bits: 0.05 %. The rest is tessellation on the smoothest spheres' highlights.
        assert!(mean < 0.001 && share > 0.995, "{}: mean {mean}, share {share}", test.name);
    }
}

#[test]
fn deferred_agrees_with_the_ray_caster() {
    for test in scenes::all() {
        let (mean, share) = against_ray_caster(&test, Path::Deferred);
        // The G-buffer holds base colour and roughness in 8 bits: up to 0.9 % each of a dark colour or a highlight.
        assert!(mean < 0.008 && share > 0.95, "{}: mean {mean}, share {share}", test.name);
    }
}

#[test]
fn a_thousand_lights_agree_with_the_ray_caster() {
    // Ways of culling and groups of lights are compared with one another elsewhere, but they read one table of lights.
    let test = scenes::many_points(1000);
    let truth = test.world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default());
    for light_culling in [LightCulling::Clustered, LightCulling::None] {
        let request = plain_request(&test.scene, SIZE).with(|settings| {
            settings.lights.culling = light_culling;
            settings.render.path = Path::Forward;
        });
        let (mean, share) = against(&truth, &test, &request);
        assert!(mean < 0.001 && share > 0.995, "{light_culling:?}: mean {mean}, share {share}");
    }
    let (mean, share) = against(&truth, &test, &plain_request(&test.scene, SIZE));
    // The G-buffer's 8 bits, as above.
    assert!(mean < 0.008 && share > 0.95, "deferred: mean {mean}, share {share}");
    // The test can fail: one lamp of the thousand is enough.
    let mut without = test.clone();
    let lamp = without.world.lights.iter().position(|lamp| lamp.position_world.length() < 1.5).unwrap();
    without.world.lights.remove(lamp);
    let truth = without.world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default());
    let request = plain_request(&test.scene, SIZE).with(|settings| settings.render.path = Path::Forward);
    let (_, share) = against(&truth, &test, &request);
    assert!(share < 0.995, "a lamp too much is not noticed: {share}");
}

#[test]
fn depth_and_position_agree_with_the_ray_caster() {
    for test in scenes::all() {
        let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
        let truth = test.world.render(width, height, Options::default());
        let mut renderer = renderer();
        renderer.load(&test.scene).unwrap();
        let mut request = plain_request(&test.scene, SIZE);
        request.want_aovs = vec![Aov::Depth, Aov::Position, Aov::Normal];
        renderer.render(&test.scene, &request).unwrap();
        let depth = floats(renderer.read_aov(Aov::Depth).unwrap());
        let position = floats(renderer.read_aov(Aov::Position).unwrap());
        let normal = floats(renderer.read_aov(Aov::Normal).unwrap());
        let mut checked = 0;
        for at in inner_pixels(&truth.object_id, (width, height)) {
            if truth.object_id[at] == 0 {
                assert!(depth[at].is_infinite(), "{}: the background has a depth", test.name);
                continue;
            }
            let expected = truth.depth_view_m[at];
            // Facets of a sphere of 0.9 m lie up to 0.3 mm inside it; grazing pixels multiply that.
            let error = (f64::from(depth[at]) - expected).abs();
            assert!(error < 5e-3, "{}: pixel {at}: {} m, expected {expected} m", test.name, depth[at]);
            let found =
                glam::DVec3::new(position[at * 3].into(), position[at * 3 + 1].into(), position[at * 3 + 2].into());
            assert!((found - truth.position_world[at]).length() < 8e-3, "{}: pixel {at}", test.name);
            let n = glam::DVec3::new(normal[at * 3].into(), normal[at * 3 + 1].into(), normal[at * 3 + 2].into());
            assert!(n.dot(truth.normal_world[at]) > 0.999, "{}: pixel {at}: normal {n}", test.name);
            checked += 1;
        }
        assert!(checked > 1000);
    }
}

#[test]
fn clustered_is_brute_force_and_deferred_is_forward() {
    let mut all = scenes::all();
    all.push(scenes::many_points(1000));
    for test in all {
        let mut renderer = renderer();
        renderer.load(&test.scene).unwrap();
        let request = plain_request(&test.scene, SIZE);
        let clustered = display(&mut renderer, &test.scene, &request);
        let brute_force = request.with(|settings| settings.lights.culling = LightCulling::None);
        let brute_force = display(&mut renderer, &test.scene, &brute_force);
        let exact = Tolerance { within: 1, share: 1.0, share_between: 1.0, mean: 0.01, ..Tolerance::default() };
        assert_same(&clustered, &brute_force, exact);
        // The lit plane is its own mirror image, and grey.
        if test.name != "one_light_on_one_plane" {
            assert_rejects_mutations(&clustered, Tolerance::default());
        }
        let forward = request.with(|settings| settings.render.path = Path::Forward);
        let forward = display(&mut renderer, &test.scene, &forward);
        // Base colour and roughness in 8 bits: half a step of base colour is up to 0.5/255 of a lit surface, and
        // roughness moves the sharpest highlights by more than 2/255.
        assert_same(
            &clustered,
            &forward,
            Tolerance { within: 2, share: 0.99, share_between: 0.99, mean: 0.5, ..Tolerance::default() },
        );
    }
}

#[test]
fn eight_groups_of_lights_add_up_to_the_whole() {
    let test = scenes::many_points(10_000);
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let request = plain_request(&test.scene, SIZE);
    let whole = radiance(&mut renderer, &test.scene, &request);
    let mut sum = vec![[0.0f32; 3]; whole.len()];
    for group in 0..8 {
        let request = FrameRequest { light_subset: Some((group, 8)), ..request.clone() };
        for (sum, part) in sum.iter_mut().zip(radiance(&mut renderer, &test.scene, &request)) {
            for channel in 0..3 {
                sum[channel] += part[channel];
            }
        }
    }
    let total = |pixels: &[[f32; 3]]| pixels.iter().flatten().map(|v| f64::from(*v)).sum::<f64>();
    let (whole_sum, group_sum) = (total(&whole), total(&sum));
    assert!((whole_sum / group_sum - 1.0).abs() < 0.005, "{whole_sum} against {group_sum}");
    // A dropped light shows in a pixel even if it hides in the sum.
    let difference = linear_difference(&whole, &sum, 0.01);
    assert!(difference.share_within(0.01) > 0.999, "within 1 %: {}", difference.share_within(0.01));
}

#[test]
fn the_same_request_gives_the_same_bytes() {
    let test = scenes::rows_of_spheres();
    let bytes = || {
        let mut renderer = renderer();
        renderer.load(&test.scene).unwrap();
        let mut request = plain_request(&test.scene, SIZE);
        request.sample_count = 3;
        for sample in 0..3 {
            request.sample_index = sample;
            renderer.render(&test.scene, &request).unwrap();
        }
        renderer.read_display().unwrap()
    };
    assert_eq!(bytes(), bytes());
}
