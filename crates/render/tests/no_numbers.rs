//! Values of a scene that are no numbers, or infinite, as code can make them; files are refused with a message that says
//! where. They stay where they are, whatever looks at the pixels beside them or at the frames before.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::shadows::{light, perspective};
use crate::common::{built_in_with, plain_request, renderer};
use glam::Vec3;
use manypass::{Averaging, Environment, FrameRequest, Path, Renderer};
use manypass_scene::{Light, LightKind, Material, Node, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};

const SIZE: (u32, u32) = (64, 48);
const NAN: f32 = f32::NAN;
/// Of the body in the middle.
const WRONG: usize = 2;

/// Bodies on a glossy floor, and two lights.
fn scene() -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.3, 1.4, 4.0), Vec3::new(0.0, 0.4, 0.0), perspective());
    let gloss = Material { metallic_factor: 1.0, roughness_factor: 0.15, ..grey(0.9) };
    builder.put(primitives::plane(12.0), gloss, Node::default());
    builder.put(primitives::cube(Vec3::splat(0.7)), grey(0.7), at(Vec3::new(-1.1, 0.35, 0.0)));
    builder.put(primitives::cube(Vec3::splat(0.3)), grey(0.5), at(Vec3::new(0.0, 0.4, 0.3)));
    builder.put(primitives::uv_sphere(0.4, 24, 12), grey(0.3), at(Vec3::new(1.0, 0.4, 0.0)));
    builder.light(light(LightKind::Point, 8.0), Vec3::new(-1.0, 2.0, 2.0), Vec3::NEG_Y);
    builder.light(light(LightKind::Point, 8.0), Vec3::new(1.5, 2.0, 1.0), Vec3::NEG_Y);
    builder.finish()
}

/// With all that looks beside a pixel or at frames before.
fn request(renderer: &Renderer, scene: &Scene) -> FrameRequest {
    let mut request = plain_request(scene, SIZE).with(|settings| {
        settings.environment.source = Environment::Color([0.3; 3]);
        for key in ["occlusion.enabled", "reflections.enabled", "gi.enabled", "taa.enabled"] {
            settings.set(key, "true").unwrap();
        }
        settings.set("occlusion.bent_normals", "true").unwrap();
    });
    request.effects = vec![
        built_in_with(renderer, "dof", &["f_stop=0.05", "focus_m=4"]),
        built_in_with(renderer, "bloom", &["strength=0.3"]),
        built_in_with(renderer, "blur", &["sigma_px=0.5"]),
    ];
    request
}

/// Radiance after so many frames that follow each other.
fn frames(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, count: u32) -> Vec<[f32; 4]> {
    renderer.cut();
    renderer.load(scene).unwrap();
    for _ in 0..count {
        renderer.render(scene, &FrameRequest { goes_on: true, ..request.clone() }).unwrap();
    }
    renderer.read_radiance().unwrap().as_chunks().0.to_vec()
}

type Change = fn(&mut Scene);

#[test]
fn what_is_no_number_in_a_scene_does_not_spread() {
    let mut renderer = renderer();
    let whole = scene();
    let request = request(&renderer, &whole);
    // Each beside what it counts as, and the number of its warnings.
    let of_body: [(Change, Change); 6] = [
        (|scene| scene.materials[WRONG].emissive_factor = Vec3::splat(NAN), |_| {}),
        (
            |scene| scene.materials[WRONG].emissive_factor = Vec3::new(NAN, 0.5, -NAN),
            |scene| scene.materials[WRONG].emissive_factor = Vec3::new(0.0, 0.5, 0.0),
        ),
        (
            |scene| scene.materials[WRONG].base_color_factor.y = NAN,
            |scene| scene.materials[WRONG].base_color_factor.y = 0.0,
        ),
        (|scene| scene.materials[WRONG].roughness_factor = NAN, |scene| scene.materials[WRONG].roughness_factor = 0.0),
        (
            |scene| (scene.materials[WRONG].metallic_factor, scene.materials[WRONG].normal_scale) = (NAN, NAN),
            |scene| scene.materials[WRONG].metallic_factor = 0.0,
        ),
        (
            |scene| scene.materials[WRONG].base_color_factor = glam::Vec4::splat(f32::INFINITY),
            |scene| scene.materials[WRONG].base_color_factor = glam::Vec4::ONE,
        ),
    ];
    let dark: Change = |scene| scene.lights[1].intensity = 0.0;
    let of_lights: [(Change, Change); 3] = [
        (|scene| scene.lights[1].intensity = NAN, dark),
        (|scene| scene.lights[1].color_linear = Vec3::splat(NAN), dark),
        (|scene| (scene.lights[1].intensity, scene.lights[1].color_linear) = (f32::INFINITY, Vec3::ZERO), dark),
    ];
    for (at, (wrong, right)) in of_body.into_iter().chain(of_lights).enumerate() {
        let [wrong, right] = [wrong, right].map(|change| {
            let mut scene = whole.clone();
            change(&mut scene);
            scene
        });
        // What is no number equals nothing, not even itself: a scene that has one changes from frame to frame, and frames
        // keep less of those before.
        for (count, most) in [(1, 1e-3), (4, 0.1)] {
            let expected = frames(&mut renderer, &right, &request, count);
            assert_eq!(renderer.warnings(), [""; 0]);
            let found = frames(&mut renderer, &wrong, &request, count);
            let off = found.as_flattened().iter().zip(expected.as_flattened()).map(|(a, b)| (a - b).abs());
            let is_near = off.clone().all(|off| off < most);
            assert!(is_near, "case {at}, {count} frames: {:?}", off.fold(0.0, f32::max));
        }
        // It is told, and nothing of it is left for effects to scrub.
        let warnings = renderer.warnings();
        assert_eq!(warnings.len(), usize::from(at < 5), "case {at}: {warnings:?}");
        assert!(warnings.iter().all(|warning| warning.contains("material 2 `") && warning.contains("not numbers")));
        assert_eq!(renderer.count_scrubbed(&wrong, &request).unwrap(), 0, "case {at}");
    }
    // Where the body is drawn otherwise, too.
    for path in [Path::Forward, Path::Gouraud] {
        let mut wrong = whole.clone();
        let material = &mut wrong.materials[WRONG];
        (material.emissive_factor, material.base_color_factor.x) = (Vec3::splat(NAN), f32::INFINITY);
        let request = plain_request(&wrong, SIZE).with(|settings| settings.render.path = path);
        let found = frames(&mut renderer, &wrong, &request, 1);
        assert!(found.as_flattened().iter().all(|value| value.is_finite()), "{path:?}");
    }
}

#[test]
fn infinite_light_is_as_bright_as_half_floats_hold_and_counted() {
    let mut renderer = renderer();
    let mut scene = scene();
    let request = request(&renderer, &scene);
    let plain = frames(&mut renderer, &scene, &request, 4);
    let seen = plain_request(&scene, SIZE);
    let seen = FrameRequest { averaging: Averaging::Radiance, sample_count: 2, ..seen };
    let mut clamped = |scene: &Scene| {
        renderer.load(scene).unwrap();
        for sample_index in 0..2 {
            renderer.render(scene, &FrameRequest { sample_index, ..seen.clone() }).unwrap();
        }
        renderer.read_radiance().unwrap();
        renderer.clamped_pixels()
    };
    assert_eq!(clamped(&scene), 0);
    scene.materials[WRONG].emissive_factor = Vec3::splat(f32::INFINITY);
    let of_body = clamped(&scene);
    assert!((20..400).contains(&of_body), "the pixels of the body, and no others: {of_body}");
    let found = frames(&mut renderer, &scene, &request, 4);
    assert!(found.as_flattened().iter().all(|value| (0.0..=65504.0).contains(value)));
    assert!(found.iter().zip(&plain).any(|(found, plain)| found[1] > 1000.0 + plain[1]), "it is to be seen");
    assert_eq!(renderer.count_scrubbed(&scene, &request).unwrap(), 0);
    // Of a lamp, too.
    scene.materials[WRONG].emissive_factor = Vec3::ZERO;
    scene.lights.push(Light { intensity: f32::INFINITY, ..light(LightKind::Point, 1.0) });
    scene.add_node(None, Node { light: Some(2), translation: Vec3::new(0.0, 2.0, 1.0), ..Node::default() });
    scene.update_transforms();
    let found = frames(&mut renderer, &scene, &request, 4);
    assert!(found.as_flattened().iter().all(|value| (0.0..=65504.0).contains(value)));
}
