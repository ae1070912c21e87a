//! Light that fog scatters, against numerical integration along the rays of the ray caster: directional light, spots
//! and points with and without a range, with their shadows, before opaque and blended surfaces and before nothing.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{DVec3, Vec3, Vec4};
use manypass::{FogMode, FrameRequest, LightCulling, Path, Renderer};
use manypass_scene::{AlphaMode, Light, LightKind, Material, Projection, Scene, ShadingModel, primitives};
use manypass_testkit::build::{SceneBuilder, at};
use manypass_testkit::compare::{LinearDifference, linear_difference};
use manypass_testkit::raycast::{Camera, Medium, Options, PixelPattern, World};
use std::f64::consts::PI;

const SIZE: (u32, u32) = (80, 45);
const SAMPLES: u32 = 64;

/// What gives no light back.
fn black(alpha: f32) -> Material {
    Material {
        base_color_factor: Vec4::new(0.0, 0.0, 0.0, alpha),
        shading_model: ShadingModel::Unlit,
        alpha_mode: if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque },
        ..Material::default()
    }
}

/// A row of columns under a roof with gaps, before the sky; surfaces are black, so that only fog is seen, and a pane of
/// dark glass covers a part of it.
fn scene() -> Scene {
    let projection = Projection::Perspective { fov_y_rad: 0.9, near_m: 0.1, far_m: None };
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.7, 6.0), Vec3::new(0.3, 2.4, 0.0), projection);
    let mut block = |size: [f32; 3], center: [f32; 3]| {
        builder.put(primitives::cube(Vec3::from(size)), black(1.0), at(Vec3::from(center)));
    };
    block([30.0, 0.2, 16.0], [0.0, -0.1, 0.0]);
    for column in -2..=2_i8 {
        block([0.5, 4.0, 0.5], [2.0 * f32::from(column), 2.0, -1.0]);
        block([1.1, 0.2, 5.0], [2.0 * f32::from(column), 4.1, 0.0]);
    }
    builder.put(primitives::cube(Vec3::new(1.6, 1.6, 0.01)), black(0.5), at(Vec3::new(-1.5, 1.6, 2.0)));
    let light = |kind, intensity: f32, range_m: Option<f32>, color: [f32; 3]| Light {
        kind,
        intensity,
        range_m,
        color_linear: Vec3::from(color),
        ..Light::default()
    };
    let sun = light(LightKind::Directional, 3.0, None, [1.0, 0.9, 0.7]);
    builder.light(sun, Vec3::ZERO, Vec3::new(0.35, -1.0, 0.2));
    let cone = LightKind::Spot { inner_cone_rad: 0.2, outer_cone_rad: 0.5 };
    let spot = light(cone, 60.0, Some(12.0), [0.3, 0.6, 1.0]);
    builder.light(spot, Vec3::new(4.0, 3.0, -4.0), Vec3::new(-0.9, -0.2, 0.9));
    builder.light(light(LightKind::Point, 4.0, None, [1.0, 1.0, 1.0]), Vec3::new(0.0, 1.0, -3.0), Vec3::NEG_Y);
    for number in -2..=2_i8 {
        let lamp = light(LightKind::Point, 3.0, Some(2.5), [1.0, 0.3, 0.1]);
        builder.light(lamp, Vec3::new(2.0 * f32::from(number) + 1.0, 0.7, f32::from(number)), Vec3::NEG_Y);
    }
    builder.finish()
}

/// The fog of a request, as the ray caster has it.
fn medium(request: &FrameRequest) -> Medium {
    let fog = &request.settings.fog;
    Medium {
        density_per_m: fog.density_per_m.into(),
        albedo: DVec3::splat(fog.scattering.into()),
        base_height_m: fog.base_height_m.into(),
        scale_height_m: if fog.scale_height_m > 0.0 { fog.scale_height_m.into() } else { f64::INFINITY },
        anisotropy: fog.anisotropy.into(),
        far_m: fog.far_m.into(),
        dims_light: false,
    }
}

fn truth(scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    let mut world = World::of_scene(scene, Camera::of_scene(scene).unwrap());
    world.medium = Some(medium(request));
    let options = Options {
        shadows: true,
        // The very places of the samples, so that edges of columns are the same.
        samples_per_axis: SAMPLES.isqrt(),
        pixel_pattern: PixelPattern::Sequence,
        medium_steps: 8,
        ..Options::default()
    };
    world.render(SIZE.0 as usize, SIZE.1 as usize, options).radiance
}

/// The mean of so many samples.
fn found(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, sample_count: u32) -> Vec<[f32; 3]> {
    for sample_index in 0..sample_count {
        let request = FrameRequest { sample_index, sample_count, ..request.clone() };
        renderer.render(scene, &request).unwrap();
    }
    radiance(renderer)
}

fn radiance(renderer: &mut Renderer) -> Vec<[f32; 3]> {
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}

fn request(scene: &Scene) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.shadows.enabled = true;
        settings.shadows.atlas_px = 2048;
        let fog = &mut settings.fog;
        (fog.mode, fog.density_per_m, fog.scattering, fog.intensity) = (FogMode::Exponential, 0.06, 0.9, 0.0);
        fog.far_m = 40.0;
    })
}

fn difference(truth: &[[f32; 3]], found: &[[f32; 3]]) -> LinearDifference {
    let mean = truth.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / (3 * truth.len()) as f64;
    linear_difference(truth, found, 0.05 * mean)
}

fn check(what: &str, truth: &[[f32; 3]], found: &[[f32; 3]]) {
    let difference = difference(truth, found);
    let (mean, share) = (difference.mean, difference.share_within(0.06));
    println!("{what}: mean error {:.3} %, within 6 %: {:.2} %", 100.0 * mean, 100.0 * share);
    assert!(mean <= 0.02 && share >= 0.95, "{what}: mean error {mean}, within 6 %: {share}");
}

#[test]
fn light_in_uniform_fog_is_that_of_the_ray_caster() {
    let scene = scene();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = request(&scene);
    let truth = truth(&scene, &request);
    check("deferred, half", &truth, &found(&mut renderer, &scene, &request, SAMPLES));
    let full = request.with(|settings| settings.fog.half = false);
    let forward = full.with(|settings| settings.render.path = Path::Forward);
    check("forward", &truth, &found(&mut renderer, &scene, &forward, SAMPLES));
    // Without lists of clusters, and with blended surfaces that are shaded another way.
    let gouraud = full.with(|settings| {
        (settings.render.path, settings.lights.culling) = (Path::Gouraud, LightCulling::None);
    });
    // Few samples see edges elsewhere than the ray caster does.
    let few = difference(&truth, &found(&mut renderer, &scene, &gouraud, 8));
    assert!(few.mean < 0.06 && few.share_within(0.2) > 0.95, "gouraud: {}, {}", few.mean, few.share_within(0.2));
    // The test can fail: without shadows light is everywhere.
    let unshadowed = full.with(|settings| settings.shadows.enabled = false);
    renderer.render(&scene, &unshadowed).unwrap();
    let unlike = difference(&truth, &radiance(&mut renderer));
    assert!(unlike.mean > 0.1, "shadows make no difference: {}", unlike.mean);
}

#[test]
fn light_in_fog_that_thins_out_upwards_is_that_of_the_ray_caster() {
    let scene = scene();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = request(&scene).with(|settings| {
        let fog = &mut settings.fog;
        (fog.scale_height_m, fog.base_height_m, fog.density_per_m, fog.anisotropy) = (1.5, 0.5, 0.15, 0.5);
        // Lamps in thick fog are no larger than a pixel at this size.
        fog.half = false;
    });
    let truth = truth(&scene, &request);
    check("height", &truth, &found(&mut renderer, &scene, &request, SAMPLES));
}

#[test]
fn parallel_light_in_fog_that_begins_at_a_distance_is_the_closed_form() {
    let projection = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 100.0 };
    let mut builder = SceneBuilder::new(Vec3::ZERO, Vec3::NEG_Z, projection);
    builder.put(primitives::cube(Vec3::new(1.0, 20.0, 1.0)), black(1.0), at(Vec3::new(-1.0, 0.0, -10.5)));
    let sun = Light { kind: LightKind::Directional, intensity: 2.0, ..Light::default() };
    builder.light(sun, Vec3::ZERO, Vec3::new(0.0, -0.8, 0.6));
    let scene = builder.finish();
    let mut renderer = renderer();
    let fog = |half: bool| {
        request(&scene).with(|settings| {
            settings.shadows.enabled = false;
            let fog = &mut settings.fog;
            (fog.half, fog.start_m, fog.anisotropy, fog.density_per_m, fog.far_m) = (half, 4.0, 0.4, 0.1, 30.0);
        })
    };
    for half in [false, true] {
        renderer.render(&scene, &fog(half)).unwrap();
        let found = radiance(&mut renderer);
        // Light goes towards the eye, which is at +Z, at a cosine of 0.6.
        let phase = (1.0 - 0.16) / (4.0 * PI * (1.0 + 0.16 - 0.8 * 0.6_f64).powf(1.5));
        let row = found.len() / 2;
        for (x, length_m) in [(10, 6.0_f64), (70, 26.0)] {
            let expected = 0.9 * 2.0 * phase * (1.0 - (-0.1 * length_m).exp());
            let found = f64::from(found[row - row % SIZE.0 as usize + x][1]);
            assert!((found - expected).abs() < 0.002 * expected, "{half}, {x}: {found}, not {expected}");
        }
    }
    let passes = |request: &FrameRequest, renderer: &mut Renderer| {
        renderer.plan(&scene, request).unwrap().to_text().matches("fog.").count()
    };
    assert!(passes(&fog(true), &mut renderer) > 0);
    let dark = fog(true).with(|settings| settings.fog.scattering = 0.0);
    assert_eq!(passes(&dark, &mut renderer), 0, "fog that scatters nothing has passes of its light");
}
