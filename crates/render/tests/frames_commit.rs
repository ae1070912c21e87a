//! A frame that fails changes nothing: once its cause is lifted, pictures and what caches hold are those of a renderer for
//! which nothing failed. And frames that follow each other make nothing anew.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common;
use crate::common::ground::{product_shot, scene_of};
use crate::common::renderer;
use glam::{Mat4, Quat, Vec3};
use manypass::{
    Background, EffectFile, Environment, Exposure, FrameRequest, Ground, Path, PixelSamples, RenderError, Renderer,
    WgslEffect,
};
use manypass_scene::capture::{Monitor, MonitorCamera, Update};
use manypass_scene::probes::{LiveProbes, ProbeGrid};
use manypass_scene::surroundings::{Region, Surroundings};
use manypass_scene::{
    Cache, Image, Material, Mesh, Node, NodeId, Primitive, Projection, Sampler, Scene, Texture, TextureRef, primitives,
};
use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;
use std::sync::{Arc, Mutex};

const SIZE: (u32, u32) = (96, 64);

/// The body that moves, which is the first node.
const BODY: NodeId = NodeId(0);

/// Reads what the forward path does not have.
const MOVED: &str = "//! effect moved
//! reads: radiance, motion
//! pixel: changed
fn changed(color: vec4f, position: vec2f) -> vec4f {
    return color + vec4f(textureLoad(motion, vec2i(position), 0).rg, 0.0, 0.0);
}
";

/// A cache in memory.
#[derive(Debug, Default)]
struct Entries(Mutex<BTreeMap<String, Vec<u8>>>);

impl Entries {
    fn all(&self) -> BTreeMap<String, Vec<u8>> {
        self.0.lock().unwrap().clone()
    }
}

impl Cache for Entries {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        self.0.lock().unwrap().get(name).cloned()
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        self.0.lock().unwrap().insert(name.into(), bytes.into());
    }
}

/// A body over the ground under the sky, and beside it a screen that shows the zenith and is drawn once.
fn stage() -> Scene {
    let mut scene = scene_of(primitives::cube(Vec3::ONE), 1.0);
    let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
    let world_from_view = Mat4::from_translation(5.0 * Vec3::Y) * Mat4::from_rotation_x(FRAC_PI_2);
    let mut monitor = Monitor::new(MonitorCamera::Fixed { world_from_view, projection }, 32, 32);
    monitor.options.update = Update::Once;
    scene.images.push(Image::of_monitor("zenith", monitor));
    scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    scene.materials.push(Material {
        base_color_factor: Vec3::ZERO.extend(1.0),
        emissive_texture: Some(TextureRef { texture: 0, ..TextureRef::default() }),
        emissive_factor: Vec3::ONE,
        ..Material::default()
    });
    let square = Primitive { material: Some(1), ..primitives::plane(1.0) };
    scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
    let translation = Vec3::new(1.5, 1.0, 0.0);
    let rotation = Quat::from_rotation_x(FRAC_PI_2);
    scene.add_node(None, Node { mesh: Some(1), translation, rotation, ..Node::default() });
    scene.update_transforms();
    scene
}

/// The same within a reflection probe and live irradiance probes.
fn probed_stage() -> Scene {
    let region = Region { center_world: Vec3::Y, half_m: Vec3::splat(2.0) };
    let mut scene = stage();
    scene.surroundings.push(Surroundings::of_room("around", region));
    let live = Some(LiveProbes::default());
    scene.probes.push(ProbeGrid { live, ..ProbeGrid::new("live", region, [2, 2, 2]).unwrap() });
    scene
}

/// A frame of a live view of [`stage`], on the forward path, with shadows and a ground; its exposure is metered.
fn live_request(scene: &Scene) -> FrameRequest {
    let mut request = product_shot(scene, SIZE, [20.0, 25.0]);
    request.settings.render.path = Path::Forward;
    request.settings.environment.source = Environment::Sky;
    request.settings.background.source = Background::Environment;
    request.settings.ground.mode = Ground::Color([0.5; 3]);
    let mut metering = renderer();
    metering.load(scene).unwrap();
    metering.expose(scene, &mut request, Exposure::Auto { compensation_stops: 0.0 }).unwrap();
    request.goes_on = true;
    request
}

fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<u8> {
    renderer.render(scene, request).unwrap();
    renderer.read_display().unwrap()
}

fn moved(scene: &Scene, by_m: Vec3) -> Scene {
    let mut scene = scene.clone();
    scene.nodes[BODY.0 as usize].translation += by_m;
    scene.update_transforms();
    scene
}

/// Makes frames of the first renderer fail, and lifts the cause; the second one is in the same state, to be tried out.
type Fail = fn([&mut Renderer; 2], &Scene, &FrameRequest);

/// What frames fail of, and how.
const CAUSES: [(&str, Fail); 2] = [("an effect reads motion", read_motion), ("memory is short", run_short)];

fn read_motion([renderer, _]: [&mut Renderer; 2], scene: &Scene, request: &FrameRequest) {
    let file = EffectFile::parse("moved.wgsl", MOVED).unwrap_or_else(|error| panic!("{error}"));
    let effect = WgslEffect::compile(renderer.gpu(), file).unwrap();
    let failing = FrameRequest { effects: vec![Arc::new(effect)], ..request.clone() };
    let error = renderer.render(scene, &failing).unwrap_err().to_string();
    assert!(error.contains("render.path=deferred"), "{error}");
}

/// Twice: with no memory at all, and with a byte less than the frame takes, which is known once all of it is prepared.
fn run_short([renderer, other]: [&mut Renderer; 2], scene: &Scene, request: &FrameRequest) {
    // Passes have no textures of four samples yet.
    let failing = request.with(|settings| settings.msaa.samples = PixelSamples::Four);
    let needed_bytes = |renderer: &mut Renderer, budget_bytes: u64| {
        renderer.set_memory_budget(Some(budget_bytes));
        match renderer.render(scene, &failing) {
            Err(RenderError::Memory { needed_bytes, .. }) => Some(needed_bytes),
            other => other.map(|()| None).unwrap(),
        }
    };
    let mut all_bytes = 0;
    while let Some(bytes) = needed_bytes(other, all_bytes) {
        assert!(bytes > all_bytes, "{bytes} of {all_bytes} bytes");
        all_bytes = bytes;
    }
    for budget_bytes in [0, all_bytes - 1] {
        assert!(needed_bytes(renderer, budget_bytes).is_some(), "{budget_bytes} of {all_bytes} bytes suffice");
    }
    renderer.set_memory_budget(None);
}

#[test]
fn the_frame_after_a_first_one_that_failed_is_that_of_a_fresh_renderer() {
    let scene = stage();
    let request = live_request(&scene);
    let drawn = |fail: Option<Fail>| {
        let (mut renderer, cache) = (renderer(), Arc::new(Entries::default()));
        renderer.set_cache(Some(cache.clone()));
        renderer.load(&scene).unwrap();
        if let Some(fail) = fail {
            fail([&mut renderer, &mut common::renderer()], &scene, &request);
            assert!(cache.all().is_empty(), "tiles that nobody has drawn are kept");
            assert!(renderer.read_display().is_err(), "a picture that nobody has drawn is read");
        }
        let picture = picture(&mut renderer, &scene, &request);
        assert_eq!(renderer.stats().captures, 1);
        // The screen stays as it was drawn.
        assert!(self::picture(&mut renderer, &scene, &request) == picture);
        assert_eq!(renderer.stats().captures, 0);
        (picture, cache.all())
    };
    let (fresh, entries) = drawn(None);
    let levels: std::collections::BTreeSet<u8> = fresh.iter().copied().collect();
    assert!(levels.len() > 32 && !entries.is_empty(), "the test shows nothing");
    for (cause, fail) in CAUSES {
        let (picture, kept) = drawn(Some(fail));
        assert!(picture == fresh, "{cause}: another picture");
        assert!(kept == entries, "{cause}: other tiles are kept");
    }
}

#[test]
fn a_frame_that_fails_leaves_a_live_view_as_it_is() {
    let scene = probed_stage();
    let request = live_request(&scene);
    let after = moved(&scene, Vec3::new(-0.3, 0.2, 0.1));
    for (cause, fail) in CAUSES {
        let [mut steady, mut failed, mut other] = [renderer(), renderer(), renderer()];
        let first = [&mut steady, &mut failed, &mut other].map(|renderer| picture(renderer, &scene, &request));
        assert!(first[0] == first[1]);
        fail([&mut failed, &mut other], &after, &request);
        assert!(failed.read_display().unwrap() == first[0], "{cause}: the former picture is gone");
        let [expected, found] = [&mut steady, &mut failed].map(|renderer| picture(renderer, &after, &request));
        assert!(expected != first[0], "the test shows nothing");
        assert!(found == expected, "{cause}: another picture");
    }
}

/// Lets the device refuse something, as it would a texture for which it has no room.
fn refuse(renderer: &Renderer) {
    let descriptor = wgpu::BufferDescriptor {
        label: Some("no room"),
        size: 1 << 60,
        usage: wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    };
    drop(renderer.gpu().device.create_buffer(&descriptor));
}

#[test]
fn a_frame_that_fails_forgets_nothing_that_was_refused_of_loading() {
    let scene = stage();
    let request = live_request(&scene);
    let mut failed = renderer();
    let first = picture(&mut failed, &scene, &request);
    refuse(&failed);
    read_motion([&mut failed, &mut renderer()], &scene, &request);
    let error = failed.load(&scene).unwrap_err().to_string();
    assert!(error.contains("create_buffer"), "{error}");
    failed.load(&scene).unwrap();
    assert!(picture(&mut failed, &scene, &request) == first, "another picture after it was told");
}

#[test]
fn after_a_frame_that_the_device_refused_a_live_view_is_that_of_a_fresh_renderer() {
    let scene = stage();
    let request = live_request(&scene);
    let after = moved(&scene, Vec3::new(-0.3, 0.2, 0.1));
    let [mut fresh, mut refused] = [renderer(), renderer()];
    let first = picture(&mut refused, &scene, &request);
    refuse(&refused);
    let error = refused.render(&after, &request).unwrap_err().to_string();
    assert!(error.contains("create_buffer"), "{error}");
    let [expected, found] = [&mut fresh, &mut refused].map(|renderer| picture(renderer, &after, &request));
    assert!(expected != first, "the test shows nothing");
    assert!(found == expected, "another picture");
    // Nobody knows what was drawn: the screen is drawn once more, and then stays.
    assert_eq!(refused.stats().captures, 1);
    assert!(picture(&mut refused, &after, &request) == expected);
    assert_eq!(refused.stats().captures, 0);
}

#[test]
fn a_plan_changes_nothing() {
    let scene = stage();
    let request = live_request(&scene);
    let after = moved(&scene, Vec3::new(-0.3, 0.2, 0.1));
    let [mut steady, mut planned] = [renderer(), renderer()];
    for scene in [&scene, &after] {
        planned.plan(scene, &request).unwrap();
        let [expected, found] = [&mut steady, &mut planned].map(|renderer| picture(renderer, scene, &request));
        assert!(found == expected);
        assert_eq!(planned.stats().shadow_tiles_drawn, steady.stats().shadow_tiles_drawn);
    }
}

#[test]
fn a_live_view_of_what_moves_makes_nothing_anew() {
    let mut scene = scene_of(primitives::cube(Vec3::ONE), 1.0);
    let mut request = product_shot(&scene, (640, 480), [20.0, 25.0]);
    request.settings.ground.mode = Ground::Shadow;
    request.goes_on = true;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut made = Vec::new();
    for _ in 0..10 {
        renderer.render(&scene, &request).unwrap();
        let stats = renderer.stats();
        made.push((stats.textures_made, stats.bind_groups_made));
        scene = moved(&scene, 0.01 * Vec3::X);
    }
    assert!(made[0].0 > 0 && made[0].1 > 0, "{made:?}");
    assert!(made[2..].iter().all(|made| *made == (0, 0)), "textures and bind groups by frame: {made:?}");
}
