//! What a frame that is like the last one does does not grow with what the scene shows. It is counted, not timed, on a
//! device that draws nothing.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use glam::{Mat4, Quat, Vec3};
use manypass::{Background, Environment, FrameRequest, FrameStats, Gpu, Path, Renderer, View};
use manypass_scene::{Light, LightKind, Mesh, Node, NodeId, Projection, Scene, primitives};

/// Nodes below one, which show the same cube on the same ground, and a sun.
fn crowd(count: usize) -> Scene {
    let mut scene = Scene::default();
    scene.meshes.push(Mesh { primitives: vec![primitives::cube(Vec3::splat(0.1))], ..Mesh::default() }.into());
    let parent = scene.add_node(None, Node::default());
    let side = count.isqrt();
    for index in 0..count {
        let at = |cell: usize| 10.0 * (cell as f32 / side as f32 - 0.5);
        let translation = Vec3::new(at(index % side), 0.0, at(index / side));
        scene.add_node(Some(parent), Node { mesh: Some(0), translation, ..Node::default() });
    }
    scene.lights.push(Light {
        name: "sun".into(),
        intensity: 3.0,
        range_m: None,
        kind: LightKind::Directional,
        ..Light::default()
    });
    let rotation = Quat::from_rotation_x(-1.0);
    scene.add_node(None, Node { light: Some(0), rotation, ..Node::default() });
    scene.update_transforms();
    scene
}

fn live(is_temporal: bool) -> FrameRequest {
    let world_from_view = Mat4::from_translation(Vec3::new(0.0, 10.0, 10.0)) * Mat4::from_rotation_x(-0.8);
    let projection = Projection::Perspective { fov_y_rad: 1.2, near_m: 0.1, far_m: None };
    let mut request = FrameRequest::new(64, 48, View { world_from_view, projection });
    request.goes_on = true;
    request.settings.environment.source = Environment::None;
    request.settings.background.source = Background::Color([0.0; 3]);
    request.settings.taa.enabled = is_temporal;
    request
}

fn render(renderer: &mut Renderer, scene: &mut Scene, request: &FrameRequest) -> FrameStats {
    scene.update_transforms();
    renderer.render(scene, request).unwrap();
    renderer.stats()
}

/// What the eighth of some frames that are alike did, of a scene of so many nodes.
fn eighth(count: usize, is_temporal: bool) -> FrameStats {
    let mut scene = crowd(count);
    let mut renderer = Renderer::new(Gpu::without_adapter(Default::default()).unwrap()).unwrap();
    renderer.load(&scene).unwrap();
    let request = live(is_temporal);
    let first = render(&mut renderer, &mut scene, &request);
    assert_eq!((first.items_posed, first.draw_lists_made), (count as u32, 1), "{count}");
    (0..6).for_each(|_| drop(render(&mut renderer, &mut scene, &request)));
    render(&mut renderer, &mut scene, &request)
}

#[test]
fn a_still_frame_of_many_instances_does_what_one_of_few_does() {
    for is_temporal in [false, true] {
        let [few, many] = [100, 40_000].map(|count| eighth(count, is_temporal));
        for stats in [&few, &many] {
            let made = (stats.items_posed, stats.draw_lists_made, stats.light_lists_made, stats.shadow_tiles_drawn);
            assert_eq!(made, (0, 0, 0, 0), "{is_temporal}");
            assert!(stats.shadow_tiles_kept > 0, "{is_temporal}");
        }
        // Uniforms follow the places of samples.
        assert!(many.uploaded_bytes <= if is_temporal { 8192 } else { 0 }, "{is_temporal}: {}", many.uploaded_bytes);
        assert_eq!((few.draws, few.triangles), (1, 12 * 100), "{is_temporal}");
        assert_eq!((many.draws, many.triangles), (1, 12 * 40_000), "{is_temporal}");
    }
}

#[test]
fn what_changed_is_posed_anew() {
    let mut scene = crowd(1000);
    let mut renderer = Renderer::new(Gpu::without_adapter(Default::default()).unwrap()).unwrap();
    renderer.load(&scene).unwrap();
    let request = live(false);
    let mut done = |scene: &mut Scene, request: &FrameRequest| {
        let stats = render(&mut renderer, scene, request);
        (stats.items_posed, stats.draw_lists_made)
    };
    assert_eq!(done(&mut scene, &request), (1000, 1));
    assert_eq!(done(&mut scene, &request), (0, 0));
    // Another camera, another list; settings of light alone change none.
    let mut moved = request.clone();
    moved.camera.world_from_view.w_axis.x += 0.5;
    assert_eq!(done(&mut scene, &moved), (0, 1));
    assert_eq!(
        done(&mut scene, &moved.with(|settings| settings.exposure.stops = manypass::Exposure::Stops(1.0))),
        (0, 0)
    );
    assert_eq!(done(&mut scene, &moved.with(|settings| settings.render.path = Path::Forward)), (0, 0));
    // A node that moves, one that goes, one that comes.
    scene.node_mut(NodeId(5)).translation.y += 1.0;
    assert_eq!(done(&mut scene, &moved), (1000, 1));
    scene.remove_node(NodeId(5));
    assert_eq!(done(&mut scene, &moved), (999, 1));
    scene.roots.push(NodeId(5));
    assert_eq!(done(&mut scene, &moved), (1000, 1));
    assert_eq!(done(&mut scene, &moved), (0, 0));
    // So are other materials, and a clone that was not changed is the same scene.
    scene.materials.push(Default::default());
    assert_eq!(done(&mut scene, &moved).0, 1000);
    assert_eq!(done(&mut scene.clone(), &moved), (0, 0));
}
