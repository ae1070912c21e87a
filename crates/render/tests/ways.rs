//! Every way of lighting against brute force, which visits every light for every pixel and is itself held against the
//! ray caster in `pictures.rs`.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Mat4, Quat, Vec3};
use manypass::{FogMode, FrameRequest, LightCulling, PairCounts, Path, Renderer};
use manypass_scene::{AlphaMode, LightKind, Projection, Scene};
use manypass_testkit::compare::{Picture, Tolerance, assert_rejects_mutations, assert_same, difference};
use manypass_testkit::scenes;

/// A scene with a request that shows it.
struct Case {
    name: &'static str,
    scene: Scene,
    request: FrameRequest,
}

fn case(name: &'static str, scene: Scene, size: (u32, u32)) -> Case {
    let request = plain_request(&scene, size);
    Case { name, scene, request }
}

/// The scene's lights as cones of many angles that look in all directions.
fn with_spots(mut scene: Scene) -> Scene {
    for (light, i) in scene.lights.iter_mut().zip(0u16..) {
        let outer_cone_rad = [0.1, 0.4, 0.8, 1.1, 1.4][usize::from(i % 5)];
        light.kind = LightKind::Spot { inner_cone_rad: 0.6 * outer_cone_rad, outer_cone_rad };
        light.range_m = Some(1.0 + f32::from(i % 4));
    }
    let nodes = scene.nodes.iter_mut().filter(|node| node.light.is_some());
    for (node, i) in nodes.zip(0u16..) {
        let turn = Quat::from_rotation_y(2.4 * f32::from(i));
        let direction = turn * Vec3::new(0.8, if i % 3 == 0 { 0.3 } else { -0.9 }, 0.0).normalize();
        node.rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction);
        node.translation.y += 0.4 * f32::from(i % 4);
    }
    scene.update_transforms();
    scene
}

/// The scene's lights as points and cones with ranges, of which every third casts a shadow, a sun and a lamp without a
/// range.
fn with_every_class(mut scene: Scene) -> Scene {
    let points: Vec<_> = scene.lights.clone();
    scene = with_spots(scene);
    for ((light, point), i) in scene.lights.iter_mut().zip(points).zip(0u16..) {
        match i {
            0 => (light.kind, light.intensity, light.range_m) = (point.kind, 3.0, None),
            1 => (light.kind, light.intensity, light.range_m) = (LightKind::Directional, 0.5, None),
            i if i % 2 == 0 => (light.kind, light.range_m) = (point.kind, Some(2.0)),
            _ => (),
        }
        light.casts_shadows = i % 3 == 0 || i == 1;
    }
    scene
}

const CULLING: [LightCulling; 4] =
    [LightCulling::Clustered, LightCulling::Tiled, LightCulling::Volumes, LightCulling::VolumesStencil];

fn cases() -> Vec<Case> {
    let field = scenes::many_points(250).scene;
    let mut inside = case("inside of lights", field.clone(), (96, 64));
    inside.request.camera.world_from_view =
        Mat4::from_scale_rotation_translation(Vec3::ONE, Quat::from_rotation_x(-0.25), Vec3::new(0.4, 0.6, 3.0));
    let mut parallel = case("parallel rays", with_spots(field.clone()), (90, 70));
    // Volumes reach beyond both planes.
    parallel.request.camera.projection = Projection::Orthographic { height_m: 7.0, near_m: 4.0, far_m: 12.0 };
    let mut mirrored = case("mirrored", with_spots(field.clone()), (64, 64));
    mirrored.request.camera.world_from_view *= Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let mut cut = case("cut by a plane", field.clone(), (64, 48));
    cut.request.clip_plane_world = Some(glam::Vec4::new(0.2, 0.1, -1.0, 2.0));
    let mut shadowed = case("spots with shadows in fog", scenes::spot_lights().scene, (80, 60));
    shadowed.request.settings.shadows.enabled = true;
    shadowed.request.settings.fog.mode = FogMode::Exponential;
    let mut classes = case("every class of lights with shadows", with_every_class(field.clone()), (80, 60));
    classes.request.settings.shadows.enabled = true;
    vec![
        shadowed,
        classes,
        case("a field of points", field.clone(), (97, 61)),
        case("a field of spots", with_spots(field), (65, 79)),
        case("without range", scenes::rows_of_spheres().scene, (80, 60)),
        case("a sun", scenes::sun().scene, (80, 60)),
        inside,
        parallel,
        mirrored,
        cut,
    ]
}

fn display(renderer: &mut Renderer, case: &Case, culling: LightCulling) -> Picture {
    let request = case.request.with(|settings| settings.lights.culling = culling);
    renderer.render(&case.scene, &request).unwrap();
    Picture::from_rgba8(request.width as usize, request.height as usize, &renderer.read_display().unwrap())
}

fn pairs(renderer: &mut Renderer, case: &Case, culling: LightCulling) -> PairCounts {
    let request = case.request.with(|settings| settings.lights.culling = culling);
    renderer.count_pairs(&case.scene, &request).unwrap()
}

#[test]
fn every_way_of_culling_is_brute_force() {
    let mut renderer = renderer();
    for case in cases() {
        renderer.load(&case.scene).unwrap();
        let truth = display(&mut renderer, &case, LightCulling::None);
        let all = pairs(&mut renderer, &case, LightCulling::None);
        assert!(all.pairs_shaded > 2000, "{}: hardly anything is lit: {all:?}", case.name);
        for culling in CULLING {
            println!("{}, {}", case.name, culling.name());
            assert_same(&truth, &display(&mut renderer, &case, culling), Tolerance::default());
            let counted = pairs(&mut renderer, &case, culling);
            println!("  {counted:?} of {all:?}");
            // What reaches a pixel and faces it is shaded, by every way once.
            assert_eq!(
                (counted.pairs_shaded, counted.pairs_in_range),
                (all.pairs_shaded, all.pairs_in_range),
                "{}, {}",
                case.name,
                culling.name()
            );
            assert!((counted.pairs_in_range..=all.pairs_visited).contains(&counted.pairs_visited));
            let has_bounds = culling == LightCulling::Tiled && counted.pairs_visited > 60_000;
            assert_eq!(
                counted.pairs_passed_over > counted.pairs_visited / 20,
                has_bounds,
                "{}: {counted:?}",
                case.name
            );
        }
    }
}

/// Of the lights of every class some cast shadows, which a way that takes one class for another would leave out.
#[test]
fn shadows_of_every_class_are_seen() {
    let mut renderer = renderer();
    let mut case = cases().into_iter().find(|case| case.name.starts_with("every class")).unwrap();
    renderer.load(&case.scene).unwrap();
    let truth = display(&mut renderer, &case, LightCulling::None);
    let is_of: [fn(LightKind, Option<f32>) -> bool; 4] = [
        |kind, _| kind == LightKind::Directional,
        |kind, range_m| kind == LightKind::Point && range_m.is_none(),
        |kind, range_m| kind == LightKind::Point && range_m.is_some(),
        |kind, _| matches!(kind, LightKind::Spot { .. }),
    ];
    for is_of in is_of {
        let cast = case.scene.clone();
        let lights = case.scene.lights.iter_mut().filter(|light| is_of(light.kind, light.range_m));
        lights.for_each(|light| light.casts_shadows = false);
        let quiet = display(&mut renderer, &case, LightCulling::Volumes);
        assert!(!difference(&truth, &quiet, 2).is_within(Tolerance::default()));
        case.scene = cast;
    }
}

#[test]
fn lights_that_reach_little_are_shaded_only_there() {
    let mut renderer = renderer();
    let mut scene = scenes::many_points(12).scene;
    scene.lights.iter_mut().for_each(|light| light.range_m = light.range_m.map(|range_m| 0.5 * range_m));
    let mut case = case("small lights", scene, (203, 117));
    renderer.load(&case.scene).unwrap();
    for scale in [1.0, 0.7] {
        case.request.settings.render.scale = scale;
        let truth = display(&mut renderer, &case, LightCulling::None);
        let all = renderer.stats().light_draws;
        for (culling, reductions) in [(LightCulling::Clustered, 0), (LightCulling::Tiled, 2)] {
            assert_same(&truth, &display(&mut renderer, &case, culling), Tolerance::default());
            let parts = renderer.stats().light_draws - reductions;
            assert!(all == 1 && parts > 3, "{} at {scale}: {parts} parts of the picture", culling.name());
        }
    }
    // Whatever is in no list reaches every pixel.
    case.scene.lights[0].range_m = None;
    let truth = display(&mut renderer, &case, LightCulling::None);
    assert_same(&truth, &display(&mut renderer, &case, LightCulling::Clustered), Tolerance::default());
    assert_eq!(renderer.stats().light_draws, 1);
    // What reaches nothing that is seen takes no pass.
    case.scene.nodes.iter_mut().filter(|node| node.light.is_some()).for_each(|node| node.translation.y -= 90.0);
    case.scene.lights[0].range_m = Some(1.0);
    case.scene.update_transforms();
    let plan = renderer.plan(&case.scene, &case.request).unwrap();
    assert!(plan.passes.iter().all(|pass| pass.name != "direct"));
    let dark = display(&mut renderer, &case, LightCulling::Clustered);
    assert_same(&display(&mut renderer, &case, LightCulling::None), &dark, Tolerance::default());
}

/// What tiles pass over lies in a texture of 1,024 texels a row, a light each.
#[test]
fn tiles_find_what_lights_reach_beyond_the_first_row() {
    let mut renderer = renderer();
    let case = case("2,100 small lights", scenes::many_points(2100).scene, (48, 32));
    renderer.load(&case.scene).unwrap();
    let truth = display(&mut renderer, &case, LightCulling::None);
    assert_same(&truth, &display(&mut renderer, &case, LightCulling::Tiled), Tolerance::default());
    let [all, tiled] = [LightCulling::None, LightCulling::Tiled].map(|culling| pairs(&mut renderer, &case, culling));
    assert_eq!((tiled.pairs_shaded, tiled.pairs_in_range), (all.pairs_shaded, all.pairs_in_range));
    assert!(tiled.pairs_passed_over > 0, "{tiled:?}");
}

/// What is lit as it is drawn is lit as often as it is drawn.
#[test]
fn forward_ways_count_what_they_draw() {
    let mut renderer = renderer();
    let mut case = case("a field of points", scenes::many_points(250).scene, (96, 64));
    let mut counted = |case: &Case, path, culling| {
        renderer.load(&case.scene).unwrap();
        let request = case.request.with(|settings| settings.render.path = path);
        pairs(&mut renderer, &Case { request, scene: case.scene.clone(), ..*case }, culling)
    };
    let is_about = |a: u64, b: u64| a.abs_diff(b) <= a.max(b) / 500;
    let deferred = counted(&case, Path::Deferred, LightCulling::Clustered);
    let [forward, batched] =
        [Path::Forward, Path::ForwardBatched].map(|path| counted(&case, path, LightCulling::Clustered));
    println!("{deferred:?}\n{forward:?}\n{batched:?}");
    // Spheres hide parts of the floor and of each other, and what is drawn first may be hidden later.
    assert!(forward.pairs_visited >= deferred.pairs_visited && forward.pairs_visited < 2 * deferred.pairs_visited);
    let every = counted(&case, Path::Forward, LightCulling::None);
    assert_eq!((every.pairs_shaded, every.pairs_in_range), (forward.pairs_shaded, forward.pairs_in_range));
    assert_eq!(every.pairs_visited % 250, 0);
    let fragments = every.pairs_visited / 250;
    assert!((96 * 64 / 2..2 * 96 * 64).contains(&fragments), "{fragments} fragments");
    // Lists of objects are longer than those of clusters; batches beyond the first find the pixels that are seen alone.
    assert!(batched.pairs_visited > 2 * forward.pairs_visited, "{batched:?}");
    assert!(batched.pairs_shaded <= forward.pairs_shaded && batched.pairs_shaded >= deferred.pairs_shaded * 998 / 1000);
    // A blended surface over all takes nothing from what lies behind it, and is lit as well, on every path.
    let floor = case.scene.nodes.iter().position(|node| node.mesh.is_some()).unwrap();
    let material = case.scene.meshes[case.scene.nodes[floor].mesh.unwrap()].primitives[0].material.unwrap();
    case.scene.nodes.iter_mut().enumerate().filter(|(i, node)| *i != floor && node.mesh.is_some()).for_each(
        |(_, node)| {
            node.is_visible = false;
        },
    );
    let opaque = counted(&case, Path::Deferred, LightCulling::Clustered);
    case.scene.materials[material].alpha_mode = AlphaMode::Blend;
    for path in [Path::Deferred, Path::Forward, Path::ForwardBatched] {
        let blended = counted(&case, path, LightCulling::Clustered);
        println!("{} {opaque:?} {blended:?}", path.name());
        assert!(
            is_about(blended.pairs_shaded, opaque.pairs_shaded)
                && is_about(blended.pairs_visited, opaque.pairs_visited)
        );
    }
}

/// Shadow maps lie behind the lights, so that the texture grows, while the lists before the lights stay as they are.
#[test]
fn shadows_that_are_turned_on_leave_the_lists_as_they_were() {
    let mut live = renderer();
    let mut case = case("a field of points", scenes::many_points(120).scene, (80, 60));
    live.load(&case.scene).unwrap();
    let without = display(&mut live, &case, LightCulling::Clustered);
    case.request.settings.shadows.enabled = true;
    let with = display(&mut live, &case, LightCulling::Clustered);
    let stats = live.stats();
    assert!(stats.light_lists_made == 0 && stats.shadow_tiles_drawn > 256, "{stats:?}");
    let mut anew = Renderer::new(live.gpu().clone()).unwrap();
    anew.load(&case.scene).unwrap();
    assert!(with == display(&mut anew, &case, LightCulling::Clustered), "the picture depends on the one before it");
    assert!(!difference(&without, &with, 2).is_within(Tolerance::default()));
}

#[test]
fn ways_say_how_many_draws_they_take_and_what_they_write() {
    let mut renderer = renderer();
    let case = case("a field of points", scenes::many_points(60).scene, (64, 48));
    renderer.load(&case.scene).unwrap();
    let pixels = 64 * 48;
    let mut stats = |path, culling| {
        let request = case.request.with(|settings| (settings.render.path, settings.lights.culling) = (path, culling));
        renderer.render(&case.scene, &request).unwrap();
        renderer.stats()
    };
    let [clustered, tiled, volumes, stencil] = CULLING.map(|culling| stats(Path::Deferred, culling));
    let forward = stats(Path::Forward, LightCulling::Clustered);
    let batched = stats(Path::ForwardBatched, LightCulling::Clustered);
    let draws = [&clustered, &tiled, &volumes, &forward].map(|stats| stats.light_draws);
    assert_eq!(draws, [1, 3, 1, 0], "lists, lists and two reductions, one draw of spheres, none");
    assert!(stencil.light_draws > 2 && batched.light_draws > 2, "{stencil:?}, {batched:?}");
    // The G-buffer's 12 bytes and linear depth's 4 are what forward shading spares.
    assert!(clustered.written_bytes > forward.written_bytes + 16 * pixels, "{clustered:?}, {forward:?}");
    // A batch adds to radiance, 8 bytes a pixel.
    assert!(batched.written_bytes > forward.written_bytes + 5 * 8 * pixels, "{batched:?}");
    // Two floats for each tile of 16 pixels in each row, and for each tile.
    assert_eq!(tiled.written_bytes - clustered.written_bytes, 8 * (4 * 48 + 4 * 3));
}

#[test]
fn forward_in_batches_is_forward_by_brute_force() {
    let mut renderer = renderer();
    let mut cases: Vec<Case> = cases().into_iter().filter(|case| !case.name.starts_with("a field")).collect();
    // A masked and a blended surface before the field.
    let mut layered = case("masked and blended", scenes::many_points(60).scene, (80, 60));
    layered.scene.materials[0].alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    layered.scene.materials[1].alpha_mode = AlphaMode::Blend;
    layered.scene.materials[1].base_color_factor.w = 0.5;
    cases.push(layered);
    for case in cases {
        renderer.load(&case.scene).unwrap();
        let forward = case.request.with(|settings| settings.render.path = Path::Forward);
        let case = Case { request: forward, ..case };
        let truth = display(&mut renderer, &case, LightCulling::None);
        let batched = case.request.with(|settings| settings.render.path = Path::ForwardBatched);
        let case = Case { request: batched, ..case };
        println!("{}", case.name);
        assert_same(&truth, &display(&mut renderer, &case, LightCulling::Clustered), Tolerance::default());
        let plan = renderer.plan(&case.scene, &case.request).unwrap();
        let batches = plan.passes.iter().filter(|pass| pass.name.starts_with("forward_batched")).count();
        assert_eq!(batches > 8, case.scene.lights.len() > 64, "{}: {batches}", case.name);
    }
}

#[test]
fn the_comparison_notices_a_light_that_is_missing() {
    let mut renderer = renderer();
    let mut case = case("a field of points", scenes::many_points(400).scene, (97, 61));
    renderer.load(&case.scene).unwrap();
    let truth = display(&mut renderer, &case, LightCulling::None);
    assert_rejects_mutations(&truth, Tolerance::default());
    let lamp = case
        .scene
        .nodes
        .iter()
        .position(|node| node.light.is_some() && node.world_from_object.w_axis.truncate().length() < 2.0);
    case.scene.nodes[lamp.unwrap()].light = None;
    let without = display(&mut renderer, &case, LightCulling::Tiled);
    assert!(!difference(&truth, &without, 2).is_within(Tolerance::default()));
}
