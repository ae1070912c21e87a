//! What monitors show: the picture of their camera, how deep they are within each other, when they are drawn, and what
//! costs nothing.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{self, plain_request, renderer};
use glam::{Mat4, Quat, Vec2, Vec3};
use manypass::{Background, FrameRequest, Path, RenderError, Renderer, View};
use manypass_scene::capture::{CaptureOptions, Monitor, MonitorCamera, Update};
use manypass_scene::overlay::{OverlayItem, OverlayPlace};
use manypass_scene::primitives::plane;
use manypass_scene::{Image, Mesh, Node, NodeId, Projection, Sampler, Scene, Texture, TextureRef, Wrap};
use manypass_testkit::scenes;

/// Where the screens are, far from what cameras of monitors see.
const SCREEN: Vec3 = Vec3::new(0.0, 0.0, 500.0);
const SIZE: (u32, u32) = (64, 48);

/// The camera of a test scene, and the scene with a screen that fills the picture of [`before_screen`].
fn with_screen(camera: Option<MonitorCamera>) -> (Scene, FrameRequest) {
    let mut scene = scenes::rows_of_spheres().scene;
    let own = plain_request(&scene, SIZE);
    let View { world_from_view, projection } = own.camera;
    let camera = camera.unwrap_or(MonitorCamera::Fixed { world_from_view, projection });
    scene.images.push(Image::of_monitor("screen", Monitor::new(camera, SIZE.0, SIZE.1)));
    put_screen(&mut scene, SCREEN);
    (scene, own)
}

/// A screen at a place that shows the last image, 64 by 48 metres large.
fn put_screen(scene: &mut Scene, place: Vec3) -> NodeId {
    let sampler = Sampler { wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::ClampToEdge, ..Sampler::default() };
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler });
    let texture = Some(TextureRef { texture: scene.textures.len() - 1, ..TextureRef::default() });
    scene.materials.push(manypass_scene::Material {
        base_color_factor: Vec3::ZERO.extend(1.0),
        emissive_texture: texture,
        emissive_factor: Vec3::ONE,
        ..Default::default()
    });
    let material = Some(scene.materials.len() - 1);
    let square = manypass_scene::Primitive { material, ..plane(1.0) };
    scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
    let node = scene.add_node(
        None,
        Node {
            mesh: Some(scene.meshes.len() - 1),
            translation: place,
            rotation: Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
            scale: Vec3::new(SIZE.0 as f32, 1.0, SIZE.1 as f32),
            ..Node::default()
        },
    );
    scene.update_transforms();
    node
}

/// A camera that sees the screen at a place and nothing else, a pixel for each texel.
fn before(place: Vec3) -> View {
    View {
        world_from_view: Mat4::from_translation(place + 10.0 * Vec3::Z),
        projection: Projection::Orthographic { height_m: SIZE.1 as f32, near_m: 1.0, far_m: 20.0 },
    }
}

fn looking(request: &FrameRequest, camera: View) -> FrameRequest {
    FrameRequest { camera, ..request.clone() }
}

fn drawn(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<u8> {
    for sample_index in 0..request.sample_count {
        renderer.render(scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
    }
    renderer.read_display().unwrap()
}

/// The share of the pixels whose channels differ by at most `within`, and the greatest difference.
fn alike(a: &[u8], b: &[u8], within: u8) -> (f64, u8) {
    assert_eq!(a.len(), b.len());
    let greatest = |(a, b): (&[u8], &[u8])| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    let all: Vec<u8> = a.chunks_exact(4).zip(b.chunks_exact(4)).map(greatest).collect();
    let share = all.iter().filter(|found| **found <= within).count() as f64 / all.len() as f64;
    (share, all.into_iter().max().unwrap())
}

fn brightness(picture: &[u8]) -> f64 {
    picture.chunks_exact(4).map(|p| f64::from(p[0]) + f64::from(p[1]) + f64::from(p[2])).sum::<f64>()
        / (picture.len() / 4) as f64
        / 3.0
}

#[test]
fn a_screen_shows_the_picture_of_its_camera() {
    let (scene, own) = with_screen(None);
    let mut renderer = renderer();
    for path in [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud] {
        for sample_count in [1, 4] {
            let request = FrameRequest { sample_count, ..own.with(|settings| settings.render.path = path) };
            let truth = drawn(&mut renderer, &scene, &request);
            let shown = drawn(&mut renderer, &scene, &looking(&request, before(SCREEN)));
            // Of several samples the screen's own pixels are jittered, too: edges are a little softer.
            let (least, within) = if sample_count == 1 { (1.0, 1) } else { (0.8, 6) };
            let (share, greatest) = alike(&truth, &shown, within);
            assert!(share >= least, "{path:?}, {sample_count} samples: {share} within {within}, up to {greatest}");
            assert!(brightness(&truth) > 20.0);
            assert_eq!((renderer.stats().captures, renderer.stats().captures_left_out), (1, 0));
        }
    }
}

#[test]
fn what_nobody_sees_costs_nothing() {
    let (scene, own) = with_screen(None);
    // The same with a screen that glows by itself.
    let mut without = scene.clone();
    without.materials.last_mut().unwrap().emissive_texture = None;
    without.images.clear();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    // The scene's own camera looks away from the screen.
    let plan = renderer.plan(&scene, &own).unwrap();
    let seen = drawn(&mut renderer, &scene, &own);
    let stats = renderer.stats();
    assert_eq!((stats.captures, stats.captures_left_out), (0, 1));
    let mut other = common::renderer();
    other.load(&without).unwrap();
    let names = |plan: &manypass::Plan| plan.passes.iter().map(|pass| pass.name.to_string()).collect::<Vec<_>>();
    assert_eq!(names(&plan), names(&other.plan(&without, &own).unwrap()));
    assert!(alike(&seen, &drawn(&mut other, &without, &own), 1).0 > 0.999);
    let shows = looking(&own, before(SCREEN));
    let passes = names(&renderer.plan(&scene, &shows).unwrap());
    assert!(passes.iter().any(|name| name == "monitor/screen/geometry"), "{passes:?}");
    let off = shows.with(|settings| settings.captures.enabled = false);
    let plan = names(&renderer.plan(&scene, &off).unwrap());
    assert!(plan.iter().all(|name| !name.starts_with("monitor/")), "{plan:?}");
}

/// A hall of screens: the camera of each sees the next, the last one sees the first.
fn loop_of(count: usize) -> (Scene, FrameRequest) {
    let (mut scene, own) = with_screen(None);
    scene.images.pop();
    scene.textures.pop();
    scene.nodes.last_mut().unwrap().is_visible = false;
    let place = |at: usize| SCREEN + Vec3::X * 200.0 * (at % count) as f32;
    for at in 0..count {
        let View { world_from_view, projection } = before(place(at + 1));
        let camera = MonitorCamera::Fixed { world_from_view, projection };
        scene.images.push(Image::of_monitor(format!("screen {at}"), Monitor::new(camera, SIZE.0, SIZE.1)));
        put_screen(&mut scene, place(at));
    }
    // Each dims what it shows, and adds a mark of its own: brighter by a step for each that is behind it.
    for material in scene.materials.iter_mut().rev().take(count) {
        material.emissive_factor = Vec3::splat(0.5);
    }
    (scene, own)
}

#[test]
fn loops_of_screens_end_at_the_stated_depth() {
    for count in [1, 3] {
        let (scene, own) = loop_of(count);
        let white = own.with(|settings| settings.background.source = Background::Color([1.0; 3]));
        // Above the screens' upper edge each camera sees a strip of the white background.
        let lift = |camera: View| View {
            world_from_view: Mat4::from_translation(Vec3::Y * 6.0) * camera.world_from_view,
            ..camera
        };
        let mut scene = scene;
        for image in &mut scene.images {
            if let Some(monitor) = image.monitor().cloned()
                && let MonitorCamera::Fixed { world_from_view, projection } = monitor.camera
            {
                let View { world_from_view, projection } = lift(View { world_from_view, projection });
                let camera = MonitorCamera::Fixed { world_from_view, projection };
                *image = Image::of_monitor(image.name.clone(), Monitor { camera, ..monitor });
            }
        }
        let mut renderer = renderer();
        for depth in 1..=4 {
            let request = looking(&white, lift(before(SCREEN))).with(|settings| settings.captures.depth = depth);
            let first = drawn(&mut renderer, &scene, &request);
            // Down the middle of the picture: the strips are 1, 1/2, 1/4, … bright, and then it is dark.
            let column: Vec<u8> = (0..SIZE.1).map(|y| first[((y * SIZE.0 + SIZE.0 / 2) * 4) as usize]).collect();
            let mut levels = column.clone();
            levels.dedup();
            // One more where two brightnesses meet in a byte's step.
            levels.dedup_by(|a, b| a.abs_diff(*b) < 3);
            let bright = levels.iter().filter(|level| **level > 40).count();
            assert_eq!(bright as u32, depth + 1, "{count} screens, depth {depth}: {levels:?}");
            assert!(column.last().is_some_and(|last| *last == 0), "{levels:?}");
            assert_eq!(drawn(&mut renderer, &scene, &request), first, "the same again is another picture");
            assert_eq!(renderer.stats().captures, depth, "{count} screens");
        }
        // A live view shows the same in every frame.
        let still = drawn(&mut renderer, &scene, &looking(&white, lift(before(SCREEN))));
        let live = FrameRequest { goes_on: true, ..looking(&white, lift(before(SCREEN))) };
        for _ in 0..3 {
            assert!(drawn(&mut renderer, &scene, &live) == still, "{count} screens");
        }
    }
}

#[test]
fn live_views_draw_monitors_when_they_are_to_be() {
    let (mut scene, own) = with_screen(None);
    let mut monitor = scene.images.last().unwrap().monitor().unwrap().clone();
    let live = FrameRequest { goes_on: true, ..looking(&own, before(SCREEN)) };
    let updates = [
        (Update::Always, [1, 1, 1, 1, 1, 1]),
        (Update::Every(3), [1, 0, 0, 1, 0, 0]),
        (Update::Once, [1, 0, 0, 0, 0, 0]),
    ];
    for (update, expected) in updates {
        monitor.options.update = update;
        *scene.images.last_mut().unwrap() = Image::of_monitor("screen", monitor.clone());
        let mut renderer = renderer();
        let mut first = None;
        for (frame, count) in expected.into_iter().enumerate() {
            // A plan of the frame takes nobody's turn.
            renderer.plan(&scene, &live).unwrap();
            let picture = drawn(&mut renderer, &scene, &live);
            assert_eq!(renderer.stats().captures, count, "{update:?}, frame {frame}");
            assert_eq!(*first.get_or_insert_with(|| picture.clone()), picture, "{update:?}, frame {frame}");
        }
        // Stills depend on nothing before.
        drawn(&mut renderer, &scene, &FrameRequest { goes_on: false, ..live.clone() });
        assert_eq!(renderer.stats().captures, 1);
    }
    // Three side by side, one a frame.
    monitor.options.update = Update::Always;
    for at in 1..3 {
        scene.images.push(Image::of_monitor(format!("screen {at}"), monitor.clone()));
        put_screen(&mut scene, SCREEN + Vec3::X * 70.0 * at as f32);
    }
    let wide =
        View { projection: Projection::Orthographic { height_m: 200.0, near_m: 1.0, far_m: 20.0 }, ..before(SCREEN) };
    let live = FrameRequest { goes_on: true, ..looking(&own, wide) }.with(|settings| settings.captures.per_frame = 1);
    let mut renderer = renderer();
    let mut brighter = Vec::new();
    for _ in 0..4 {
        brighter.push(brightness(&drawn(&mut renderer, &scene, &live)));
        assert_eq!((renderer.stats().captures, renderer.stats().captures_left_out), (1, 2));
    }
    assert!(brighter[0] < brighter[1] && brighter[1] < brighter[2] && brighter[2] == brighter[3], "{brighter:?}");
}

#[test]
fn layers_say_who_is_seen() {
    let (mut scene, own) = with_screen(None);
    let spheres: Vec<usize> = (0..scene.nodes.len() - 1).filter(|at| scene.nodes[*at].mesh.is_some()).collect();
    // Every second thing is in a layer of its own.
    for at in spheres.iter().step_by(2) {
        scene.nodes[*at].layers = 1 << 3;
    }
    let mut monitor = scene.images.last().unwrap().monitor().unwrap().clone();
    monitor.options = CaptureOptions { layers: 1, ..CaptureOptions::default() };
    *scene.images.last_mut().unwrap() = Image::of_monitor("screen", monitor);
    let mut renderer = renderer();
    let whole = drawn(&mut renderer, &scene, &own);
    let shown = drawn(&mut renderer, &scene, &looking(&own, before(SCREEN)));
    let mut hidden = scene.clone();
    for at in spheres.iter().step_by(2) {
        hidden.nodes[*at].is_visible = false;
    }
    let truth = drawn(&mut renderer, &hidden, &own);
    let (share, greatest) = alike(&truth, &shown, 1);
    assert!(share == 1.0, "{share}, up to {greatest}");
    assert!(alike(&whole, &shown, 1).0 < 0.95, "nothing was hidden");
    let of_view = drawn(&mut renderer, &scene, &FrameRequest { layers: 1, ..own.clone() });
    assert!(alike(&truth, &of_view, 1).0 == 1.0);
}

#[test]
fn an_overlay_shows_a_monitor() {
    let (scene, own) = with_screen(None);
    let mut renderer = renderer();
    let truth = drawn(&mut renderer, &scene, &own);
    for background in [Background::Color([0.0; 3]), Background::Transparent] {
        let mut request = FrameRequest { width: 160, height: 100, ..own.clone() };
        request.settings.background.source = background;
        let below = drawn(&mut renderer, &scene, &request);
        assert_eq!(renderer.stats().captures, 0);
        let before = OverlayItem::text("before", OverlayPlace::at_px(Vec2::new(20.0, 10.0)));
        let over = OverlayItem::text("over", OverlayPlace::at_px(Vec2::new(100.0, 10.0)));
        let inset = OverlayItem::monitor("screen", OverlayPlace::at_px(Vec2::new(90.0, 45.0)));
        let items = vec![before, inset, over];
        request.overlay = manypass_scene::Overlay { items }.into();
        let picture = drawn(&mut renderer, &scene, &request);
        assert_eq!(renderer.stats().captures, 1);
        let row = |picture: &[u8], width: u32, x: u32, y: u32| {
            let first = ((y * width + x) * 4) as usize;
            picture[first..first + SIZE.0 as usize * 4].to_vec()
        };
        for y in 0..SIZE.1 {
            let (found, expected) = (row(&picture, 160, 90, 45 + y), row(&truth, SIZE.0, 0, y));
            let (share, greatest) = alike(&found, &expected, 1);
            assert!(share == 1.0, "{background:?}, row {y}: {share}, up to {greatest}");
        }
        assert_eq!(row(&picture, 160, 0, 95), row(&below, 160, 0, 95), "what is beside it changed");
        assert_ne!(row(&picture, 160, 90, 22), row(&below, 160, 90, 22), "the text over it is missing");
    }
    let missing = OverlayItem::monitor("nothing", OverlayPlace::at_px(Vec2::ZERO));
    let request = FrameRequest { overlay: manypass_scene::Overlay { items: vec![missing] }.into(), ..own };
    let error = renderer.render(&scene, &request).unwrap_err().to_string();
    assert_eq!(error, "item 0 of the overlay: the scene has no monitor called `nothing`");
}

#[test]
fn what_is_wrong_with_monitors_is_said_and_leaves_them_dark() {
    let none = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.01, far_m: None };
    let odd = [Mat4::from_translation(Vec3::splat(f32::NAN)), Mat4::ZERO, Mat4::from_scale(Vec3::splat(f32::INFINITY))];
    let mut renderer = renderer();
    for world_from_view in odd {
        let (scene, own) = with_screen(Some(MonitorCamera::Fixed { world_from_view, projection: none }));
        let shown = drawn(&mut renderer, &scene, &looking(&own, before(SCREEN)));
        assert_eq!(brightness(&shown), 0.0, "{world_from_view}");
    }
    let (mut scene, own) = with_screen(Some(MonitorCamera::Node(NodeId(90_000))));
    assert_eq!(brightness(&drawn(&mut renderer, &scene, &looking(&own, before(SCREEN)))), 0.0);
    for size in [(0, 0), (0, 7), (5000, 5000), (u32::MAX, 1)] {
        let monitor = scene.images.last().unwrap().monitor().unwrap().clone();
        let monitor = Monitor { width: size.0, height: size.1, ..monitor };
        *scene.images.last_mut().unwrap() = Image::of_monitor("screen", monitor);
        let shown = drawn(&mut renderer, &scene, &looking(&own, before(SCREEN)));
        let inset = OverlayItem::monitor("screen", OverlayPlace::at_px(Vec2::ZERO));
        let mut over = own.clone();
        over.settings.background.source = Background::Transparent;
        over.overlay = manypass_scene::Overlay { items: vec![inset] }.into();
        drawn(&mut renderer, &scene, &over);
        // A texture that is not there makes its factor dark.
        assert_eq!(brightness(&shown), 0.0, "{size:?}");
        let warnings = renderer.warnings();
        assert!(warnings.iter().any(|warning| warning.contains("monitor `screen` is dark")), "{warnings:?}");
    }
    let (mut scene, own) = with_screen(None);
    let mut monitor = scene.images.last().unwrap().monitor().unwrap().clone();
    monitor.options.quality = Some("best".into());
    *scene.images.last_mut().unwrap() = Image::of_monitor("screen", monitor.clone());
    let error = renderer.render(&scene, &looking(&own, before(SCREEN))).unwrap_err();
    assert!(matches!(&error, RenderError::CaptureQuality { quality } if quality == "best"), "{error}");
    monitor.options.quality = Some("low".into());
    *scene.images.last_mut().unwrap() = Image::of_monitor("screen", monitor.clone());
    assert!(brightness(&drawn(&mut renderer, &scene, &looking(&own, before(SCREEN)))) > 20.0);
    // More than there may be.
    monitor.options.quality = None;
    for at in 0..70 {
        scene
            .images
            .push(Image::of_monitor(format!("screen {at}"), Monitor { width: 8, height: 8, ..monitor.clone() }));
        put_screen(&mut scene, SCREEN + Vec3::X * 70.0 * (at + 1) as f32);
    }
    let wide =
        View { projection: Projection::Orthographic { height_m: 9e3, near_m: 1.0, far_m: 20.0 }, ..before(SCREEN) };
    drawn(&mut renderer, &scene, &looking(&own, wide));
    assert_eq!(renderer.stats().captures, 64);
    assert!(renderer.warnings().iter().any(|warning| warning.contains("only the first 64 of 71 monitors")));
}
