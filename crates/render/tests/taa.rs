//! Anti-aliasing over time: against stills of 64 samples where nothing moves and where the camera does, and what it must
//! not leave behind what moves.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use common::shadows::shared;
use common::{plain_request, renderer};
use glam::{Quat, Vec3};
use manypass::{Background, FrameRequest, Path, Renderer};
use manypass_scene::{Material, Node, NodeId, Projection, Scene, ShadingModel, Skin, primitives};
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

/// Bars narrower than a pixel and wider ones, each turned a little, before nothing and before a wall.
fn fence() -> Scene {
    bars(0.012)
}

/// Bars from this width on.
fn bars(width_m: f32) -> Scene {
    let mut builder = flat_scene();
    builder.put(bar(2.0, 4.0), flat(0.05), at(Vec3::new(1.0, 0.0, -1.0)));
    for index in 0..17 {
        let across = index as f32 / 16.0 - 0.5;
        let node = Node { rotation: Quat::from_rotation_z(0.25 * across), ..at(Vec3::X * 3.7 * across) };
        builder.put(bar(width_m + 0.003 * index as f32, 4.0), flat(0.7), node);
    }
    builder.put(bar(4.0, 0.02), flat(0.5), Node { rotation: Quat::from_rotation_z(0.03), ..at(Vec3::Z * 0.1) });
    builder.finish()
}

/// The next of frames that follow each other.
fn live(scene: &Scene) -> FrameRequest {
    let request = plain_request(scene, SIZE).with(|settings| {
        settings.taa.enabled = true;
        settings.background.source = Background::Color([0.03; 3]);
    });
    FrameRequest { goes_on: true, averaging: manypass::Averaging::Display, ..request }
}

/// A view of its own has no frames before.
fn begin(renderer: &mut Renderer, scene: &Scene) {
    renderer.cut();
    renderer.load(scene).unwrap();
}

fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<u8> {
    renderer.render(scene, request).unwrap();
    renderer.read_display().unwrap()
}

/// The picture of 64 samples, all of them everywhere.
fn still(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<u8> {
    let request = request.with(|settings| settings.adaptive.threshold = 0.0);
    for sample_index in 0..64 {
        let sample = FrameRequest { sample_index, sample_count: 64, goes_on: false, ..request.clone() };
        renderer.render(scene, &sample).unwrap();
    }
    renderer.read_display().unwrap()
}

/// The mean difference of channels, of 255, and the largest.
fn difference(a: &[u8], b: &[u8]) -> (f64, u8) {
    let of = |(a, b): (&u8, &u8)| a.abs_diff(*b);
    let sum: f64 = a.iter().zip(b).map(|pair| f64::from(of(pair))).sum();
    (sum / a.len() as f64, a.iter().zip(b).map(of).max().unwrap())
}

fn squared(a: &[u8], b: &[u8]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>() / a.len() as f64
}

#[test]
fn a_static_fence_converges_to_its_still_and_does_not_shimmer() {
    let scene = fence();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let request = live(&scene);
    let still = still(&mut renderer, &scene, &request);
    // Where something moves elsewhere, as the height of a ground that is not there, frames do not know that the fence
    // stands still.
    let of = |renderer: &mut Renderer, request: &FrameRequest, moves: bool| {
        renderer.cut();
        let moved = |frame: u16| FrameRequest { ground_height_m: moves.then(|| frame.into()), ..request.clone() };
        let frames: Vec<_> = (0..192).map(|frame| picture(renderer, &scene, &moved(frame))).collect();
        let settled = &frames[128..];
        let mean: Vec<f64> = (0..still.len())
            .map(|at| settled.iter().map(|frame| f64::from(frame[at])).sum::<f64>() / settled.len() as f64)
            .collect();
        let off = mean.iter().zip(&still).map(|(mean, still)| (mean - f64::from(*still)).abs()).sum::<f64>();
        let steps: Vec<_> = settled.windows(2).map(|pair| difference(&pair[0], &pair[1])).collect();
        let shimmer = steps.iter().map(|(mean, _)| mean).sum::<f64>() / steps.len() as f64;
        let last = difference(&frames[191], &still).0;
        (off / mean.len() as f64, last, shimmer, steps.iter().map(|(_, most)| *most).max().unwrap())
    };
    let mut least = (f64::INFINITY, f64::INFINITY);
    for (moves, most_off, most_step) in [(false, 1.0, 12), (true, 1.15, 96)] {
        let (off, last, shimmer, most) = of(&mut renderer, &request, moves);
        println!("off by {off:.3}, the last frame by {last:.3}, from frame to frame {shimmer:.4}, at most {most}");
        assert!(
            off < most_off && last < most_off && shimmer < 0.25 && most < most_step,
            "{off} {last} {shimmer} {most}"
        );
        least = (least.0.min(last), least.1.min(shimmer));
    }
    // The same frames without those before them.
    let alone = request.with(|settings| (settings.taa.samples, settings.taa.feedback) = (1, 0.0));
    let (_, last, shimmer, _) = of(&mut renderer, &alone, false);
    println!("alone: {last:.3}, {shimmer:.4}");
    assert!(last > 4.0 * least.0 && shimmer > 40.0 * least.1, "{last} {shimmer}");
}

/// A bright body that moves by 8 pixels a frame over a dark wall, so far before it.
fn body_before_wall(distance_m: f32) -> (Scene, NodeId) {
    let mut builder = flat_scene();
    builder.put(bar(9.0, 9.0), flat(0.02), at(Vec3::Z * -0.02));
    let body = builder.put(bar(0.5, 1.5), flat(0.7), at(Vec3::new(-1.5, 0.0, distance_m)));
    (builder.finish(), body)
}

/// Of each pixel whether it is bright.
fn is_bright(picture: &[u8]) -> Vec<bool> {
    picture.chunks_exact(4).map(|pixel| pixel[1] > 100).collect()
}

/// The brightest that what moves leaves where it was in the frame before the last one, and not since; `scenes` are of
/// frames that follow each other.
fn ghost(renderer: &mut Renderer, scenes: &[Scene], request: &FrameRequest) -> u8 {
    begin(renderer, &scenes[0]);
    let bare = request.with(|settings| settings.taa.enabled = false);
    let mut was: Vec<Vec<bool>> = Vec::new();
    let mut brightest = 0;
    for (frame, scene) in scenes.iter().enumerate() {
        let shown = picture(renderer, scene, request);
        // A picture without it leaves alone what frames keep.
        was.push(is_bright(&picture(renderer, scene, &bare)));
        // Frames look at most half a pixel beside the middle, and boxes are of the pixels around.
        let near = |mask: &[bool], at: usize| {
            let (x, y) = ((at % 96) as i32, (at / 96) as i32);
            let inside = |x: i32, y: i32| (0..96).contains(&x) && (0..64).contains(&y);
            (-2..=2).any(|dy| (-2..=2).any(|dx| inside(x + dx, y + dy) && mask[((y + dy) * 96 + x + dx) as usize]))
        };
        if frame >= 2 {
            let left =
                (0..96 * 64).filter(|at| was[frame - 2][*at] && !near(&was[frame - 1], *at) && !near(&was[frame], *at));
            let found: Vec<u8> = left.map(|at| shown[4 * at + 1]).collect();
            assert!(found.len() > 10, "frame {frame}: the test looks at {} pixels", found.len());
            brightest = found.into_iter().chain([brightest]).max().unwrap();
        }
    }
    brightest
}

#[test]
fn a_body_leaves_no_ghost_behind() {
    let mut renderer = shared();
    // Near the wall depth tells nothing, and colours alone do.
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
        let request = live(&scene);
        let dark = picture(&mut renderer, &scene, &request)[4 * (96 * 2 + 90) + 1];
        let found = ghost(&mut renderer, &scenes, &request);
        println!("{distance_m} m before the wall of {dark}: {found}");
        assert!(found <= dark + 3, "{distance_m} m: {found}, the wall is {dark}");
    }
}

/// A limb of stripes that a skin turns around its end, before a wall; in frames that follow each other.
fn limb() -> Vec<Scene> {
    let mut builder = flat_scene();
    builder.put(bar(9.0, 9.0), flat(0.02), at(Vec3::Z * -1.0));
    let mut scene = builder.finish();
    let joint = scene.add_node(None, at(Vec3::new(-0.8, -0.9, 0.0)));
    scene.skins.push(Skin { joints: vec![joint], inverse_bind_matrices: Vec::new() });
    for stripe in 0..12 {
        let mut primitive = bar(0.09, 0.4);
        primitive.positions.iter_mut().for_each(|position| position[0] += 0.25 + 0.15 * stripe as f32);
        primitive.bounds = manypass_scene::Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from));
        primitive.joints = vec![[0; 4]; primitive.positions.len()];
        primitive.weights = vec![[1.0, 0.0, 0.0, 0.0]; primitive.positions.len()];
        primitive.material = Some(scene.materials.len());
        scene.materials.push(flat(0.7));
        let mesh = Some(scene.meshes.len());
        let mesh_of = manypass_scene::Mesh { primitives: vec![primitive], ..Default::default() };
        scene.meshes.push(mesh_of.into());
        let node = scene.add_node(None, Node { mesh, ..Node::default() });
        scene.node_mut(node).skin = Some(0);
    }
    let turned = |frame: usize| {
        let mut scene = scene.clone();
        scene.node_mut(joint).rotation = Quat::from_rotation_z(0.1 * frame as f32);
        scene.update_transforms();
        scene
    };
    (0..10).map(turned).collect()
}

#[test]
fn the_limbs_of_a_skinned_figure_are_followed() {
    let scenes = limb();
    let mut renderer = shared();
    let request = live(&scenes[0]);
    begin(&mut renderer, &scenes[0]);
    let dark = picture(&mut renderer, &scenes[0], &request)[4 * (96 * 60 + 90) + 1];
    let found = ghost(&mut renderer, &scenes, &request);
    println!("behind the limb {found}, the wall is {dark}");
    assert!(found <= dark + 3, "behind the limb {found}, the wall is {dark}");
    // Who knows where stripes were has smooth edges of them.
    let last = scenes.last().unwrap();
    let still = still(&mut renderer, last, &request);
    let mut error = |request: &FrameRequest| {
        renderer.cut();
        let shown = scenes.iter().map(|scene| picture(&mut renderer, scene, request)).last().unwrap();
        squared(&shown, &still)
    };
    let (smooth, bare) = (error(&request), error(&request.with(|settings| settings.taa.enabled = false)));
    println!("squared error {smooth:.1}, without {bare:.1}");
    assert!(smooth < 0.7 * bare, "squared error {smooth}, without {bare}");
}

#[test]
fn a_camera_that_pans_keeps_edges_smooth() {
    // Of two pixels and more: what some frames miss is not kept where it moves.
    let scene = bars(0.08);
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let mut error = |is_on: bool| {
        renderer.cut();
        let mut request = live(&scene).with(|settings| settings.taa.enabled = is_on);
        for frame in 0..12 {
            request.camera.world_from_view.w_axis.x = 0.05 * frame as f32;
            request.camera.world_from_view.w_axis.y = -0.02 * frame as f32;
            renderer.render(&scene, &request).unwrap();
        }
        let shown = renderer.read_display().unwrap();
        squared(&shown, &still(&mut renderer, &scene, &request))
    };
    let (smooth, bare) = (error(true), error(false));
    println!("squared error {smooth:.1}, without {bare:.1}");
    assert!(smooth < 0.7 * bare, "squared error {smooth}, without {bare}");
}

#[test]
fn pictures_that_begin_anew_are_as_if_alone() {
    let scene = fence();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = live(&scene);
    let bare = picture(&mut renderer, &scene, &request.with(|settings| settings.taa.enabled = false));
    let near_bare = |shown: &[u8]| assert!(difference(shown, &bare).1 <= 1, "{:?}", difference(shown, &bare));
    near_bare(&picture(&mut renderer, &scene, &request));
    let second = picture(&mut renderer, &scene, &request);
    assert!(difference(&second, &bare).0 > 0.5, "the second frame shows the first one, too");
    // A cut, a frame that follows none, and another size and back.
    renderer.cut();
    near_bare(&picture(&mut renderer, &scene, &request));
    near_bare(&picture(&mut renderer, &scene, &FrameRequest { goes_on: false, ..request.clone() }));
    picture(&mut renderer, &scene, &request);
    picture(&mut renderer, &scene, &FrameRequest { width: 50, height: 20, ..request.clone() });
    renderer.cut();
    near_bare(&picture(&mut renderer, &scene, &request));
    // Looking at its passes in between changes nothing.
    let mut frames = |looks: bool| {
        renderer.cut();
        let mut shown = Vec::new();
        for _ in 0..3 {
            shown = picture(&mut renderer, &scene, &request);
            if looks {
                renderer.passes(&scene, &request).unwrap();
                renderer.pass_times(&scene, &request).unwrap();
            }
        }
        shown
    };
    assert_eq!(frames(false), frames(true));
}

#[test]
fn any_size_goes() {
    let scene = fence();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    for (width, height) in [(1, 1), (1, 2048), (300, 2)] {
        for scale in [1.0, 0.5] {
            let mut request = FrameRequest { width, height, ..live(&scene) };
            request.settings.render.scale = scale;
            renderer.cut();
            for _ in 0..3 {
                let shown = picture(&mut renderer, &scene, &request);
                assert_eq!(shown.len(), (4 * width * height) as usize);
            }
        }
    }
}

#[test]
fn it_is_there_where_frames_follow_each_other_alone() {
    let scene = fence();
    let mut renderer = shared();
    begin(&mut renderer, &scene);
    let mut passes = |request: &FrameRequest| -> Vec<String> {
        let plan = renderer.plan(&scene, request).unwrap();
        let names = plan.passes.iter().map(|pass| pass.name.to_string());
        names.filter(|name| name.starts_with("taa") || name == "motion").collect()
    };
    let live = live(&scene);
    assert_eq!(passes(&live), ["motion", "taa.surface", "taa"]);
    let alone = FrameRequest { goes_on: false, ..live.clone() };
    assert_eq!(passes(&alone), ["motion", "taa.surface", "taa"]);
    let none: [String; 0] = [];
    assert_eq!(passes(&FrameRequest { sample_count: 4, ..alone.clone() }), none);
    // The frames that refine a live picture.
    assert_eq!(passes(&FrameRequest { sample_count: 4, ..live.clone() }), ["motion", "taa.surface", "taa"]);
    assert_eq!(passes(&alone.with(|settings| settings.effects.enabled = false)), none);
    let forward = live.with(|settings| settings.render.path = Path::Forward);
    let error = renderer.plan(&scene, &forward).unwrap_err().to_string();
    assert!(error.contains("taa.enabled=true") && error.contains("render.path=deferred"), "{error}");
}
