//! Lights at the ends of what files may say: their pictures are numbers, the same on both paths and however lights are
//! culled.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::renderer;
use glam::{Mat4, Quat, Vec3};
use manypass::scene::primitives::cube;
use manypass::scene::{Light, LightKind, Material, Mesh, Node, Projection, Scene};
use manypass::{Averaging, Background, Environment, FrameRequest, LightCulling, Path, Renderer, Tonemap, View};

const SIDE: u32 = 32;

/// A wall 4 m before the eye, and lights.
fn scene(lights: impl IntoIterator<Item = (Light, Vec3)>) -> Scene {
    let mut scene = Scene::default();
    scene.materials.push(Material { metallic_factor: 0.0, roughness_factor: 0.3, ..Material::default() });
    let mut primitive = cube(Vec3::new(20.0, 20.0, 1.0));
    primitive.material = Some(0);
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), translation: Vec3::new(0.0, 0.0, -4.5), ..Node::default() });
    for (light, translation) in lights {
        scene.lights.push(light);
        let light = Some(scene.lights.len() - 1);
        let rotation = Quat::from_rotation_x(0.2);
        scene.add_node(None, Node { light, translation, rotation, ..Node::default() });
    }
    scene.update_transforms();
    scene
}

/// Radiance on each path, with each way of culling.
fn radiances(renderer: &mut Renderer, scene: &Scene, side: u32) -> Vec<Vec<f32>> {
    renderer.load(scene).unwrap();
    let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
    let mut request = FrameRequest::new(side, side, View { world_from_view: Mat4::IDENTITY, projection });
    request.averaging = Averaging::Radiance;
    let settings = &mut request.settings;
    (settings.environment.source, settings.background.source) = (Environment::None, Background::Color([0.0; 3]));
    (settings.tone_map.curve, settings.shadows.enabled) = (Tonemap::None, false);
    let mut found = Vec::new();
    for (path, culling) in [
        (Path::Deferred, LightCulling::Clustered),
        (Path::Deferred, LightCulling::None),
        (Path::Forward, LightCulling::Clustered),
    ] {
        (request.settings.render.path, request.settings.lights.culling) = (path, culling);
        renderer.render(scene, &request).unwrap();
        found.push(renderer.read_radiance().unwrap());
    }
    found
}

fn check(renderer: &mut Renderer, name: &str, scene: &Scene, side: u32, is_lit: bool) {
    let [deferred, everything, forward] = &radiances(renderer, scene, side)[..] else { panic!("three pictures") };
    assert!(deferred.iter().all(|value| value.is_finite() && *value >= 0.0), "{name}: {deferred:?}");
    let sum = |radiance: &[f32]| radiance.chunks_exact(4).map(|texel| texel[..3].iter().sum::<f32>()).sum::<f32>();
    assert_eq!(sum(deferred) > 0.0, is_lit, "{name}: {}", sum(deferred));
    for (other, what) in [(everything, "without culling"), (forward, "forward")] {
        for (at, (a, b)) in deferred.iter().zip(other).enumerate() {
            // The G-buffer keeps roughness and normals in fewer bits than the forward path.
            assert!((a - b).abs() <= 0.03 * a.abs().max(b.abs()) + 1e-6, "{name}, {what}, value {at}: {a} and {b}");
        }
    }
}

#[test]
fn lights_at_the_ends_of_their_ranges_are_numbers() {
    let mut renderer = renderer();
    let spot = |inner_cone_rad, outer_cone_rad| LightKind::Spot { inner_cone_rad, outer_cone_rad };
    let before = Vec3::new(0.1, 0.2, -3.0);
    let light = Light { intensity: 10.0, ..Light::default() };
    for (name, light, place, is_lit) in [
        ("out", Light { intensity: 0.0, ..light.clone() }, before, false),
        (
            "brightest",
            Light { intensity: f32::MAX, color_linear: Vec3::splat(f32::MAX), ..light.clone() },
            before,
            true,
        ),
        ("shortest", Light { range_m: Some(1e-6), ..light.clone() }, before, false),
        ("farthest", Light { range_m: Some(f32::MAX), ..light.clone() }, before, true),
        ("narrowest", Light { kind: spot(0.000_999, 0.001), ..light.clone() }, before, true),
        ("hard", Light { kind: spot(0.499, 0.5), range_m: Some(9.0), ..light.clone() }, before, true),
        (
            "widest",
            Light { kind: spot(0.0, std::f32::consts::FRAC_PI_2), range_m: Some(9.0), ..light.clone() },
            before,
            true,
        ),
        ("at the camera", Light { range_m: Some(9.0), ..light.clone() }, Vec3::ZERO, true),
        ("on the wall", Light { range_m: Some(1.0), ..light.clone() }, Vec3::new(0.0, 0.0, -4.0), true),
        // The surface that is seen faces away from it.
        ("inside the wall", Light { range_m: Some(9.0), ..light.clone() }, Vec3::new(0.0, 0.0, -4.5), false),
        ("a sun", Light { kind: LightKind::Directional, range_m: Some(1e-6), ..light.clone() }, before, true),
    ] {
        // A beam of two thousandths meets no middle of a pixel, unless it is an area's.
        let is_certain = !matches!(name, "narrowest" | "on the wall");
        let scene = scene([(light, place)]);
        if is_certain {
            check(&mut renderer, name, &scene, SIDE, is_lit);
        } else {
            let all = radiances(&mut renderer, &scene, SIDE);
            assert!(all.iter().flatten().all(|value| value.is_finite()), "{name}");
        }
    }
}

#[test]
fn ten_thousand_lights_without_end_all_count() {
    let mut renderer = renderer();
    let at = |i: u16| Vec3::new(f32::from(i % 100) * 0.02 - 1.0, f32::from(i / 100) * 0.02 - 1.0, -2.0);
    let light = |intensity| Light { intensity, ..Light::default() };
    let many = scene((0..10_000).map(|i| (light(0.001), at(i))));
    check(&mut renderer, "10,000", &many, 8, true);
    let stats = renderer.stats();
    assert_eq!(stats.lights, 10_000);
    // All together are about as one of their strength in their middle.
    let sum = |radiance: &[f32]| radiance.iter().map(|value| f64::from(*value)).sum::<f64>();
    let whole = sum(&radiances(&mut renderer, &many, 8)[0]);
    let halves: f64 = [0, 1]
        .map(|half| {
            let part = scene((0..10_000).filter(|i| i % 2 == half).map(|i| (light(0.001), at(i))));
            // Coverage is in each.
            sum(&radiances(&mut renderer, &part, 8)[0]) - 64.0
        })
        .iter()
        .sum();
    assert!((halves / (whole - 64.0) - 1.0).abs() < 0.005, "{halves} of {whole}");
}
