//! Light that fog scatters, against numerical integration along the rays of the ray caster: directional light, spots and
//! points with and without a range, with their shadows, before opaque and blended surfaces and before nothing.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use common::{plain_request, renderer};
use glam::{DVec3, Vec3, Vec4};
use manypass::{FogMode, FrameRequest, LightCulling, Path, Renderer};
use manypass_scene::{AlphaMode, Light, LightKind, Material, Projection, Scene, ShadingModel, primitives};
use manypass_testkit::build::{SceneBuilder, at};
use manypass_testkit::compare::{LinearDifference, linear_difference};
use manypass_testkit::raycast::{Camera, Medium, Options, PixelPattern, World};

const SIZE: (u32, u32) = (96, 54);
const SAMPLES: u32 = 64;

/// A row of columns under a roof with gaps, before the sky; surfaces are black, so that only fog is seen, and a pane of dark
/// glass covers a part of it.
fn scene() -> Scene {
    let projection = Projection::Perspective { fov_y_rad: 0.9, near_m: 0.1, far_m: None };
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.7, 6.0), Vec3::new(0.3, 2.4, 0.0), projection);
    let black = |alpha: f32| Material {
        base_color_factor: Vec4::new(0.0, 0.0, 0.0, alpha),
        shading_model: ShadingModel::Unlit,
        alpha_mode: if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque },
        ..Material::default()
    };
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
        medium_steps: 5,
        ..Options::default()
    };
    world.render(SIZE.0 as usize, SIZE.1 as usize, options).radiance
}

/// The mean of [`SAMPLES`] samples.
fn found(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    for sample_index in 0..SAMPLES {
        let request = FrameRequest { sample_index, sample_count: SAMPLES, ..request.clone() };
        renderer.render(scene, &request).unwrap();
    }
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
    if let Ok(folder) = std::env::var("MANYPASS_TEST_DUMP") {
        for (name, pixels) in [("truth", truth), ("found", found)] {
            std::fs::write(format!("{folder}/{what}.{name}.raw"), bytemuck::cast_slice::<_, u8>(pixels)).unwrap();
        }
    }
    let difference = difference(truth, found);
    let (mean, share) = (difference.mean, difference.share_within(0.06));
    println!("{what}: mean error {:.3} %, within 6 %: {:.2} %", 100.0 * mean, 100.0 * share);
    if std::env::var("MANYPASS_TEST_DUMP").is_ok() { return; }
    assert!(mean <= 0.02 && share >= 0.95, "{what}: mean error {mean}, within 6 %: {share}");
}

#[test]
fn light_in_uniform_fog_is_that_of_the_ray_caster() {
    let scene = scene();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = request(&scene);
    let truth = truth(&scene, &request);
    let at_half = found(&mut renderer, &scene, &request);
    let full = request.with(|settings| settings.fog.half = false);
    check("deferred", &truth, &found(&mut renderer, &scene, &full));
    check("deferred, half", &truth, &at_half);
    let forward = full.with(|settings| settings.render.path = Path::Forward);
    check("forward", &truth, &found(&mut renderer, &scene, &forward));
    let gouraud = full.with(|settings| settings.render.path = Path::Gouraud);
    check("gouraud", &truth, &found(&mut renderer, &scene, &gouraud));
    for culling in [LightCulling::None, LightCulling::Tiled, LightCulling::VolumesStencil] {
        let request = full.with(|settings| settings.lights.culling = culling);
        check(&format!("{culling:?}"), &truth, &found(&mut renderer, &scene, &request));
    }
    // The test can fail: without shadows light is everywhere.
    let unshadowed = full.with(|settings| settings.shadows.enabled = false);
    let difference = difference(&truth, &found(&mut renderer, &scene, &unshadowed));
    assert!(difference.mean > 0.1, "shadows make no difference: {}", difference.mean);
}

#[test]
fn light_in_fog_that_thins_out_upwards_is_that_of_the_ray_caster() {
    let scene = scene();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = request(&scene).with(|settings| {
        let fog = &mut settings.fog;
        (fog.scale_height_m, fog.base_height_m, fog.density_per_m, fog.anisotropy) = (1.5, 0.5, 0.15, 0.5);
    });
    let truth = truth(&scene, &request);
    check("height", &truth, &found(&mut renderer, &scene, &request));
}
