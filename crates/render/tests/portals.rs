//! Portals: one to a copy of its own place is not to be seen, what goes through is at both ends, and how deep they are.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Mat4, Quat, Vec3};
use manypass::{FrameRequest, Path, Renderer};
use manypass_scene::framing::look_along;
use manypass_scene::portal::Portal;
use manypass_scene::primitives::{plane, uv_sphere};
use manypass_scene::{Mesh, Node, NodeId, Primitive, Projection, Scene};
use manypass_testkit::scenes;
use std::f32::consts::FRAC_PI_2;

const SIZE: (u32, u32) = (96, 72);
/// How far away the copy of the place is.
const AWAY: Vec3 = Vec3::new(100.0, 0.0, 0.0);

/// Adds a square of a size that faces along a direction.
fn add_square(scene: &mut Scene, (center, facing, size_m): (Vec3, Vec3, f32)) -> NodeId {
    let square = Primitive { material: Some(0), ..plane(1.0) };
    scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
    let node = Node {
        mesh: Some(scene.meshes.len() - 1),
        translation: center,
        rotation: look_along(-facing, Vec3::Y).unwrap() * Quat::from_rotation_x(FRAC_PI_2),
        scale: Vec3::splat(size_m),
        ..Node::default()
    };
    let id = scene.add_node(None, node);
    scene.update_transforms();
    id
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    for sample_index in 0..request.sample_count {
        renderer.render(scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
    }
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}

/// Balls on a floor, and the same again far away.
fn twice() -> (Scene, FrameRequest) {
    let mut scene = scenes::rows_of_spheres().scene;
    for light in &mut scene.lights {
        light.range_m = Some(30.0);
    }
    let request = plain_request(&scene, SIZE);
    for id in scene.visible_nodes() {
        let node = scene.node(id).clone();
        if node.camera.is_none() {
            scene.add_node(None, Node { translation: node.translation + AWAY, ..node });
        }
    }
    scene.update_transforms();
    (scene, request)
}

/// Pixels that differ by more than 1/255 of the brightest of them, or of white.
fn differing(a: &[[f32; 3]], b: &[[f32; 3]]) -> usize {
    let differs = |(a, b): &(&[f32; 3], &[f32; 3])| {
        let most = a.iter().chain(*b).fold(1.0f32, |most, value| most.max(*value));
        a.iter().zip(*b).any(|(a, b)| (a - b).abs() > most / 255.0)
    };
    a.iter().zip(b).filter(differs).count()
}

/// A portal into the copy, before the balls on the right.
fn add_door(scene: &mut Scene, carried: &[NodeId]) {
    let (center, facing) = (Vec3::new(1.2, 1.25, 0.3), Vec3::new(0.3, 0.1, 1.0));
    // It comes out on the back of the same square there, so that nothing but the place is another one.
    let ends = [add_square(scene, (center, facing, 1.9)), add_square(scene, (center + AWAY, -facing, 1.9))];
    scene.add_portal(Portal::new("door", ends), carried);
}

#[test]
fn a_portal_to_a_copy_of_its_own_place_is_invisible() {
    let (scene, request) = twice();
    let mut with_door = scene.clone();
    add_door(&mut with_door, &[]);
    let mut renderer = renderer();
    for path in [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud] {
        for (sample_count, f_stop, scale) in [(1, 0.0, 1.0), (4, 0.25, 1.0), (1, 0.0, 2.0)] {
            let request = FrameRequest {
                sample_count,
                ..request.with(|settings| {
                    settings.render.path = path;
                    settings.camera.f_stop = f_stop;
                    settings.camera.focus_m = 7.0;
                })
            };
            with_door.portals[0].scale = scale;
            let expected = radiance(&mut renderer, &scene, &request);
            let shown = radiance(&mut renderer, &with_door, &request);
            // Through a lens, what is out of the picture may be seen.
            if f_stop == 0.0 {
                assert_eq!((renderer.stats().captures, renderer.stats().captures_left_out), (1, 1));
            }
            let count = differing(&shown, &expected);
            let most = if scale == 1.0 { expected.len() / 100 } else { expected.len() / 20 };
            assert!(count <= most, "{path:?}, {sample_count} samples, scale {scale}: {count} pixels differ");
        }
    }
    // It does lead away: what is moved there is seen to be.
    let copy = with_door.visible_nodes().into_iter().filter(|id| with_door.node(*id).translation.x > 90.0);
    for id in copy.collect::<Vec<_>>() {
        with_door.node_mut(id).translation.y += if with_door.node(id).mesh == Some(0) { 0.7 } else { 0.0 };
    }
    with_door.update_transforms();
    let (moved, expected) = (radiance(&mut renderer, &with_door, &request), radiance(&mut renderer, &scene, &request));
    assert!(differing(&moved, &expected) > 100);
}

#[test]
fn what_is_half_through_is_seen_whole() {
    let (mut scene, request) = twice();
    // More of it is behind the door than before it.
    let mut ball = uv_sphere(0.35, 64, 32);
    ball.material = Some(0);
    scene.meshes.push(Mesh { primitives: vec![ball], ..Mesh::default() }.into());
    let mesh = Some(scene.meshes.len() - 1);
    let translation = Vec3::new(1.2, 1.25, 0.3) - 0.25 * Vec3::new(0.3, 0.1, 1.0).normalize();
    let id = scene.add_node(None, Node { mesh, translation, ..Node::default() });
    scene.update_transforms();
    let mut renderer = renderer();
    let expected = radiance(&mut renderer, &scene, &request);
    let (mut carrying, mut without) = (scene.clone(), scene);
    add_door(&mut carrying, &[id]);
    add_door(&mut without, &[]);
    let shown = radiance(&mut renderer, &carrying, &request);
    let count = differing(&shown, &expected);
    assert!(count <= expected.len() / 100, "{count} pixels differ");
    // Without its other half the ball is cut in two.
    let cut = radiance(&mut renderer, &without, &request);
    assert!(differing(&cut, &expected) > 30, "{}", differing(&cut, &expected));
}

#[test]
fn portals_in_portals_end_at_the_stated_depth() {
    // Two that face each other, seen from between them: each leads to the other.
    let (mut scene, request) = twice();
    let ends = [
        add_square(&mut scene, (Vec3::new(0.0, 1.0, -2.0), Vec3::Z, 2.0)),
        add_square(&mut scene, (Vec3::new(0.0, 1.0, 9.0), Vec3::NEG_Z, 2.0)),
    ];
    scene.add_portal(Portal::new("corridor", ends), &[]);
    let mut renderer = renderer();
    let mut last = Vec::new();
    for depth in 1..=4 {
        let request = request.with(|settings| settings.captures.depth = depth);
        let picture = radiance(&mut renderer, &scene, &request);
        assert_eq!(renderer.stats().captures, depth, "at depth {depth}");
        assert!(picture != last, "depth {depth} shows what the one before did");
        last = picture;
    }
    let plan = renderer.plan(&scene, &request).unwrap();
    let names: Vec<String> = plan.passes.iter().map(|pass| pass.name.to_string()).collect();
    assert!(names.iter().any(|name| name.contains("portal/corridor/portal/corridor")), "{names:?}");
    // Three that lead into each other in a ring.
    let corner = |at: f32| Vec3::new(4.0 * at.sin(), 1.0, 4.0 * at.cos() + 3.0);
    for turn in [0.0f32, 2.1, 4.2] {
        let pair = [turn, turn + 2.1]
            .map(|turn| add_square(&mut scene, (corner(turn), Vec3::new(0.0, 1.0, 3.0) - corner(turn), 1.0)));
        scene.add_portal(Portal::new("ring", pair), &[]);
    }
    let picture = radiance(&mut renderer, &scene, &request.with(|settings| settings.captures.depth = 4));
    assert!(picture.iter().flatten().all(|value| value.is_finite()));
    assert!(renderer.stats().captures <= 64);
}

#[test]
fn odd_portals_lead_nowhere() {
    let (scene, request) = twice();
    let mut renderer = renderer();
    let before = radiance(&mut renderer, &scene, &request);
    let ball = scene.visible_nodes().into_iter().find(|id| scene.node(*id).mesh.is_some()).unwrap();
    let mut odd = scene.clone();
    let square = add_square(&mut odd, (Vec3::new(0.0, 1.0, -3.0), Vec3::Z, 0.2));
    let portals = [[square, ball], [square, NodeId(1_000_000)], [ball, ball], [square, square]];
    for nodes in portals {
        odd.portals.push(Portal::new("odd", nodes));
    }
    renderer.load(&odd).unwrap();
    let warnings = renderer.warnings();
    for what in ["is not flat", "is not there", "is both of them"] {
        let is_said = |warning: &String| warning.contains("portal `odd` leads nowhere") && warning.ends_with(what);
        assert!(warnings.iter().any(is_said), "{what}: {warnings:?}");
    }
    radiance(&mut renderer, &odd, &request);
    assert_eq!(renderer.stats().captures, 0);
    let mut with_door = scene.clone();
    add_door(&mut with_door, &[ball]);
    let [node, _] = with_door.portals[0].nodes;
    let kept = with_door.node(node).scale;
    for scale in [Vec3::ZERO, Vec3::splat(f32::NAN), Vec3::splat(1e30), kept] {
        with_door.node_mut(node).scale = scale;
        with_door.update_transforms();
        let picture = radiance(&mut renderer, &with_door, &request);
        assert!(picture.iter().flatten().all(|value| value.is_finite()), "{scale}");
    }
    for scale in [0.5, f32::NAN, -1.0, f32::INFINITY] {
        with_door.portals[0].scale = scale;
        let picture = radiance(&mut renderer, &with_door, &request);
        assert!(picture.iter().flatten().all(|value| value.is_finite()), "{scale}");
    }
    // With the eye in its plane, and right before it.
    let panel = with_door.panel(node).unwrap();
    for away_m in [0.0, 1e-5, 0.01] {
        let eye = panel.center_world + panel.normal_world * away_m;
        let rotation = look_along(-panel.normal_world, Vec3::Y).unwrap();
        let mut request = request.clone();
        request.camera.world_from_view = Mat4::from_rotation_translation(rotation, eye);
        request.camera.projection = Projection::Perspective { fov_y_rad: 1.2, near_m: 0.02, far_m: None };
        let picture = radiance(&mut renderer, &with_door, &request);
        assert!(picture.iter().flatten().all(|value| value.is_finite()), "{away_m} m before it");
    }
    let off = request.with(|settings| settings.captures.enabled = false);
    assert!(differing(&radiance(&mut renderer, &with_door, &off), &before) < before.len() / 100);
}
