//! Pictures that are shaded at less than their own size: what `upscale.method` makes of them, along edges and by the frames
//! before.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use common::plain_request;
use common::shadows::shared;
use glam::{Quat, Vec3};
use manypass::{Averaging, FrameRequest, Path, Renderer, Settings, UpscaleMethod};
use manypass_scene::{Material, Node, Projection, Scene, ShadingModel, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};

const SIZE: (u32, u32) = (96, 64);

/// Of one colour whatever the light.
fn flat(albedo: f32) -> Material {
    Material { shading_model: ShadingModel::Unlit, ..grey(albedo) }
}

/// Parallel rays along −z, 24 pixels a metre in a picture of 64 rows.
fn flat_scene() -> SceneBuilder {
    let projection = Projection::Orthographic { height_m: 64.0 / 24.0, near_m: 0.1, far_m: 20.0 };
    SceneBuilder::new(Vec3::Z * 5.0, Vec3::ZERO, projection)
}

fn bar(width_m: f32, height_m: f32) -> manypass_scene::Primitive {
    primitives::cube(Vec3::new(width_m, height_m, 0.02))
}

/// Bright bars, turned by 0.1 to 0.7, before a dark wall.
fn slanted() -> Scene {
    let mut builder = flat_scene();
    builder.put(bar(9.0, 9.0), flat(0.05), at(Vec3::NEG_Z));
    for index in 0..4 {
        let angle = 0.1 + 0.2 * index as f32;
        let node = Node { rotation: Quat::from_rotation_z(angle), ..at(Vec3::X * (index as f32 - 1.5)) };
        builder.put(bar(0.45, 5.0), flat(0.6), node);
    }
    builder.finish()
}

/// A wall whose colour rises evenly to the right and downwards, each channel another way.
fn ramp() -> Scene {
    let mut builder = flat_scene();
    let mut wall = bar(6.0, 6.0);
    let rise = |[x, y, _]: [f32; 3]| [0.35 + 0.1 * x, 0.35 - 0.06 * x + 0.05 * y, 0.35 - 0.09 * y, 1.0];
    wall.colors = wall.positions.iter().copied().map(rise).collect();
    builder.put(wall, flat(1.0), at(Vec3::ZERO));
    builder.finish()
}

fn scaled(scene: &Scene, scale: f32, method: UpscaleMethod) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.render.scale = scale;
        settings.upscale.method = method;
    })
}

fn begin(renderer: &mut Renderer, scene: &Scene) {
    renderer.cut();
    renderer.load(scene).unwrap();
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}

/// The picture of so many samples, all of them everywhere.
fn still(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, sample_count: u32) -> Vec<u8> {
    let request = request.with(|settings| settings.adaptive.threshold = 0.0);
    for sample_index in 0..sample_count {
        let sample = FrameRequest { sample_index, sample_count, goes_on: false, ..request.clone() };
        renderer.render(scene, &sample).unwrap();
    }
    renderer.read_display().unwrap()
}

/// In decibels.
fn psnr(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let squared: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
    10.0 * (255.0 * 255.0 * a.len() as f64 / squared.max(1e-9)).log10()
}

#[test]
fn what_is_even_or_rises_evenly_stays_as_it_is() {
    let scene = ramp();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    for scale in [0.5, 0.67, 0.9] {
        let shown = radiance(&mut renderer, &scene, &scaled(&scene, scale, UpscaleMethod::Edges));
        let whole = radiance(&mut renderer, &scene, &scaled(&scene, 1.0, UpscaleMethod::Edges));
        // Beyond the middles of the outermost pixels nothing is known.
        let is_inside = |at: &usize| (3..93).contains(&(at % 96)) && (3..61).contains(&(at / 96));
        let worst = (0..shown.len()).filter(is_inside).flat_map(|at| (0..3).map(move |c| (at, c)));
        let worst = worst.map(|(at, c)| (shown[at][c] - whole[at][c]).abs()).fold(0.0, f32::max);
        println!("scale {scale}: off by at most {worst:.6}");
        // Half floats between 0.25 and 0.5 have steps of 0.00025, and what is shaded is rounded first.
        assert!(worst < 5e-4, "scale {scale}: {worst}");
        let spread = whole.iter().map(|p| p[0]).fold(0.0, f32::max) - whole.iter().map(|p| p[0]).fold(1.0, f32::min);
        assert!(spread > 0.3, "the wall is even");
    }
}

#[test]
fn edges_are_nearer_to_those_of_a_full_picture() {
    let scene = slanted();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    for path in [Path::Deferred, Path::Forward] {
        for (scale, least_db) in [(0.5, 1.0), (0.67, 0.6)] {
            for samples in [1, 16] {
                let mut of = |scale: f32, method: UpscaleMethod, samples: u32| {
                    let request = scaled(&scene, scale, method).with(|settings| settings.render.path = path);
                    let request = FrameRequest { averaging: Averaging::Display, ..request };
                    still(&mut renderer, &scene, &request, samples)
                };
                let whole = of(1.0, UpscaleMethod::Bilinear, 64);
                let [bilinear, edges] = [UpscaleMethod::Bilinear, UpscaleMethod::Edges]
                    .map(|method| psnr(&of(scale, method, samples), &whole));
                println!("{path:?}, scale {scale}, {samples} samples: {edges:.2} dB, bilinear {bilinear:.2} dB");
                assert!(edges > bilinear + least_db, "{path:?} {scale} {samples}: {edges} {bilinear}");
            }
        }
    }
}

#[test]
fn no_pixel_is_brighter_or_darker_than_those_around() {
    let scene = slanted();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let small = FrameRequest { width: 48, height: 32, ..scaled(&scene, 1.0, UpscaleMethod::Edges) };
    let small = radiance(&mut renderer, &scene, &small);
    let shown = radiance(&mut renderer, &scene, &scaled(&scene, 0.5, UpscaleMethod::Edges));
    let at = |x: i32, y: i32| small[(y.clamp(0, 31) * 48 + x.clamp(0, 47)) as usize][1];
    let mut between = 0;
    for (index, pixel) in shown.iter().enumerate() {
        let first = |side: usize| (0.5 * (side as f32 + 0.5) - 0.5).floor() as i32;
        let (x, y) = (first(index % 96), first(index / 96));
        let four = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        let (least, most) = (four.iter().copied().fold(1.0, f32::min), four.iter().copied().fold(0.0, f32::max));
        assert!(pixel[1] > least - 3e-4 && pixel[1] < most + 3e-4, "pixel {index}: {} of {four:?}", pixel[1]);
        between += usize::from(pixel[1] > least + 0.01 && pixel[1] < most - 0.01);
    }
    assert!(between > 100, "{between} pixels of edges");
}

#[test]
fn it_is_not_there_where_nothing_is_enlarged() {
    let scene = slanted();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let mut passes = |scale: f32, method: UpscaleMethod| -> Vec<String> {
        let plan = renderer.plan(&scene, &scaled(&scene, scale, method)).unwrap();
        plan.passes.iter().map(|pass| pass.name.to_string()).filter(|name| name.starts_with("upscale")).collect()
    };
    let none: [String; 0] = [];
    assert_eq!(passes(1.0, UpscaleMethod::Edges), none);
    assert_eq!(passes(2.0, UpscaleMethod::Edges), none);
    assert_eq!(passes(0.5, UpscaleMethod::Bilinear), none);
    assert_eq!(passes(0.5, UpscaleMethod::Edges), ["upscale"]);
    let mut pictures = |method| still(&mut renderer, &scene, &scaled(&scene, 1.0, method), 1);
    assert!(
        pictures(UpscaleMethod::Edges) == pictures(UpscaleMethod::Bilinear),
        "at the picture's size nothing changes"
    );
    assert_eq!(Settings::default().upscale.method, UpscaleMethod::Bilinear);
}

#[test]
fn any_size_is_enlarged() {
    let scene = slanted();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    for (width, height) in [(1, 1), (1, 2048), (2048, 1), (97, 73)] {
        for scale in [0.25, 0.5, 0.99] {
            let request = FrameRequest { width, height, ..scaled(&scene, scale, UpscaleMethod::Edges) };
            let shown = radiance(&mut renderer, &scene, &request);
            assert_eq!(shown.len(), (width * height) as usize);
            assert!(shown.iter().flatten().all(|value| (0.0..=0.61).contains(value)), "{width}x{height} at {scale}");
        }
    }
}
