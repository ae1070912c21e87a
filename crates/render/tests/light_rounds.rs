//! Pictures of several samples in which lights take turns: edges of lamps are as smooth as where all lights shine in
//! every sample, and nothing else is brighter or darker for it.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::shadows::{light, perspective};
use crate::common::{plain_request, renderer};
use glam::{Quat, Vec3};
use manypass::{Averaging, Background, FogMode, FrameRequest, Path, Renderer};
use manypass_scene::{AlphaMode, Light, LightKind, Material, Node, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::raycast::{Camera, Options, World};

const SIZE: (u32, u32) = (80, 60);
const SAMPLES: u32 = 16;
/// Rays along a side of a pixel for the share of it that lamps cover.
const RAYS: usize = 8;
/// Of lamps: thirty times the display's white.
const GLOW: f32 = 30.0;

/// A floor under 64 lights, above it a lamp before a black wall that ends above it, and in front of another lamp a pane
/// that hides half of it, and is drawn as if one could see through.
fn scene(pane_alpha: AlphaMode) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.5, 7.0), Vec3::new(0.0, 1.2, 0.0), perspective());
    builder.put(primitives::plane(8.0), grey(0.5), at(Vec3::ZERO));
    for i in 0..64_u8 {
        let place = Vec3::new(f32::from(i % 8) - 3.5, 0.3, f32::from(i / 8) - 3.5);
        builder.put(primitives::cube(Vec3::splat(0.2)), grey(0.5), at(place - Vec3::Y * 0.2));
        let lamp = Light { range_m: Some(2.0), ..light(LightKind::Point, 0.3) };
        builder.light(lamp, place + Vec3::new(0.2, 0.2, 0.3), Vec3::NEG_Y);
    }
    let glowing = Material { emissive_factor: Vec3::splat(GLOW), ..grey(0.0) };
    let turned = |place| Node { rotation: Quat::from_rotation_z(0.3), ..at(place) };
    builder.put(primitives::cube(Vec3::new(1.4, 0.9, 0.1)), glowing.clone(), turned(Vec3::new(-1.3, 3.0, 0.0)));
    builder.put(primitives::cube(Vec3::new(0.9, 0.9, 0.1)), glowing, turned(Vec3::new(1.3, 1.0, 1.0)));
    builder.put(primitives::cube(Vec3::new(8.0, 3.0, 0.1)), grey(0.0), at(Vec3::new(0.0, 1.6, -4.5)));
    let pane = Material { alpha_mode: pane_alpha, ..grey(0.8) };
    builder.put(primitives::cube(Vec3::new(0.8, 1.6, 0.02)), pane, at(Vec3::new(1.7, 0.9, 1.3)));
    builder.finish()
}

fn request(scene: &Scene, averaging: Averaging) -> FrameRequest {
    let request = plain_request(scene, SIZE).with(|settings| {
        settings.shadows.enabled = true;
        settings.shadows.atlas_px = 256;
    });
    FrameRequest { averaging, ..request }
}

/// Renders all samples. Gives the picture over black in linear light, red alone: all is grey.
fn display(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, samples: u32) -> Vec<f32> {
    let light_rounds = renderer.light_rounds(scene, request).unwrap();
    assert!(light_rounds > Some(1) || !request.settings.shadows.enabled, "all lights have room at once");
    let frames_per_sample = light_rounds.unwrap_or(1).div_ceil(samples);
    let sample_count = samples * frames_per_sample;
    for sample_index in 0..sample_count {
        let request = FrameRequest { sample_index, sample_count, frames_per_sample, light_rounds, ..request.clone() };
        renderer.render(scene, &request).unwrap();
    }
    let linear =
        |encoded: f32| if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
    let over_black = |pixel: &[u8]| linear(f32::from(pixel[0]) / 255.0) * f32::from(pixel[3]) / 255.0;
    renderer.read_display().unwrap().chunks_exact(4).map(over_black).collect()
}

/// Of every pixel the share that lamps cover, and whether nothing but the dark is beside them: the wall, which is far
/// away, or what is behind all.
fn lamps(scene: &Scene) -> Vec<(f32, bool)> {
    let mut world = World::of_scene(scene, Camera::of_scene(scene).unwrap());
    world.lights.clear();
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let options = Options { multiple_scattering: false, ..Options::default() };
    let seen = world.render(width * RAYS, height * RAYS, options);
    let of_pixel = |pixel: usize| {
        let rays = (0..RAYS * RAYS).map(|ray| {
            let (x, y) = ((pixel % width) * RAYS + ray % RAYS, (pixel / width) * RAYS + ray / RAYS);
            y * width * RAYS + x
        });
        let glows = |at: usize| seen.radiance[at][0] > 0.5 * GLOW;
        let covered = rays.clone().filter(|at| glows(*at)).count();
        (covered as f32 / (RAYS * RAYS) as f32, rays.clone().all(|at| glows(at) || seen.depth_view_m[at] > 10.0))
    };
    (0..width * height).map(of_pixel).collect()
}

#[test]
fn edges_of_lamps_are_smooth_where_lights_take_turns() {
    let scene = scene(AlphaMode::Blend);
    let lamps = lamps(&scene);
    let edges: Vec<usize> =
        (0..lamps.len()).filter(|at| matches!(lamps[*at], (share, true) if share > 0.05 && share < 0.95)).collect();
    assert!(edges.len() > 40, "{} pixels", edges.len());
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut error = |averaging, change: &dyn Fn(&mut FrameRequest)| {
        let mut request = request(&scene, averaging);
        change(&mut request);
        let found = display(&mut renderer, &scene, &request, SAMPLES);
        edges.iter().map(|at| (found[*at] - lamps[*at].0).abs()).sum::<f32>() / edges.len() as f32
    };
    let without_shadows = error(Averaging::Display, &|request| request.settings.shadows.enabled = false);
    // Sixteen places in a pixel tell shares of it to within a sixteenth, as they do where all lights shine in every
    // sample.
    let most = without_shadows.min(0.07) + 0.001;
    let paths = [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud];
    let mut found: Vec<(String, f32)> = paths
        .map(|path| (format!("{path:?}"), error(Averaging::Display, &|request| request.settings.render.path = path)))
        .into();
    let transparent = |request: &mut FrameRequest| request.settings.background.source = Background::Transparent;
    found.push(("transparent".into(), error(Averaging::Both, &transparent)));
    // Each sample has four texels.
    let finer = |request: &mut FrameRequest| {
        transparent(request);
        request.settings.render.scale = 2.0;
    };
    found.push(("scale".into(), error(Averaging::Display, &finer)));
    println!("{found:?}, without shadows {without_shadows}");
    for (name, error) in &found {
        assert!(*error < most, "{name}: {error}");
    }
    // The test can fail.
    let of_radiance = error(Averaging::Radiance, &|_| ());
    assert!(of_radiance > 0.2, "{of_radiance}");
}

#[test]
fn lights_that_take_turns_are_as_bright_as_in_the_mean_of_radiance() {
    let mut renderer = renderer();
    // A pane that is drawn after the lamp behind it, and lit by lights that take turns, is no part of what glows.
    for (path, pane_alpha) in [(Path::Deferred, AlphaMode::Blend), (Path::Forward, AlphaMode::Opaque)] {
        let scene = scene(pane_alpha);
        let lamps = lamps(&scene);
        renderer.load(&scene).unwrap();
        for samples in [1, 2, SAMPLES] {
            let request = |averaging| request(&scene, averaging).with(|settings| settings.render.path = path);
            let of_radiance = display(&mut renderer, &scene, &request(Averaging::Radiance), samples);
            let radiance = renderer.read_radiance().unwrap();
            let of_parts = display(&mut renderer, &scene, &request(Averaging::Both), samples);
            assert!(renderer.read_radiance().unwrap() == radiance, "{path:?} {samples}: linear files are others");
            let inner = |at: &usize| samples == 1 || lamps[*at].0 == 0.0 || lamps[*at].0 == 1.0;
            let wrong = |at: &usize| (of_parts[*at] - of_radiance[*at]).abs() > 0.01;
            let count = (0..lamps.len()).filter(inner).filter(wrong).count();
            assert_eq!(count, 0, "{path:?} {samples}: pixels differ");
        }
    }
}

#[test]
fn a_lamp_that_fog_hides_leaves_the_fog_as_bright_as_in_the_mean_of_radiance() {
    let mut scene = scene(AlphaMode::Opaque);
    scene.lights.iter_mut().for_each(|light| light.intensity *= 300.0);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    for path in [Path::Deferred, Path::Forward] {
        let [of_radiance, of_parts] = [Averaging::Radiance, Averaging::Display].map(|averaging| {
            let request = request(&scene, averaging).with(|settings| {
                settings.render.path = path;
                (settings.fog.mode, settings.fog.density_per_m) = (FogMode::Exponential, 0.9);
                (settings.fog.scattering, settings.fog.intensity) = (1.0, 0.0);
            });
            display(&mut renderer, &scene, &request, SAMPLES)
        });
        let worst = of_parts.iter().zip(&of_radiance).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let bright = of_radiance.iter().filter(|value| (0.2..0.9).contains(*value)).count();
        println!("{path:?}: {bright} bright pixels, worst {worst}");
        assert!(worst < 0.01 && bright > 100, "{path:?}: {worst}");
    }
}
