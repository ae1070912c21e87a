//! Several samples a pixel: edges against pictures of more pixels, in front of and behind all that a frame draws, and
//! what is refused.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Quat, Vec3, Vec4};
use manypass::gpu::Floor;
use manypass::settings::Settings;
use manypass::{
    Averaging, Background, Environment, FogMode, FrameRequest, Gpu, Ground, Path, PixelSamples, RenderError, Renderer,
    TransparencyMode,
};
use manypass_scene::material::TexturedFactor;
use manypass_scene::{AlphaMode, Light, LightKind, Material, Node, Projection, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};

fn multisampled(request: &FrameRequest) -> FrameRequest {
    request.with(|settings| (settings.render.path, settings.msaa.samples) = (Path::Forward, PixelSamples::Four))
}

fn radiance_of(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    renderer.load(scene).unwrap();
    for sample_index in 0..request.sample_count {
        renderer.render(scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
    }
    renderer.read_radiance().unwrap()
}

/// A square that shines by itself, far brighter than a display's white, turned a little, seen with parallel rays.
fn bright_square() -> Scene {
    let parallel = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 20.0 };
    let mut builder = SceneBuilder::new(Vec3::Y * 5.0, Vec3::ZERO, parallel);
    let glowing = Material { emissive_factor: Vec3::splat(8.0), ..grey(0.0) };
    let node = Node { rotation: Quat::from_rotation_y(0.3), ..Node::default() };
    builder.put(primitives::plane(1.2), glowing, node);
    builder.finish()
}

#[test]
fn edges_are_those_of_a_picture_of_more_pixels() {
    const SIDE: usize = 48;
    const FINER: usize = 16;
    let scene = bright_square();
    let mut renderer = renderer();
    let red = |rgba: Vec<f32>| rgba.chunks_exact(4).map(|texel| texel[0]).collect::<Vec<_>>();
    let request = |side: usize| plain_request(&scene, (side as u32, side as u32));
    let fine = red(radiance_of(&mut renderer, &scene, &request(SIDE * FINER)));
    let mut truth = vec![0.0; SIDE * SIDE];
    for (at, value) in fine.iter().enumerate() {
        let (x, y) = (at % (SIDE * FINER) / FINER, at / (SIDE * FINER) / FINER);
        truth[y * SIDE + x] += value / (FINER * FINER) as f32;
    }
    let found = red(radiance_of(&mut renderer, &scene, &multisampled(&request(SIDE))));
    let once = red(radiance_of(&mut renderer, &scene, &request(SIDE)));
    let error = |picture: &[f32]| picture.iter().zip(&truth).map(|(a, b)| (a - b).abs()).sum::<f32>() / 8.0;
    let (mut inner, mut edge, mut sum) = (0, 0, 0.0);
    for (value, truth) in found.iter().zip(&truth) {
        // Samples are covered or not, and what they hold is radiance.
        assert!((value / 2.0).fract() == 0.0, "{value}");
        if [0.0, 8.0].contains(truth) {
            assert_eq!(value, truth);
            inner += 1;
        } else {
            // Four places in a pixel, each in a row and a column of its own.
            assert!((value - truth).abs() <= 0.3 * 8.0, "{value} instead of {truth}");
            (edge, sum) = (edge + 1, sum + (value - truth) / 8.0);
        }
    }
    println!("{inner} {edge} {sum} {} {}", error(&found), error(&once));
    assert!(inner > 1500 && edge > 100, "{inner} {edge}");
    assert!(sum.abs() < 0.02 * edge as f32, "{sum} of {edge} pixels");
    assert!(error(&found) < 0.12 * edge as f32 && error(&found) < 0.5 * error(&once), "{}", error(&found));
}

/// Surfaces of every kind, one before the other, most of them edges, before an environment.
fn all_kinds() -> Scene {
    let projection = Projection::Perspective { fov_y_rad: 0.7, near_m: 0.1, far_m: None };
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.2, 4.0), Vec3::new(0.0, 0.5, 0.0), projection);
    let blended = |r, g, b| Material {
        alpha_mode: AlphaMode::Blend,
        base_color_factor: Vec4::new(r, g, b, 0.6),
        double_sided: true,
        ..grey(0.5)
    };
    let turned = |angle: f32, place: Vec3| Node {
        rotation: Quat::from_rotation_z(angle) * Quat::from_rotation_x(0.4),
        ..at(place)
    };
    for i in -6..=6_i8 {
        let x = f32::from(i) * 0.2;
        let bar = Node { rotation: Quat::from_rotation_z(0.2 + x), ..at(Vec3::new(x, 0.6, -0.8)) };
        builder.put(primitives::cube(Vec3::new(0.05, 1.2, 0.05)), grey(0.9), bar);
    }
    let mask = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, double_sided: true, ..grey(0.05) };
    builder.put(primitives::plane(0.5), mask, turned(0.3, Vec3::new(-0.9, 0.9, 0.2)));
    builder.put(primitives::plane(0.7), blended(0.9, 0.1, 0.1), turned(0.6, Vec3::new(-0.4, 0.5, 0.5)));
    builder.put(primitives::plane(0.7), blended(0.1, 0.2, 0.9), turned(-0.6, Vec3::new(-0.2, 0.6, 0.9)));
    let glass = Material { transmission: Some(TexturedFactor::new(1.0)), roughness_factor: 0.1, ..grey(0.9) };
    builder.put(primitives::uv_sphere(0.3, 24, 12), glass.clone(), at(Vec3::new(0.5, 0.5, 0.4)));
    builder.put(primitives::cube(Vec3::new(0.2, 0.9, 0.1)), glass, turned(0.4, Vec3::new(0.7, 0.5, -0.2)));
    let sun = Light { kind: LightKind::Directional, intensity: 2.0, ..Light::default() };
    builder.light(sun, Vec3::ZERO, Vec3::new(0.4, -1.0, -0.6));
    builder.light(Light { intensity: 3.0, ..Light::default() }, Vec3::new(0.0, 1.5, 1.0), Vec3::NEG_Y);
    builder.finish()
}

fn requests(scene: &Scene) -> Vec<(&'static str, FrameRequest)> {
    let plain = plain_request(scene, (96, 72)).with(|settings| {
        settings.environment.source = Environment::Studio;
        settings.background.source = Background::Environment;
        settings.ground.mode = Ground::Color([0.2, 0.1, 0.05]);
        settings.render.path = Path::Forward;
    });
    let plain = FrameRequest { averaging: Averaging::Radiance, ..plain };
    let with = |change: fn(&mut Settings)| plain.with(change);
    let fog = |settings: &mut Settings| {
        (settings.fog.mode, settings.fog.density_per_m, settings.fog.background) = (FogMode::Exponential, 0.2, true);
    };
    vec![
        ("sorted", plain.clone()),
        ("weighted", with(|settings| settings.transparency.mode = TransparencyMode::Weighted)),
        ("one layer of glass", with(|settings| settings.transparency.refractive_layers = 1)),
        ("before nothing", with(|settings| settings.background.source = Background::Transparent)),
        ("in fog", with(fog)),
        (
            "in light that fog scatters",
            with(|settings| {
                (settings.fog.mode, settings.fog.density_per_m) = (FogMode::Exponential, 0.2);
                (settings.fog.scattering, settings.fog.intensity) = (0.8, 0.2);
                // With as little noise as there can be.
                (settings.fog.steps, settings.fog.half) = (128, false);
            }),
        ),
        ("finer than the picture", with(|settings| settings.render.scale = 1.5)),
    ]
}

#[test]
fn whatever_a_frame_draws_has_smooth_edges() {
    let scene = all_kinds();
    let mut renderer = renderer();
    for (name, request) in requests(&scene) {
        let truth = radiance_of(&mut renderer, &scene, &FrameRequest { sample_count: 32, ..request.clone() });
        let once = radiance_of(&mut renderer, &scene, &request);
        let found = radiance_of(&mut renderer, &scene, &multisampled(&request));
        let error = |picture: &[f32]| picture.iter().zip(&truth).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>();
        let farthest = found.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        println!("{name}: {:.1} instead of {:.1}, at most {farthest}", error(&found), error(&once));
        // What fog scatters is of one distance a pixel, and noise beside.
        let most = if request.settings.fog.scattering > 0.0 { 0.85 } else { 0.5 };
        assert!(error(&found) < most * error(&once), "{name}");
    }
    // Chance is of the pixel, but hides and covers as surfaces do.
    let stochastic = requests(&scene)[0].1.with(|settings| settings.transparency.mode = TransparencyMode::Stochastic);
    let stochastic = FrameRequest { sample_count: 32, ..stochastic };
    let truth = radiance_of(&mut renderer, &scene, &stochastic);
    let found = radiance_of(&mut renderer, &scene, &multisampled(&stochastic));
    let mean = truth.iter().zip(&found).map(|(a, b)| (a - b).abs()).sum::<f32>() / truth.len() as f32;
    assert!(mean < 0.01, "{mean}");
}

#[test]
fn a_frame_of_samples_makes_nothing_again() {
    let scene = all_kinds();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    for (name, request) in requests(&scene) {
        let request = multisampled(&request);
        for _ in 0..3 {
            renderer.render(&scene, &request).unwrap();
        }
        let stats = renderer.stats();
        assert_eq!(
            (stats.bind_groups_made, stats.pipelines_made, stats.uploaded_bytes),
            (0, 0, 0),
            "{name}: {stats:?}"
        );
        assert!(stats.bundles_executed > 0, "{name}");
    }
}

#[test]
fn frames_of_samples_are_planned_for_the_floor() {
    let scene = all_kinds();
    for floor in [Floor::WebGpu, Floor::WebGl2] {
        let mut renderer = Renderer::new(Gpu::without_adapter(floor).unwrap()).unwrap();
        renderer.load(&scene).unwrap();
        for (name, request) in requests(&scene) {
            let plan = renderer.plan(&scene, &multisampled(&request)).unwrap();
            let with_samples: Vec<_> = plan.textures.iter().filter(|texture| texture.desc.samples == 4).collect();
            assert!(with_samples.len() >= 2 && with_samples.iter().all(|texture| !texture.sampled), "{name}");
            // What comes after the picture is made of one sample a pixel.
            let last = plan.passes.iter().rposition(|pass| pass.name.starts_with("resolve")).unwrap();
            assert!(plan.passes[last + 1..].iter().any(|pass| pass.name == "tone_map"), "{name}");
        }
    }
}

#[test]
fn other_paths_refuse_samples() {
    let scene = bright_square();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = multisampled(&plain_request(&scene, (8, 8)));
    for path in [Path::Deferred, Path::ForwardBatched, Path::Gouraud] {
        let refused = renderer.render(&scene, &request.with(|settings| settings.render.path = path)).unwrap_err();
        assert!(matches!(refused, RenderError::Settings(_)), "{refused}");
        let expected = format!("`msaa.samples=4` needs `render.path=forward`, which is `{}`", path.name());
        assert_eq!(refused.to_string(), expected);
    }
    renderer.render(&scene, &request).unwrap();
}
