//! The time of a frame outside the adapter: 10,000 nodes with as many meshes, on a device that draws nothing.
//! `cargo bench -p manypass --bench nodes`.

use glam::{Mat4, Quat, Vec3, Vec4};
use manypass::scene::{Light, LightKind, Material, Mesh, Node, Projection, Scene, primitives};
use manypass::{Environment, FrameRequest, Gpu, Renderer, View};
use std::f32::consts::FRAC_PI_4;
use std::time::Instant;

const SIDE: usize = 100;
const MATERIALS: usize = 64;
const FRAMES: usize = 60;

/// Boxes in a square, each a mesh of its own, all seen at once.
fn scene() -> Scene {
    let mut scene = Scene::default();
    let shade = |index: usize, step: usize| ((index * step) % 17) as f32 / 16.0;
    scene.materials = (0..MATERIALS)
        .map(|i| Material {
            base_color_factor: Vec4::new(shade(i, 3), shade(i, 5), shade(i, 7), 1.0),
            ..Default::default()
        })
        .collect();
    for index in 0..SIDE * SIDE {
        let size_m = Vec3::new(0.4, 0.2 + 0.5 * shade(index, 3), 0.4);
        let mut primitive = primitives::cube(size_m);
        primitive.material = Some(index % MATERIALS);
        scene.meshes.push(Mesh { primitives: vec![primitive], ..Default::default() }.into());
        let at = |cell: usize| cell as f32 - 0.5 * SIDE as f32;
        let translation = Vec3::new(at(index % SIDE), 0.0, at(index / SIDE));
        scene.add_node(None, Node { mesh: Some(index), translation, ..Default::default() });
    }
    let sun = Light {
        name: "sun".into(),
        color_linear: Vec3::ONE,
        intensity: 3.0,
        range_m: None,
        kind: LightKind::Directional,
    };
    scene.lights.push(sun);
    scene.add_node(None, Node { light: Some(0), rotation: Quat::from_rotation_x(-1.0), ..Default::default() });
    scene.update_transforms();
    scene
}

fn request(angle_rad: f32) -> FrameRequest {
    let tilted = Mat4::from_translation(Vec3::new(0.0, 90.0, 90.0)) * Mat4::from_rotation_x(-FRAC_PI_4);
    let world_from_view = Mat4::from_rotation_y(angle_rad) * tilted;
    let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
    let mut request = FrameRequest::new(640, 360, View { world_from_view, projection });
    set_dark(&mut request);
    request
}

fn set_dark(request: &mut FrameRequest) {
    request.settings.environment.source = Environment::None;
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let scene = scene();
    let gpu = Gpu::without_adapter(Default::default()).expect("a device that draws nothing");
    let mut renderer = Renderer::new(gpu).expect("a renderer");
    renderer.load(&scene).expect("the scene");
    let mut timed = |frame: &mut dyn FnMut(&mut Renderer, usize)| {
        let mut times = Vec::new();
        for index in 0..FRAMES + 3 {
            let started = Instant::now();
            frame(&mut renderer, index);
            times.push(started.elapsed().as_secs_f64() * 1e3);
        }
        median(times.split_off(3))
    };
    let still = timed(&mut |renderer, _| renderer.render(&scene, &request(0.0)).expect("a frame"));
    let moving = timed(&mut |renderer, at| renderer.render(&scene, &request(0.01 * at as f32)).expect("a frame"));
    println!("    one view {still:.2} ms, moving camera {moving:.2} ms");
    second_view(&scene, &mut timed, moving);
    println!("    draws {}", renderer.stats().draws);
}

fn second_view(scene: &Scene, timed: &mut impl FnMut(&mut dyn FnMut(&mut Renderer, usize)) -> f64, one: f64) {
    let two = timed(&mut |renderer, at| {
        let (first, second) = (request(0.01 * at as f32), request(1.0 + 0.01 * at as f32));
        renderer.render_views(scene, &[("", &first), ("second", &second)]).expect("a frame");
    });
    println!("    two views {two:.2} ms: {:.0} % more", 100.0 * (two / one - 1.0));
}
