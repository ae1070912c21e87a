//! Pictures that are shaded at less than their own size: what `upscale.method` makes of them, along edges and by the frames
//! before.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::flat::{
    SIZE, bar, begin, body_before_wall, difference, fence, flat, flat_scene, ghost, live, picture, still, still_of,
};
use crate::common::plain_request;
use crate::common::shadows::shared;
use glam::{Quat, Vec3};
use manypass::{Averaging, EffectFile, FrameRequest, Path, Renderer, Settings, UpscaleMethod, WgslEffect};
use manypass_scene::{Node, Scene};
use manypass_testkit::build::at;
use std::sync::Arc;

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

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
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
        // Half floats between 0.5 and 1 have steps of 0.0005, and what is shaded is rounded first.
        assert!(worst < 1e-3, "scale {scale}: {worst}");
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
                    still_of(&mut renderer, &scene, &request, samples)
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
    let mut pictures = |method| still_of(&mut renderer, &scene, &scaled(&scene, 1.0, method), 1);
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
    for (width, height) in [(1, 1), (1, 4096), (4096, 1), (97, 73)] {
        for scale in [0.25, 0.5, 0.99] {
            let request = FrameRequest { width, height, ..scaled(&scene, scale, UpscaleMethod::Edges) };
            let shown = radiance(&mut renderer, &scene, &request);
            assert_eq!(shown.len(), (width * height) as usize);
            assert!(shown.iter().flatten().all(|value| (0.0..=0.61).contains(value)), "{width}x{height} at {scale}");
        }
    }
}

/// The next of frames that follow each other, shaded at so many times the picture's size.
fn temporal(scene: &Scene, scale: f32) -> FrameRequest {
    live(scene).with(|settings| {
        settings.render.scale = scale;
        settings.upscale.method = UpscaleMethod::Temporal;
    })
}

#[test]
fn frames_of_half_the_size_converge_to_the_full_still() {
    let scene = fence();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let still = still(&mut renderer, &scene, &live(&scene));
    let mut last_of = |request: &FrameRequest, frames: usize, moves: bool| {
        renderer.cut();
        let moved = |frame: usize| FrameRequest { ground_height_m: moves.then_some(frame as f32), ..request.clone() };
        let pictures: Vec<_> = (0..frames).map(|frame| picture(&mut renderer, &scene, &moved(frame))).collect();
        let [before, last] = &pictures[frames - 2..] else { panic!("two frames at least") };
        (difference(last, &still), difference(before, last))
    };
    for (scale, moves, most) in [(0.5, false, 1.9), (0.67, false, 1.7), (0.5, true, 2.6), (0.67, true, 2.1)] {
        let ((off, _), (shimmer, step)) = last_of(&temporal(&scene, scale), 192, moves);
        println!("scale {scale}, moves {moves}: off by {off:.3}, from frame to frame {shimmer:.3}, at most {step}");
        assert!(off < most && shimmer < 0.2, "scale {scale}, moves {moves}: {off} {shimmer}");
        // Frames that are enlarged after they were averaged stay soft.
        let soft = temporal(&scene, scale).with(|settings| settings.upscale.method = UpscaleMethod::Edges);
        let ((off_of_soft, _), _) = last_of(&soft, 192, moves);
        println!("    enlarged afterwards: off by {off_of_soft:.3}");
        assert!(off < 0.2 * off_of_soft, "{off} {off_of_soft}");
    }
}

#[test]
fn a_body_leaves_no_ghost_in_enlarged_frames() {
    let mut renderer = shared();
    for scale in [0.5, 0.67] {
        for distance_m in [1.5, 0.05] {
            let (scene, body) = body_before_wall(distance_m);
            let scenes: Vec<Scene> = (0..8)
                .map(|frame| {
                    let mut moved = scene.clone();
                    moved.node_mut(body).translation.x = -1.5 + frame as f32 / 3.0;
                    moved.update_transforms();
                    moved
                })
                .collect();
            let request = temporal(&scene, scale);
            let dark = picture(&mut renderer, &scene, &request)[4 * (96 * 2 + 90) + 1];
            let found = ghost(&mut renderer, &scenes, &request);
            println!("scale {scale}, {distance_m} m before the wall of {dark}: {found}");
            assert!(found <= dark + 3, "scale {scale}, {distance_m} m: {found}, the wall is {dark}");
        }
    }
}

/// Shows where in the view pixels are, what is known of their surfaces, and how far away these are.
const READS_DEPTH: &str = "\
//! effect reads_depth
//! reads: depth, normal, motion

@fragment
fn fs_reads_depth(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let position_view = position_view_from_pixel(position.xy, distance_at(pixel));
    let moved = textureLoad(motion, pixel, 0).xy;
    let facing = normal_world_at(pixel).z;
    return vec4f(position_view.x * 0.2 + 0.5, facing * 0.5 + moved.x, 0.1 * distance_at(pixel), 1.0);
}
";

#[test]
fn effects_after_it_see_the_full_picture() {
    let scene = slanted();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let file = EffectFile::parse("reads_depth.wgsl", READS_DEPTH).unwrap();
    let effect = Arc::new(WgslEffect::compile(renderer.gpu(), file).unwrap());
    let mut shown = |scale: f32| {
        renderer.cut();
        let mut request = FrameRequest { averaging: Averaging::Both, ..temporal(&scene, scale) };
        request.effects = vec![effect.clone()];
        radiance(&mut renderer, &scene, &request)
    };
    let (whole, enlarged) = (shown(1.0), shown(0.5));
    for (at, (a, b)) in whole.iter().zip(&enlarged).enumerate() {
        assert!((a[0] - b[0]).abs() < 2e-3 && (a[1] - b[1]).abs() < 2e-3, "pixel {at}: {a:?} {b:?}");
    }
    // Pixels along edges may have the sample of the other side.
    let same = whole.iter().zip(&enlarged).filter(|(a, b)| (a[2] - b[2]).abs() < 2e-3).count();
    println!("{same} of {} pixels are as far away", whole.len());
    assert!(same > whole.len() * 9 / 10, "{same} of {} pixels are as far away", whole.len());
    let names: Vec<String> = {
        let plan = renderer.plan(&scene, &temporal(&scene, 0.5)).unwrap();
        plan.passes.iter().map(|pass| pass.name.to_string()).filter(|name| name.starts_with("nearest")).collect()
    };
    assert!(names.is_empty(), "nobody reads {names:?}");
}
