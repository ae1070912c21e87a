//! The time of a frame outside the adapter, on a device that draws nothing: 10,000 nodes with as many meshes, and up to a
//! million that show one mesh.
//! `cargo bench -p manypass --bench nodes`.

use glam::{Mat4, Quat, Vec3, Vec4};
use manypass::scene::{Light, LightKind, Material, Mesh, Node, Projection, Scene, primitives};
use manypass::{Environment, FrameRequest, Gpu, Renderer, View};
use std::f32::consts::FRAC_PI_4;
use std::time::Instant;

const SIDE: usize = 100;
const MATERIALS: usize = 64;
const BATCHES: usize = 7;
const FRAMES: usize = 50;
/// Nodes that show one mesh.
const INSTANCES: [usize; 3] = [10_000, 100_000, 1_000_000];
const INSTANCE_FRAMES: usize = 5;
/// The same where the scene and the camera stand still: the system tells a thread's time in steps of 10 ms.
const STILL_FRAMES: usize = 200;

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
    add_sun(&mut scene);
    scene.update_transforms();
    scene
}

fn add_sun(scene: &mut Scene) {
    let sun = Light {
        name: "sun".into(),
        color_linear: Vec3::ONE,
        intensity: 3.0,
        range_m: None,
        kind: LightKind::Directional,
        ..Light::default()
    };
    scene.lights.push(sun);
    scene.add_node(None, Node { light: Some(0), rotation: Quat::from_rotation_x(-1.0), ..Default::default() });
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

/// The time that this thread has computed, in milliseconds; where the system does not tell, the time on the wall.
fn cpu_ms(since: Instant) -> f64 {
    let schedstat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = schedstat.split(' ').next().and_then(|first| first.parse::<f64>().ok());
    nanoseconds.map_or_else(|| since.elapsed().as_secs_f64() * 1e3, |nanoseconds| nanoseconds * 1e-6)
}

/// The time of a frame: median and least of batches, because systems count by ticks of milliseconds.
fn timed(frames: usize, mut frame: impl FnMut(usize)) -> [f64; 2] {
    let since = Instant::now();
    (0..3).for_each(&mut frame);
    let mut times: Vec<f64> = (0..BATCHES)
        .map(|batch| {
            let started_ms = cpu_ms(since);
            (0..frames).for_each(|index| frame(batch * frames + index));
            (cpu_ms(since) - started_ms) / frames as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    [times[times.len() / 2], times[0]]
}

fn main() {
    let scene = scene();
    let gpu = Gpu::without_adapter(Default::default()).expect("a device that draws nothing");
    let mut renderer = Renderer::new(gpu).expect("a renderer");
    renderer.load(&scene).expect("the scene");
    let still = timed(FRAMES, |_| renderer.render(&scene, &request(0.0)).expect("a frame"));
    let moving = timed(FRAMES, |at| renderer.render(&scene, &request(0.01 * at as f32)).expect("a frame"));
    println!("    still, ms of one core: median {:.2}, least {:.2}", still[0], still[1]);
    println!("    moving camera: median {:.2}, least {:.2}; {} draws", moving[0], moving[1], renderer.stats().draws);
    second_view(&scene, &mut renderer, moving);
    INSTANCES.into_iter().for_each(instances);
}

/// Frames of so many nodes that show one mesh.
fn instances(count: usize) {
    let mut scene = Scene::default();
    scene.meshes.push(Mesh { primitives: vec![primitives::cube(Vec3::splat(0.4))], ..Default::default() }.into());
    let parent = scene.add_node(None, Node::default());
    let side = count.isqrt();
    let place = |index: usize, spacing_m: f32| {
        let cell = |at: usize| (at as f32 - 0.5 * side as f32) * spacing_m;
        Vec3::new(cell(index % side), 0.0, cell(index / side))
    };
    // All on the same ground, however many, so that all are seen.
    let spacing_m = SIDE as f32 / side as f32;
    for index in 0..count {
        let node = Node { mesh: Some(0), translation: place(index, spacing_m), ..Default::default() };
        scene.add_node(Some(parent), node);
    }
    add_sun(&mut scene);
    scene.update_transforms();
    let gpu = Gpu::without_adapter(Default::default()).expect("a device that draws nothing");
    let mut renderer = Renderer::new(gpu).expect("a renderer");
    renderer.load(&scene).expect("the scene");
    let live = |angle_rad: f32, is_temporal: bool| {
        let mut request = request(angle_rad);
        (request.goes_on, request.settings.taa.enabled) = (true, is_temporal);
        request
    };
    let mut still = |is_temporal: bool| {
        timed(STILL_FRAMES, |_| {
            scene.update_transforms();
            renderer.render(&scene, &live(0.0, is_temporal)).expect("a frame");
        })
    };
    let [[plain, _], [temporal, _]] = [false, true].map(&mut still);
    let [moving, _] =
        timed(INSTANCE_FRAMES, |at| renderer.render(&scene, &live(0.01 * at as f32, false)).expect("a frame"));
    println!("    {count} instances of a mesh: still {plain:.2}, with TAA {temporal:.2}, moving camera {moving:.2}");
}

fn second_view(scene: &Scene, renderer: &mut Renderer, one: [f64; 2]) {
    let two = timed(FRAMES, |at| {
        let (first, second) = (request(0.01 * at as f32), request(1.0 + 0.01 * at as f32));
        renderer.render_views(scene, &[("", &first), ("second", &second)]).expect("a frame");
    });
    let more = [0, 1].map(|at| 100.0 * (two[at] / one[at] - 1.0));
    println!(
        "    two views: median {:.2} ({:.0} % more), least {:.2} ({:.0} % more)",
        two[0], more[0], two[1], more[1]
    );
}
