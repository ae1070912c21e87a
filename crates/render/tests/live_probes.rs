//! Probes whose light frames find: it is that of what is around them, in stills at once and in live views by turns.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{self, half_float_renderer, matte_white as white, plain_request, renderer};
use glam::{Mat4, Quat, Vec3, Vec4};
use manypass::{Environment, FrameRequest, Path, Renderer, View};
use manypass_scene::framing::look_along;
use manypass_scene::primitives::{cube, plane, uv_sphere};
use manypass_scene::probes::{Harmonics, LiveProbes, ProbeBasis, ProbeGrid, ProbeLight, SmallSource};
use manypass_scene::surroundings::Region;
use manypass_scene::{Camera, EnvironmentMap, Light, Material, Mesh, Node, NodeId, Primitive, Projection, Scene};
use std::cell::Cell;
use std::f32::consts::PI;

const SIZE: (u32, u32) = (64, 48);
const RADIUS_M: f32 = 0.5;

fn add(scene: &mut Scene, primitive: Primitive, material: Material, node: Node) -> NodeId {
    scene.materials.push(material);
    let primitive = Primitive { material: Some(scene.materials.len() - 1), ..primitive };
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(scene.meshes.len() - 1), ..node })
}

fn live(counts: [u32; 3], half_m: f32) -> ProbeGrid {
    let region = Region { center_world: Vec3::ZERO, half_m: Vec3::splat(half_m) };
    // What is lit is not seen.
    let live = LiveProbes { layers: 1, ..LiveProbes::default() };
    ProbeGrid { live: Some(live), ..ProbeGrid::new("live", region, counts).unwrap() }
}

/// A white ball at the origin in the second layer, seen from +Z, with live probes.
fn scene_of(grid: ProbeGrid) -> (Scene, FrameRequest) {
    let mut scene = Scene::default();
    add(&mut scene, uv_sphere(RADIUS_M, 128, 64), white(), Node { layers: 2, ..Node::default() });
    let projection = Projection::Perspective { fov_y_rad: 0.7, near_m: 0.05, far_m: None };
    scene.cameras.push(Camera { name: String::new(), projection, aspect: None });
    scene.add_node(None, Node { translation: Vec3::new(0.0, 0.0, 1.6), camera: Some(0), ..Node::default() });
    scene.probes.push(grid);
    scene.update_transforms();
    let request = plain_request(&scene, SIZE);
    (scene, request)
}

/// A room of six walls that shine in six colours, two metres from the middle.
fn add_room(scene: &mut Scene) {
    for (normal, color) in WALLS {
        let rotation = Quat::from_rotation_arc(Vec3::Y, normal);
        let shining = Material { emissive_factor: color, base_color_factor: Vec4::W, ..white() };
        add(scene, plane(4.0), shining, Node { rotation, translation: -2.0 * normal, ..Node::default() });
    }
    scene.update_transforms();
}

/// Where the six walls face, and their radiance.
const WALLS: [(Vec3, Vec3); 6] = [
    (Vec3::NEG_X, Vec3::new(0.9, 0.1, 0.1)),
    (Vec3::X, Vec3::new(0.1, 0.8, 0.2)),
    (Vec3::NEG_Y, Vec3::new(0.2, 0.2, 1.0)),
    (Vec3::Y, Vec3::new(0.7, 0.6, 0.1)),
    (Vec3::NEG_Z, Vec3::new(0.1, 0.5, 0.6)),
    (Vec3::Z, Vec3::new(0.5, 0.1, 0.7)),
];

/// Light whose radiance a function says, summed over many directions.
fn harmonics_of(radiance: impl Fn(Vec3) -> Vec3) -> Harmonics {
    let count = 20_000u32;
    let mut light = Harmonics::default();
    for index in 0..count {
        let y = 1.0 - (2.0 * index as f32 + 1.0) / count as f32;
        let radius = (1.0 - y * y).max(0.0).sqrt();
        let (sin, cos) = (f64::from(index) * 2.399_963_229_728_653).sin_cos();
        let direction = Vec3::new(radius * cos as f32, y, radius * sin as f32);
        light.add(direction, radiance(direction) * (4.0 * PI / count as f32));
    }
    light
}

/// What the wall is that a direction from the middle of the room meets.
fn room_radiance(direction: Vec3) -> Vec3 {
    WALLS.iter().max_by(|a, b| direction.dot(-a.0).total_cmp(&direction.dot(-b.0))).unwrap().1
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<Vec3> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(4).map(Vec3::from_slice).collect()
}

/// Of every pixel that shows the ball, but for its rim, its normal.
fn seen(request: &FrameRequest) -> Vec<(usize, Vec3)> {
    let (width, height) = (request.width, request.height);
    let View { world_from_view, .. } = request.camera;
    let eye = world_from_view.w_axis.truncate();
    let half = request.camera.half_extent(width as f32 / height as f32);
    let of_pixel = |at: u32| {
        let x = ((at % width) as f32 + 0.5) / width as f32 * 2.0 - 1.0;
        let y = 1.0 - ((at / width) as f32 + 0.5) / height as f32 * 2.0;
        let ray = world_from_view.transform_vector3(Vec3::new(x * half.x, y * half.y, -1.0)).normalize();
        let along = -eye.dot(ray);
        let across_squared = eye.length_squared() - along * along;
        (across_squared < 0.8 * RADIUS_M * RADIUS_M).then(|| {
            let point = eye + ray * (along - (RADIUS_M * RADIUS_M - across_squared).sqrt());
            (at as usize, point.normalize())
        })
    };
    (0..width * height).filter_map(of_pixel).collect()
}

/// Checks that the ball has light that is within so much of what is expected.
fn assert_lit(shown: &[Vec3], request: &FrameRequest, light: &ProbeLight, allowed: f32, of: &str) {
    let pixels = seen(request);
    assert!(pixels.len() > 300, "{}", pixels.len());
    for (pixel, normal) in pixels {
        let (found, expected) = (shown[pixel], light.irradiance(normal));
        assert!((found - expected).abs().max_element() < allowed, "{of}, {normal}: {found} for {expected}");
    }
}

/// Cameras that look at the ball from all sides.
fn around(request: &FrameRequest) -> impl Iterator<Item = FrameRequest> {
    let turns = [Quat::IDENTITY, Quat::from_rotation_y(2.0), Quat::from_rotation_y(4.1), Quat::from_rotation_x(-1.4)];
    turns.into_iter().chain([Quat::from_rotation_x(1.4)]).map(|turn| {
        let camera = View { world_from_view: Mat4::from_quat(turn) * request.camera.world_from_view, ..request.camera };
        FrameRequest { camera, ..request.clone() }
    })
}

#[test]
fn a_ball_has_the_light_of_the_room_around_it() {
    [renderer(), half_float_renderer()].iter_mut().for_each(ball_has_the_light_of_the_room);
}

fn ball_has_the_light_of_the_room(renderer: &mut Renderer) {
    for basis in [ProbeBasis::Harmonics, ProbeBasis::AmbientCube] {
        let (mut scene, request) = scene_of(ProbeGrid { basis, ..live([1, 1, 1], 1.9) });
        add_room(&mut scene);
        let light = ProbeLight::new(&harmonics_of(room_radiance), SmallSource::default(), basis);
        for path in [Path::Deferred, Path::Forward] {
            for request in around(&request) {
                let request = request.with(|settings| settings.render.path = path);
                let shown = radiance(renderer, &scene, &request);
                assert_lit(&shown, &request, &light, 0.01, &format!("{basis:?} {path:?}"));
            }
        }
    }
}

#[test]
fn a_ball_has_the_light_of_the_environment_with_its_sun() {
    let sun = Vec3::new(0.5, 0.6, 0.62).normalize();
    let (cos, level, size) = (0.8f32.to_radians().cos(), 3000.0, (1024, 512));
    let sky = |to: Vec3| Vec3::new(0.4 + 0.3 * to.x, 0.5 + 0.2 * to.y, 0.4 - 0.3 * to.z);
    // What its texels bring.
    let irradiance = Cell::new(0.0);
    let sunny = |to: Vec3| {
        let is_sun = to.dot(sun) > cos;
        if is_sun {
            let solid_angle = (2.0 * PI / size.0 as f32) * (PI / size.1 as f32) * (1.0 - to.y * to.y).sqrt();
            irradiance.set(irradiance.get() + level * solid_angle);
        }
        sky(to) + if is_sun { Vec3::splat(level) } else { Vec3::ZERO }
    };
    let mut renderer = renderer();
    let (mut scene, request) = scene_of(live([1, 1, 1], 1.9));
    scene.environment = Some(EnvironmentMap::from_fn("sunny", size.0, size.1, sunny).into());
    let request = request.with(|settings| settings.environment.source = Environment::File);
    let source = SmallSource { direction: sun, irradiance: Vec3::splat(irradiance.get()), spread: 0.01 };
    assert!(source.irradiance.x > 1.0);
    let light = ProbeLight::Harmonics(harmonics_of(sky), source);
    for request in around(&request) {
        let shown = radiance(&mut renderer, &scene, &request);
        assert_lit(&shown, &request, &light, 0.02, "with its sun");
    }
    // A plate before the sun takes its light away; it is black, and small.
    let rotation = Quat::from_rotation_arc(Vec3::Y, -sun);
    let black = Material { base_color_factor: Vec4::W, ..white() };
    add(&mut scene, plane(0.4), black, Node { rotation, translation: 1.5 * sun, ..Node::default() });
    scene.update_transforms();
    let behind = ProbeLight::Harmonics(harmonics_of(sky), SmallSource::default());
    let shown = radiance(&mut renderer, &scene, &request);
    assert_lit(&shown, &request, &behind, 0.05, "behind a plate");
}

/// A white room lit by a lamp, whose walls send light back again and again, with a grid of probes.
fn lit_room(bounces: u32) -> (Scene, FrameRequest, NodeId) {
    let grid = live([2, 2, 2], 2.0);
    let live = grid.live.map(|live| LiveProbes { bounces, ..live });
    let (mut scene, request) = scene_of(ProbeGrid { live, ..grid });
    for (normal, _) in WALLS {
        let rotation = Quat::from_rotation_arc(Vec3::Y, normal);
        let grey = Material { base_color_factor: Vec4::new(0.5, 0.5, 0.5, 1.0), ..white() };
        add(&mut scene, plane(4.0), grey, Node { rotation, translation: -2.0 * normal, ..Node::default() });
    }
    scene.lights.push(Light { intensity: 5.0, casts_shadows: false, ..Light::default() });
    let lamp = Node { translation: Vec3::new(0.8, 0.8, 0.8), light: Some(0), ..Node::default() };
    let lamp = scene.add_node(None, lamp);
    scene.update_transforms();
    (scene, request, lamp)
}

fn mean(shown: &[Vec3]) -> f32 {
    shown.iter().map(|of| of.y).sum::<f32>() / shown.len() as f32
}

#[test]
fn every_bounce_adds_half_as_much_as_the_one_before() {
    let mut renderer = renderer();
    let of_bounces: Vec<f32> = [0, 1, 2, 3, 6]
        .into_iter()
        .map(|bounces| {
            let (scene, request, _) = lit_room(bounces.max(1));
            let request = request.with(|settings| settings.captures.enabled = bounces > 0);
            mean(&radiance(&mut renderer, &scene, &request))
        })
        .collect();
    let steps: Vec<f32> = of_bounces.windows(2).map(|two| two[1] - two[0]).collect();
    // In a closed grey room all light comes back by half; before the second time it is not everywhere yet.
    assert!((0.3..0.65).contains(&(steps[1] / steps[0])), "{of_bounces:?}");
    assert!((steps[2] / steps[1] - 0.5).abs() < 0.06, "{of_bounces:?}");
    assert!((steps[3] / steps[2] - 0.875).abs() < 0.1, "{of_bounces:?}");
}

#[test]
fn a_live_view_finds_light_by_turns_and_again_when_something_moves() {
    let mut renderer = renderer();
    let (mut scene, request, lamp) = lit_room(4);
    let of_still = radiance(&mut renderer, &scene, &request);
    let live = FrameRequest { goes_on: true, ..request.clone() };
    let live = live.with(|settings| settings.captures.probes = 5);
    let mut other = common::renderer();
    let count = scene.probes[0].count() as u32;
    // The first frame writes what there is; those after it look around five probes each, four times around all.
    let settled = |renderer: &mut Renderer, scene: &Scene| {
        let mut captured = 0;
        for frame in 0..60 {
            renderer.render(scene, &live).unwrap();
            let of_frame = renderer.stats().probes_captured;
            assert!(of_frame <= 5);
            captured += of_frame;
            if frame > 2 && of_frame == 0 {
                break;
            }
        }
        captured
    };
    assert_eq!(settled(&mut other, &scene), 4 * count);
    let near = |a: &[Vec3], b: &[Vec3]| {
        let off = a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0f32, f32::max);
        off / a.iter().map(|of| of.max_element()).fold(0f32, f32::max)
    };
    let of_live = radiance(&mut other, &scene, &live);
    // By turns each look finds what others of the same round have found: more light than in as many rounds.
    assert!(near(&of_still, &of_live) < 0.03, "{}", near(&of_still, &of_live));
    // Nothing moves: nothing is looked at.
    other.render(&scene, &live).unwrap();
    assert_eq!(other.stats().probes_captured, 0);
    let moved = FrameRequest { camera: around(&live).nth(1).unwrap().camera, ..live.clone() };
    other.render(&scene, &moved).unwrap();
    assert_eq!(other.stats().probes_captured, 0, "the camera lights nothing");
    scene.nodes[lamp.0 as usize].translation = Vec3::new(-0.8, -0.8, 0.8);
    scene.update_transforms();
    assert_eq!(settled(&mut other, &scene), 4 * count);
    let of_live = radiance(&mut other, &scene, &live);
    let of_still = radiance(&mut renderer, &scene, &request);
    assert!(near(&of_still, &of_live) < 0.03, "{}", near(&of_still, &of_live));
    // The same still again finds what is there; and its picture does not depend on what came before.
    let again = radiance(&mut renderer, &scene, &request);
    assert_eq!(again, of_still);
    assert_eq!(radiance(&mut common::renderer(), &scene, &request), of_still);
    assert_eq!(radiance(&mut other, &scene, &request), of_still, "after a live view");
}

#[test]
fn grids_that_are_others_have_other_light() {
    let mut renderer = renderer();
    let (mut scene, request, _) = lit_room(1);
    let changes: [fn(&mut Scene); 4] = [
        |scene| scene.probes[0].region.center_world.x += 0.4,
        |scene| scene.probes[0].basis = ProbeBasis::AmbientCube,
        |scene| scene.probes.insert(0, live([2, 1, 1], 0.4)),
        |scene| scene.probes.swap(0, 1),
    ];
    radiance(&mut renderer, &scene, &request);
    for (at, change) in changes.into_iter().enumerate() {
        change(&mut scene);
        let shown = radiance(&mut renderer, &scene, &request);
        assert!(shown == radiance(&mut common::renderer(), &scene, &request), "change {at}");
    }
}

#[test]
fn finding_light_can_be_followed_and_stopped() {
    let mut renderer = renderer();
    let (scene, request, _) = lit_room(2);
    let count = scene.probes[0].count();
    let mut told = Vec::new();
    let stopped = renderer.find_probe_light(&scene, &request, &mut |done, all| {
        told.push((done, all));
        done < 8
    });
    assert_eq!(stopped.unwrap_err().to_string(), "stopped");
    assert_eq!(told, [(8, 2 * count)]);
    renderer.find_probe_light(&scene, &request, &mut |_, _| true).unwrap();
    renderer.find_probe_light(&scene, &request, &mut |_, _| panic!("it is known")).unwrap();
    let shown = radiance(&mut renderer, &scene, &request);
    assert_eq!(shown, radiance(&mut common::renderer(), &scene, &request));
}

#[test]
fn what_frames_found_can_be_read_and_drawn_as_baked() {
    let cases = [(ProbeBasis::Harmonics, renderer()), (ProbeBasis::AmbientCube, half_float_renderer())];
    for (basis, mut renderer) in cases {
        let (mut scene, request, _) = lit_room(2);
        scene.probes[0].basis = basis;
        assert_eq!(renderer.read_probes(&scene, 0).unwrap(), None, "nothing was found of this grid");
        renderer.find_probe_light(&scene, &request, &mut |_, _| true).unwrap();
        let found = renderer.read_probes(&scene, 0).unwrap().unwrap();
        assert_eq!((found.len(), renderer.read_probes(&scene, 1).unwrap()), (scene.probes[0].count(), None));
        let of_live = radiance(&mut renderer, &scene, &request);
        scene.probes[0].live = None;
        scene.probes[0].probes = Some(found.into());
        let of_kept = radiance(&mut renderer, &scene, &request);
        assert!(mean(&of_live) > 0.05);
        let off = of_live.iter().zip(&of_kept).map(|(a, b)| (*a - *b).abs().max_element()).fold(0f32, f32::max);
        assert!(off < 0.005 * mean(&of_live), "{basis:?}: {off}");
    }
}

/// A floor from a bright room, at x below 0, to a dark one.
#[test]
fn probes_find_out_that_light_does_not_come_through_walls() {
    let mut renderer = renderer();
    let leak = |renderer: &mut Renderer, thickness_m: Option<f32>| {
        let (mut scene, request) = scene_of(live([6, 4, 4], 2.0));
        // The lamp shines into probes at once.
        scene.probes[0].live = Some(LiveProbes { bounces: 1, layers: 1 });
        let floor = Node { translation: Vec3::NEG_Y * 0.6, layers: 2, ..Node::default() };
        add(&mut scene, plane(4.0), white(), floor);
        let shining = Material { emissive_factor: Vec3::splat(20.0), ..white() };
        let lamp = Node { translation: Vec3::new(-1.0, 0.6, 0.0), layers: 1, ..Node::default() };
        add(&mut scene, uv_sphere(0.3, 16, 8), shining, lamp);
        let black = Material { base_color_factor: Vec4::W, ..white() };
        if let Some(thickness_m) = thickness_m {
            add(&mut scene, cube(Vec3::new(thickness_m, 8.0, 8.0)), black, Node { layers: 1, ..Node::default() });
        }
        scene.update_transforms();
        let request = FrameRequest { layers: 2, ..request };
        let eye = Vec3::new(0.0, 3.0, 2.0);
        let rotation = look_along(Vec3::NEG_Y * 0.6 - eye, Vec3::Y).unwrap();
        let view = View { world_from_view: Mat4::from_rotation_translation(rotation, eye), ..request.camera };
        let request = FrameRequest { camera: view, ..request };
        let shown = radiance(renderer, &scene, &request);
        let half = |from: usize, to: usize| {
            let of = shown.iter().enumerate().filter(|(at, _)| (from..to).contains(&(at % SIZE.0 as usize)));
            let of: Vec<f32> = of.map(|(_, of)| of.x).collect();
            (of.iter().sum::<f32>() / of.len() as f32, of.iter().copied().fold(0.0, f32::max))
        };
        let ((bright, _), (_, most)) = (half(0, 22), half(42, 64));
        most / bright
    };
    // In the thick one there are probes.
    for thickness_m in [0.05, 0.9] {
        let with_wall = leak(&mut renderer, Some(thickness_m));
        assert!(with_wall < 0.01, "{thickness_m} m: {with_wall}");
    }
    let without = leak(&mut renderer, None);
    assert!(without > 0.1, "{without}");
}
