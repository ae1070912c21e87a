//! Probes: surfaces have the light that their probes know, on every path, and none through walls.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{half_float_renderer, matte_white as white, plain_request, renderer};
use glam::{Vec2, Vec3};
use manypass::{Environment, FrameRequest, Path, Renderer};
use manypass_scene::framing::look_along;
use manypass_scene::primitives::{plane, uv_sphere};
use manypass_scene::probes::{
    DISTANCE_SIDE, Harmonics, Probe, ProbeBasis, ProbeGrid, ProbeLight, SmallSource, distance_direction,
};
use manypass_scene::surroundings::Region;
use manypass_scene::{Camera, EnvironmentMap, Mesh, Node, Primitive, Projection, Scene};
use std::sync::Arc;

const SIZE: (u32, u32) = (64, 48);
const PATHS: [Path; 4] = [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud];
const EYE: Vec3 = Vec3::new(0.6, 0.8, 3.0);
const RADIUS_M: f32 = 0.8;

/// A white thing at the origin, in probes of a box of four metres.
fn scene_of(primitive: Primitive, grid: ProbeGrid) -> (Scene, FrameRequest) {
    let mut scene = Scene::default();
    scene.materials.push(white());
    let primitive = Primitive { material: Some(0), ..primitive };
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    let projection = Projection::Perspective { fov_y_rad: 0.7, near_m: 0.05, far_m: None };
    scene.cameras.push(Camera { name: String::new(), projection, aspect: None });
    let rotation = look_along(-EYE, Vec3::Y).unwrap();
    scene.add_node(None, Node { translation: EYE, rotation, camera: Some(0), ..Node::default() });
    scene.probes.push(grid);
    scene.update_transforms();
    let request = plain_request(&scene, SIZE);
    (scene, request)
}

fn grid(counts: [u32; 3], probe: impl Fn(usize, Vec3) -> Probe) -> ProbeGrid {
    let region = Region { center_world: Vec3::ZERO, half_m: Vec3::splat(2.0) };
    let grid = ProbeGrid::new("probes", region, counts).unwrap();
    let probes: Vec<Probe> = (0..grid.count()).map(|index| probe(index, grid.place(index))).collect();
    let is_cube = matches!(probes[0].light, ProbeLight::AmbientCube(_));
    let basis = if is_cube { ProbeBasis::AmbientCube } else { ProbeBasis::Harmonics };
    ProbeGrid { probes: Some(Arc::new(probes)), basis, ..grid }
}

/// A probe that sees nothing nearby.
fn open(light: ProbeLight) -> Probe {
    let far_m = 10.0;
    Probe {
        is_on: true,
        light,
        distances: [Vec2::new(far_m, far_m * far_m); DISTANCE_SIDE * DISTANCE_SIDE],
        ..Probe::default()
    }
}

fn even(radiance: Vec3) -> Harmonics {
    let mut light = Harmonics::default();
    light.0[0] = radiance * (4.0 * std::f32::consts::PI).sqrt();
    light
}

/// Light from a few sides, in colours, and a small source.
fn lively() -> (Harmonics, SmallSource) {
    let mut light = even(Vec3::new(0.4, 0.3, 0.5));
    light.add(Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.5, 0.2, 0.1));
    light.add(Vec3::new(0.0, -0.6, 0.8), Vec3::new(0.1, 0.2, 0.5));
    let direction = Vec3::new(0.2, 0.5, 0.8).normalize();
    (light, SmallSource { direction, irradiance: Vec3::new(1.5, 1.0, 0.5), spread: 0.2 })
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 4]> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
}

/// Of every pixel that shows the ball, but for its rim, where and with which normal.
fn seen(request: &FrameRequest) -> Vec<(usize, Vec3, Vec3)> {
    let (width, height) = (request.width, request.height);
    let of_pixel = |at: u32| {
        let ray = ray_of(request, at);
        let along = -EYE.dot(ray);
        let across_squared = EYE.length_squared() - along * along;
        (across_squared < 0.8 * RADIUS_M * RADIUS_M).then(|| {
            let point = EYE + ray * (along - (RADIUS_M * RADIUS_M - across_squared).sqrt());
            (at as usize, point, point.normalize())
        })
    };
    (0..width * height).filter_map(of_pixel).collect()
}

#[test]
fn a_ball_has_the_light_of_its_probes_by_its_normals() {
    [renderer(), half_float_renderer()].iter_mut().for_each(ball_has_its_light);
}

fn ball_has_its_light(renderer: &mut Renderer) {
    let (light, source) = lively();
    for basis in [ProbeBasis::Harmonics, ProbeBasis::AmbientCube] {
        let light = ProbeLight::new(&light, source, basis);
        for counts in [[1, 1, 1], [4, 3, 5]] {
            let (scene, request) = scene_of(uv_sphere(RADIUS_M, 128, 64), grid(counts, |_, _| open(light)));
            for path in PATHS {
                let request = request.with(|settings| settings.render.path = path);
                let shown = radiance(renderer, &scene, &request);
                let pixels = seen(&request);
                assert!(pixels.len() > 300);
                for (pixel, _, normal) in pixels {
                    let expected = light.irradiance(normal);
                    let found = Vec3::from_slice(&shown[pixel]);
                    let off = (found - expected).abs().max_element();
                    // Gouraud has the light of vertices.
                    let allowed = if path == Path::Gouraud { 0.03 } else { 0.012 };
                    assert!(off < allowed, "{basis:?} {counts:?} {path:?} {normal}: {found} for {expected}");
                }
            }
        }
    }
}

#[test]
fn a_furnace_of_probes_is_white() {
    [renderer(), half_float_renderer()].iter_mut().for_each(furnace_is_white);
}

fn furnace_is_white(renderer: &mut Renderer) {
    for basis in [ProbeBasis::Harmonics, ProbeBasis::AmbientCube] {
        let light = ProbeLight::new(&even(Vec3::ONE), SmallSource::default(), basis);
        let (mut scene, request) = scene_of(uv_sphere(RADIUS_M, 128, 64), grid([3, 3, 3], |_, _| open(light)));
        let sunny = |to: Vec3| Vec3::splat(if to.dot(EYE.normalize()) > 0.999 { 5000.0 } else { 1.0 });
        scene.environment = Some(EnvironmentMap::from_fn("sunny", 512, 256, sunny).into());
        // Whatever is around: a dark place, a bright one, and one with a sun, whose light is in probes already.
        for source in [Environment::None, Environment::Color([9.0; 3]), Environment::File] {
            let request = request.with(|settings| settings.environment.source = source);
            let shown = radiance(renderer, &scene, &request);
            for (pixel, _, normal) in seen(&request) {
                let found = Vec3::from_slice(&shown[pixel]);
                assert!((found - 1.0).abs().max_element() < 0.01, "{basis:?} {source:?} {normal}: {found}");
            }
        }
    }
}

#[test]
fn light_goes_evenly_from_probe_to_probe_and_fades_into_the_environment() {
    let brightness = |place: Vec3| Vec3::splat(1.0 + 0.4 * place.x + 0.2 * place.y);
    let probe = |_: usize, place: Vec3| {
        open(ProbeLight::new(&even(brightness(place)), SmallSource::default(), ProbeBasis::Harmonics))
    };
    let (mut scene, request) = scene_of(uv_sphere(RADIUS_M, 128, 64), grid([8, 8, 8], probe));
    let mut renderer = renderer();
    let shown = radiance(&mut renderer, &scene, &request);
    for (pixel, point, _) in seen(&request) {
        let (found, expected) = (shown[pixel][0], brightness(point).x);
        // Probes before a surface count more than those behind it.
        assert!((found - expected).abs() < 0.14, "{point}: {found} for {expected}");
    }
    // A box that ends in the middle of the ball, and fades over as much as it is wide there.
    scene.probes[0].region = Region { center_world: Vec3::new(-2.0, 0.0, 0.0), half_m: Vec3::splat(2.0) };
    scene.probes[0].fade_m = 0.5;
    let request = request.with(|settings| settings.environment.source = Environment::Color([5.0; 3]));
    let shown = radiance(&mut renderer, &scene, &request);
    for (pixel, point, _) in seen(&request) {
        let share = (-point.x / 0.5).clamp(0.0, 1.0);
        let of_probes = brightness(point + Vec3::new(2.0, 0.0, 0.0)).x;
        let expected = 5.0 * (1.0 - share) + of_probes * share;
        // By so much the box is larger than it says.
        assert!((shown[pixel][0] - expected).abs() < 0.35, "{point}: {} for {expected}", shown[pixel][0]);
    }
}

/// The ray through the middle of a pixel.
fn ray_of(request: &FrameRequest, at: u32) -> Vec3 {
    let (width, height) = (request.width, request.height);
    let half = request.camera.half_extent(width as f32 / height as f32);
    let place = Vec2::new((at % width) as f32 + 0.5, (at / width) as f32 + 0.5)
        / Vec2::new(width as f32, height as f32)
        * Vec2::new(2.0, -2.0)
        + Vec2::new(-1.0, 1.0);
    request.camera.world_from_view.transform_vector3((place * half).extend(-1.0)).normalize()
}

/// What a probe knows of distances that a function says: means over lobes about the middles of texels, as bakes have them.
fn distances(of: impl Fn(Vec3) -> f32) -> [Vec2; DISTANCE_SIDE * DISTANCE_SIDE] {
    let count = 8000u16;
    let directions: Vec<(Vec3, f32)> = (0..count)
        .map(|index| {
            let y = 1.0 - (2.0 * f32::from(index) + 1.0) / f32::from(count);
            let (sin, cos) = (f32::from(index) * 2.399_963_2).sin_cos();
            let radius = (1.0 - y * y).sqrt();
            let direction = Vec3::new(radius * cos, y, radius * sin);
            (direction, of(direction))
        })
        .collect();
    std::array::from_fn(|at| {
        let texel = distance_direction(at);
        let weighted = directions.iter().map(|(direction, distance_m)| {
            let weight = texel.dot(*direction).max(0.0).powi(128);
            Vec3::new(*distance_m, distance_m * distance_m, 1.0) * weight
        });
        let sum: Vec3 = weighted.sum();
        sum.truncate() / sum.z
    })
}

/// A floor from a bright room, at x below 0, to a dark one: between them is a thin wall, which probes know of.
#[test]
fn light_does_not_come_through_a_thin_wall() {
    let mut renderer = renderer();
    let leak = |renderer: &mut Renderer, sees_walls: bool| {
        let probe = |_: usize, place: Vec3| {
            let radiance = Vec3::splat(if place.x < 0.0 { 100.0 } else { 0.0 });
            let mut probe = open(ProbeLight::new(&even(radiance), SmallSource::default(), ProbeBasis::Harmonics));
            if sees_walls {
                probe.distances = distances(|direction| {
                    let towards_wall = -direction.x * place.x.signum();
                    if towards_wall > 1e-3 { (place.x.abs() / towards_wall).min(1.0) } else { 1.0 }
                });
            }
            probe
        };
        let (scene, request) = scene_of(plane(3.0), grid([6, 6, 6], probe));
        let shown = radiance(renderer, &scene, &request);
        let (mut most, mut least_bright, mut count) = (0.0f32, f32::MAX, 0);
        for (pixel, shown) in shown.iter().enumerate() {
            let ray = ray_of(&request, pixel as u32);
            let point = EYE - ray * (EYE.y / ray.y);
            if ray.y > -0.01 || point.abs().max_element() > 1.4 {
                continue;
            }
            if point.x > 0.1 {
                (most, count) = (most.max(shown[0] / 100.0), count + 1);
            } else if point.x < -0.1 {
                least_bright = least_bright.min(shown[0] / 100.0);
            }
        }
        assert!(count > 200, "{count}");
        (most, least_bright)
    };
    let ((seeing, bright), (blind, _)) = (leak(&mut renderer, true), leak(&mut renderer, false));
    assert!(seeing < 0.01, "{seeing} of the light comes through");
    assert!(bright > 0.99, "of the bright room {bright} is left");
    assert!(blind > 0.2, "without distances {blind} comes through");
}

#[test]
fn probes_that_are_off_are_left_out() {
    let light =
        |radiance: f32| ProbeLight::new(&even(Vec3::splat(radiance)), SmallSource::default(), ProbeBasis::Harmonics);
    let mut renderer = renderer();
    // Every other one is off, and would be wrong.
    let probe = |index: usize, _: Vec3| match index % 2 {
        0 => open(light(1.0)),
        _ => Probe { is_on: false, ..open(light(50.0)) },
    };
    let (scene, request) = scene_of(uv_sphere(RADIUS_M, 128, 64), grid([5, 5, 5], probe));
    let shown = radiance(&mut renderer, &scene, &request);
    for (pixel, point, _) in seen(&request) {
        assert!((shown[pixel][0] - 1.0).abs() < 0.01, "{point}: {}", shown[pixel][0]);
    }
    // Where all are off, there is the environment.
    let off = |_: usize, _: Vec3| Probe { is_on: false, ..open(light(50.0)) };
    let (scene, request) = scene_of(uv_sphere(RADIUS_M, 128, 64), grid([5, 5, 5], off));
    let request = request.with(|settings| settings.environment.source = Environment::Color([2.0; 3]));
    let shown = radiance(&mut renderer, &scene, &request);
    for (pixel, point, _) in seen(&request) {
        assert!((shown[pixel][0] - 2.0).abs() < 0.02, "{point}: {}", shown[pixel][0]);
    }
}

#[test]
fn a_probe_that_was_moved_before_a_surface_lights_it() {
    let mut renderer = renderer();
    // Black ones above the floor, and white ones below it; these were moved, or not.
    let floor = |renderer: &mut Renderer, moved_m: f32| {
        let probe = |_: usize, place: Vec3| {
            let is_below = place.y < 0.3;
            let radiance = Vec3::splat(if is_below { 1.0 } else { 0.0 });
            let light = ProbeLight::new(&even(radiance), SmallSource::default(), ProbeBasis::Harmonics);
            Probe { offset_m: Vec3::Y * if is_below { moved_m } else { 0.0 }, ..open(light) }
        };
        let (mut scene, request) = scene_of(plane(3.0), grid([5, 5, 5], probe));
        // A layer comes to lie 0.3 m below the floor, and one 0.64 m above it.
        scene.probes[0].region.center_world.y = -0.3;
        radiance(renderer, &scene, &request)[(SIZE.0 * SIZE.1 / 2 + SIZE.0 / 2) as usize][0]
    };
    let (still, moved) = (floor(&mut renderer, 0.0), floor(&mut renderer, 0.4));
    assert!(still < 0.01 && moved > 0.2, "{still} {moved}");
}

#[test]
fn grids_without_light_are_said_and_spheres_show_the_others() {
    let (light, source) = lively();
    let light = ProbeLight::new(&light, source, ProbeBasis::Harmonics);
    let (mut scene, request) = scene_of(uv_sphere(RADIUS_M, 32, 16), grid([3, 3, 3], |_, _| open(light)));
    let mut renderer = renderer();
    let plain = radiance(&mut renderer, &scene, &request);
    let shows = request.with(|settings| settings.debug.view = manypass::DebugView::Probes);
    let spheres = radiance(&mut renderer, &scene, &shows);
    let changed = plain.iter().zip(&spheres).filter(|(a, b)| (a[0] - b[0]).abs() > 0.01).count();
    assert!((20..1500).contains(&changed), "{changed}");
    scene.probes[0].probes = None;
    renderer.load(&scene).unwrap();
    renderer.render(&scene, &request).unwrap();
    let warnings = renderer.warnings().join("\n");
    assert!(warnings.contains("the probes `probes` have no light yet"), "{warnings}");
}
