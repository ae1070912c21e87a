//! The ground: what hangs over it against closed forms, where shadows fall, and what knows nothing of it.

#![allow(clippy::unwrap_used, reason = "tests panic where they expect something")]

mod common;

use common::renderer;
use glam::{Mat4, Quat, Vec3};
use manypass::{Aov, Averaging, Background, Environment, FrameRequest, Ground, Path, Renderer, Tonemap, View};
use manypass_scene::{Light, LightKind, Material, Mesh, Node, Projection, Scene, primitives};
use std::f32::consts::FRAC_PI_2;

const SIZE: u32 = 96;
/// What the picture shows of the world, in metres.
const HEIGHT_M: f32 = 8.0;

/// A sphere of 1 m over the origin of the ground.
fn scene(middle_m: f32) -> Scene {
    let mut scene = Scene::default();
    scene.materials.push(Material::default());
    scene.meshes.push(Mesh { primitives: vec![primitives::uv_sphere(1.0, 48, 24)], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), translation: Vec3::new(0.0, middle_m, 0.0), ..Node::default() });
    scene.update_transforms();
    scene
}

/// From above, or from below: +X is on the right.
fn request(pitch_rad: f32, ground: Ground) -> FrameRequest {
    let rotation = Quat::from_rotation_x(-pitch_rad);
    let projection = Projection::Orthographic { height_m: HEIGHT_M, near_m: 0.1, far_m: 40.0 };
    let world_from_view = Mat4::from_rotation_translation(rotation, rotation * Vec3::new(0.0, 0.0, 20.0));
    let mut request = FrameRequest {
        averaging: Averaging::Both,
        ground_height_m: Some(0.0),
        ..FrameRequest::new(SIZE, SIZE, View { world_from_view, projection })
    };
    request.settings.environment.source = Environment::Color([1.0; 3]);
    request.settings.background.source = Background::Transparent;
    request.settings.tone_map.curve = Tonemap::None;
    request.settings.ground.mode = ground;
    request
}

/// Red and alpha of the radiance at x metres to the right of the middle and z before it, seen from above.
fn at(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, places: &[(f32, f32)]) -> Vec<[f32; 2]> {
    renderer.render(scene, request).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    let pixel = |m: f32| ((m / HEIGHT_M + 0.5) * SIZE as f32) as usize;
    let texel = |(x, z): &(f32, f32)| 4 * (pixel(*z) * SIZE as usize + pixel(*x));
    places.iter().map(|place| [radiance[texel(place)], radiance[texel(place) + 3]]).collect()
}

#[test]
fn a_sphere_takes_its_form_factor_of_the_light_from_everywhere() {
    let mut renderer = renderer();
    for middle_m in [1.0f32, 3.0] {
        let places: Vec<(f32, f32)> = [1.3f32, 1.7, 2.2, 3.0].iter().map(|across| (*across, 0.0)).collect();
        let found = at(&mut renderer, &scene(middle_m), &request(FRAC_PI_2, Ground::Color([1.0; 3])), &places);
        for ((across, _), [radiance, alpha]) in places.iter().zip(found) {
            let distance = across.hypot(middle_m);
            let truth = 1.0 - middle_m / distance.powi(3);
            println!("{middle_m} m, {across} m: {radiance}, {truth}");
            assert!((radiance - truth).abs() < 0.08 && (alpha - 1.0).abs() < 1e-3, "{middle_m} {across}: {radiance}");
        }
    }
}

#[test]
fn the_shadow_of_a_directional_light_lies_where_it_falls() {
    let mut renderer = renderer();
    let mut scene = scene(2.0);
    scene.lights.push(Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() });
    // From the left, 45° above.
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::new(1.0, -1.0, 0.0).normalize());
    scene.add_node(None, Node { light: Some(0), rotation, ..Node::default() });
    scene.update_transforms();
    let places = [(2.0, 0.0), (2.9, 0.0), (2.0, 0.8), (-2.0, 0.0), (2.0, 1.4), (3.8, 0.0), (2.0, -3.0)];
    let mut pictures = Vec::new();
    for path in [Path::Deferred, Path::Forward] {
        let dark = request(FRAC_PI_2, Ground::Shadow).with(|settings| {
            settings.environment.source = Environment::None;
            settings.render.path = path;
        });
        let found = at(&mut renderer, &scene, &dark, &places);
        let alphas: Vec<f32> = found.iter().map(|[_, alpha]| *alpha).collect();
        assert!(alphas[..3].iter().all(|alpha| *alpha > 0.97), "{path:?}: {alphas:?}");
        assert!(alphas[3..].iter().all(|alpha| *alpha < 0.03), "{path:?}: {alphas:?}");
        assert!(found.iter().all(|[radiance, _]| *radiance == 0.0), "{path:?}: a shadow gives no light");
        pictures.push(renderer.read_display().unwrap());
        let open = dark.with(|settings| settings.shadows.enabled = false);
        assert!(at(&mut renderer, &scene, &open, &places).iter().all(|[_, alpha]| *alpha == 0.0));
    }
    let apart = pictures[0].iter().zip(&pictures[1]).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(apart < pictures[0].len() / 500, "{apart}");
}

#[test]
fn it_is_seen_from_above_alone_and_by_no_variable() {
    let mut renderer = renderer();
    let scene = scene(1.0);
    for (pitch_rad, shows) in [(0.6, true), (-0.6, false), (0.0, false)] {
        let request = |ground| FrameRequest {
            want_aovs: vec![Aov::Depth, Aov::ObjectId, Aov::Position],
            ..request(pitch_rad, ground)
        };
        let mut draw = |ground| {
            renderer.render(&scene, &request(ground)).unwrap();
            let variables = [Aov::Depth, Aov::ObjectId, Aov::Position].map(|aov| renderer.read_aov(aov).unwrap());
            (renderer.read_display().unwrap(), variables)
        };
        let (without, variables) = draw(Ground::None);
        for ground in [Ground::Shadow, Ground::Color([0.5; 3])] {
            let (with, same) = draw(ground);
            assert_eq!(with != without, shows, "{pitch_rad}: {ground:?}");
            assert!(format!("{variables:?}") == format!("{same:?}"), "{pitch_rad}: {ground:?} is in a variable");
        }
    }
}

#[test]
fn the_studio_has_one_shadow_on_its_own() {
    let mut renderer = renderer();
    let scene = scene(1.0);
    let by_default = FrameRequest::of_scene(&scene, SIZE, SIZE);
    assert_eq!(
        (by_default.settings.ground.mode, by_default.ground_height_m.map(|m| m.abs() < 1e-3)),
        (Ground::Auto, Some(true))
    );
    let level = |renderer: &mut Renderer, request: &FrameRequest| {
        renderer.render(&scene, request).unwrap();
        renderer.read_display().unwrap().iter().map(|value| f64::from(*value)).sum::<f64>()
    };
    let with = level(&mut renderer, &by_default);
    assert_eq!((renderer.stats().lights, renderer.stats().shadowed_lights), (0, 1));
    let without = level(&mut renderer, &by_default.with(|settings| settings.ground.mode = Ground::None));
    assert!(with < 0.99 * without, "{with} {without}");
    let cut_out = |ground| {
        by_default
            .with(|settings| (settings.background.source, settings.ground.mode) = (Background::Transparent, ground))
    };
    assert_eq!(level(&mut renderer, &cut_out(Ground::Auto)), level(&mut renderer, &cut_out(Ground::None)));
    // A map that is right is not drawn again.
    let draws = [0; 2].map(|_| {
        level(&mut renderer, &by_default);
        renderer.stats().draws
    });
    assert!(draws[0] == draws[1], "{draws:?}");
}
