//! Surroundings: what is captured around a place is the environment of what is near it, as bright and as blurred as an
//! environment is, and shifted as walls are.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Mat4, Vec2, Vec3, Vec4};
use manypass::{Environment, Exposure, FrameRequest, Ground, Path, Renderer};
use manypass_scene::capture::Update;
use manypass_scene::framing::look_along;
use manypass_scene::primitives::{cube, uv_sphere};
use manypass_scene::surroundings::{Region, Surroundings};
use manypass_scene::{Camera, EnvironmentMap, Material, Mesh, Node, Primitive, Projection, Scene, ShadingModel};

const SIZE: (u32, u32) = (96, 72);
const HALF_M: Vec3 = Vec3::new(3.0, 1.6, 2.4);
/// What the walls at −X, +X, −Y, +Y, −Z and +Z send out.
const WALLS: [Vec3; 6] = [
    Vec3::new(1.0, 0.1, 0.1),
    Vec3::new(0.1, 1.0, 0.1),
    Vec3::new(0.5, 0.5, 0.5),
    Vec3::new(1.0, 1.0, 0.2),
    Vec3::new(0.1, 0.2, 1.0),
    Vec3::new(0.9, 0.1, 0.9),
];

fn add(scene: &mut Scene, primitive: Primitive, material: Material, translation: Vec3) {
    scene.materials.push(material);
    let primitive = Primitive { material: Some(scene.materials.len() - 1), ..primitive };
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    let mesh = Some(scene.meshes.len() - 1);
    scene.add_node(None, Node { mesh, translation, ..Node::default() });
}

/// A room around the origin whose walls glow, with a ball of half a metre at a place.
fn room(walls: [Vec3; 6], ball: Material, at: Vec3) -> (Scene, FrameRequest) {
    let mut scene = Scene::default();
    for (index, color) in walls.into_iter().enumerate() {
        let axis = Vec3::AXES[index / 2];
        let side = if index % 2 == 0 { -1.0 } else { 1.0 };
        let size = (2.0 * HALF_M + 0.2) * (1.0 - axis) + 0.1 * axis;
        let material = Material {
            shading_model: ShadingModel::Unlit,
            base_color_factor: color.extend(1.0),
            ..Material::default()
        };
        add(&mut scene, cube(size), material, axis * side * (HALF_M + 0.05));
    }
    add(&mut scene, uv_sphere(0.5, 128, 64), ball, at);
    let projection = Projection::Perspective { fov_y_rad: 0.7, near_m: 0.05, far_m: None };
    scene.cameras.push(Camera { name: String::new(), projection, aspect: None });
    let eye = Vec3::new(0.3, 0.4, 2.2);
    let rotation = look_along(at - eye, Vec3::Y).unwrap();
    scene.add_node(None, Node { translation: eye, rotation, camera: Some(0), ..Node::default() });
    // The ball itself is not captured.
    let ball = scene.nodes.len() - 2;
    scene.nodes[ball].layers = 2;
    let of_room = Surroundings::of_room("room", Region { center_world: Vec3::ZERO, half_m: HALF_M });
    scene.surroundings.push(Surroundings { layers: 1, ..of_room });
    scene.update_transforms();
    let request = plain_request(&scene, SIZE);
    (scene, request)
}

fn metal(roughness: f32) -> Material {
    Material { base_color_factor: Vec4::ONE, metallic_factor: 1.0, roughness_factor: roughness, ..Material::default() }
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}

/// Of every pixel that shows the ball where it is seen, and which direction it reflects.
fn seen(request: &FrameRequest, center: Vec3) -> Vec<(usize, Vec3, Vec3)> {
    let (width, height) = (request.width, request.height);
    let half = request.camera.half_extent(width as f32 / height as f32);
    let matrix = request.camera.world_from_view;
    let eye = matrix.w_axis.truncate();
    let of_pixel = |at: u32| {
        let place = Vec2::new((at % width) as f32 + 0.5, (at / width) as f32 + 0.5)
            / Vec2::new(width as f32, height as f32)
            * Vec2::new(2.0, -2.0)
            + Vec2::new(-1.0, 1.0);
        let ray = matrix.transform_vector3((place * half).extend(-1.0)).normalize();
        let along = (center - eye).dot(ray);
        let across = ((center - eye).length_squared() - along * along).sqrt();
        // Without its rim, where a pixel shows much.
        (across < 0.46).then(|| {
            let point = eye + ray * (along - (0.25 - across * across).sqrt());
            let normal = (point - center).normalize();
            (at as usize, point, ray - 2.0 * ray.dot(normal) * normal)
        })
    };
    (0..width * height).filter_map(of_pixel).collect()
}

/// The wall that a ray meets from within, and how near it comes to an edge.
fn wall_at(point: Vec3, ray: Vec3) -> (usize, f32) {
    let ends = (HALF_M * ray.signum() - point) / ray;
    let axis = (0..3).min_by(|a, b| ends[*a].total_cmp(&ends[*b])).unwrap();
    let hit = point + ray * ends[axis];
    let edge = (0..3).filter(|other| *other != axis).map(|other| HALF_M[other] - hit[other].abs());
    (2 * axis + usize::from(ray[axis] > 0.0), edge.fold(f32::MAX, f32::min))
}

#[test]
fn in_a_room_of_one_radiance_everything_white_has_it() {
    let mut renderer = renderer();
    let white = Material { base_color_factor: Vec4::ONE, roughness_factor: 0.5, ..Material::default() };
    for (ball, least) in [(white, 0.97), (metal(0.0), 0.99), (metal(0.4), 0.97), (metal(1.0), 0.97)] {
        let (scene, request) = room([Vec3::ONE; 6], ball, Vec3::new(0.4, -0.2, -0.3));
        for path in [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud] {
            let request = request.with(|settings| settings.render.path = path);
            let shown = radiance(&mut renderer, &scene, &request);
            let darkest = shown.iter().flatten().fold(f32::MAX, |least, value| least.min(*value));
            let brightest = shown.iter().flatten().fold(0.0f32, |most, value| most.max(*value));
            let most = 2.0 - least + 0.005;
            assert!(darkest > least && brightest < most, "{path:?}: from {darkest} to {brightest}");
            let dark = request.with(|settings| settings.captures.enabled = false);
            let without = radiance(&mut renderer, &scene, &dark);
            assert!(without.iter().flatten().any(|value| *value < 0.01), "{path:?}");
        }
    }
}

#[test]
fn reflections_meet_walls_where_they_are() {
    let at = Vec3::new(1.1, -0.4, -0.6);
    let (mut scene, request) = room(WALLS, metal(0.0), at);
    let mut renderer = renderer();
    let wrong = |shown: &[[f32; 3]]| {
        let (mut count, mut wrong, mut walls) = (0, 0, [0; 6]);
        for (pixel, point, ray) in seen(&request, at) {
            let (wall, edge_m) = wall_at(point, ray);
            if edge_m > 0.12 {
                (count, walls[wall]) = (count + 1, walls[wall] + 1);
                wrong += usize::from((Vec3::from(shown[pixel]) - WALLS[wall]).abs().max_element() > 0.05);
            }
        }
        assert!(count > 300 && walls.iter().filter(|count| **count > 5).count() >= 5, "{count}, {walls:?}");
        (wrong, count)
    };
    let (off, count) = wrong(&radiance(&mut renderer, &scene, &request));
    assert!(off * 50 <= count, "{off} of {count} pixels show another wall");
    // Rays in the picture meet few of the walls: where they meet nothing, there are the surroundings, and no black.
    let traced = request.with(|settings| settings.reflections.enabled = true.into());
    let black = |shown: &[[f32; 3]]| {
        seen(&request, at).iter().filter(|(pixel, ..)| Vec3::from(shown[*pixel]).max_element() < 0.05).count()
    };
    let shown = radiance(&mut renderer, &scene, &traced);
    let (off, count) = wrong(&shown);
    assert!(off * 25 <= count && black(&shown) == 0, "{off} of {count} pixels show another wall beside reflections");
    let bare = traced.with(|settings| settings.captures.enabled = false);
    assert!(black(&radiance(&mut renderer, &scene, &bare)) > count / 2, "without surroundings there is black");
    // As if all were far away, many are wrong.
    scene.surroundings[0].walls = None;
    let (off, count) = wrong(&radiance(&mut renderer, &scene, &request));
    assert!(off * 10 > count, "{off} of {count}");
}

#[test]
fn what_is_captured_of_the_environment_alone_is_the_environment() {
    let mut renderer = renderer();
    for roughness in [0.15, 0.4, 0.8] {
        for metallic in [1.0, 0.0] {
            let ball = Material { metallic_factor: metallic, ..metal(roughness) };
            let at = Vec3::new(0.0, 0.0, 0.0);
            let (mut scene, request) = room(WALLS, ball, at);
            scene.surroundings[0] = Surroundings { walls: None, layers: 1 << 20, ..scene.surroundings[0].clone() };
            let picture = |to: Vec3| {
                let wave = 0.5 + 0.5 * (3.0 * to.x + 2.0 * to.y).sin() * (4.0 * to.z).cos();
                Vec3::new(0.2 + wave, 0.6 + 0.4 * to.y, 1.1 - wave)
            };
            scene.environment = Some(EnvironmentMap::from_fn("waves", 512, 256, picture).into());
            let request = request.with(|settings| {
                settings.environment.source = Environment::File;
                // Its shadow is seen from the ball, too.
                settings.ground.mode = Ground::None;
            });
            let shown = radiance(&mut renderer, &scene, &request);
            assert_eq!(renderer.stats().captures, 12);
            scene.surroundings.clear();
            let expected = radiance(&mut renderer, &scene, &request);
            let (mut sum, mut difference) = (0.0, 0.0);
            for (pixel, ..) in seen(&request, at) {
                for channel in 0..3 {
                    sum += expected[pixel][channel];
                    difference += (shown[pixel][channel] - expected[pixel][channel]).abs();
                }
            }
            let share = difference / sum;
            println!("roughness {roughness}, metallic {metallic}: {share}");
            assert!(share < 0.01, "{roughness} {metallic}: {share}");
        }
    }
}

#[test]
fn surroundings_are_drawn_when_they_are_to_be_and_end_at_their_box() {
    let at = Vec3::new(0.4, -0.2, -0.3);
    let (mut scene, request) = room(WALLS, metal(0.3), at);
    let mut renderer = renderer();
    let still = FrameRequest { sample_count: 3, ..request.clone() };
    for (sample_index, captures) in [(0, 12), (1, 0), (2, 0)] {
        renderer.render(&scene, &FrameRequest { sample_index, ..still.clone() }).unwrap();
        assert_eq!(renderer.stats().captures, captures, "sample {sample_index}");
    }
    // A live view: in every frame, in one of three, once.
    let live = FrameRequest { goes_on: true, ..request.clone() };
    for (update, expected) in
        [(Update::Always, [12, 12, 12, 12]), (Update::Every(3), [12, 0, 0, 12]), (Update::Once, [12, 0, 0, 0])]
    {
        scene.surroundings[0].update = update;
        let counts = expected.map(|_| {
            renderer.render(&scene, &live).unwrap();
            renderer.stats().captures
        });
        assert_eq!(counts, expected, "{update:?}");
    }
    // Whoever is outside has none of it.
    scene.surroundings[0].region = Region { center_world: Vec3::new(0.0, 9.0, 0.0), half_m: Vec3::ONE };
    let outside = radiance(&mut renderer, &scene, &request);
    scene.surroundings.clear();
    assert!(radiance(&mut renderer, &scene, &request) == outside, "what is outside of the box has changed");
}

#[test]
fn light_goes_back_and_forth_as_often_as_is_asked() {
    // White walls that send back most of the light of one that glows.
    let at = Vec3::new(0.4, -0.2, -0.3);
    let white =
        Material { base_color_factor: Vec3::splat(0.8).extend(1.0), roughness_factor: 1.0, ..Material::default() };
    let (mut scene, request) = room([Vec3::ZERO; 6], white.clone(), at);
    for (index, material) in scene.materials.iter_mut().take(6).enumerate() {
        *material = Material {
            emissive_factor: if index == 3 { Vec3::ONE } else { Vec3::ZERO },
            double_sided: true,
            ..white.clone()
        };
    }
    let mut renderer = renderer();
    let mut mean = |bounces: u32| {
        scene.surroundings[0].bounces = bounces;
        let shown = radiance(&mut renderer, &scene, &request);
        assert_eq!(renderer.stats().captures, 6 * bounces.clamp(1, 4));
        shown.iter().map(|pixel| pixel[1]).sum::<f32>() / shown.len() as f32
    };
    let means = [1, 2, 3, 4].map(&mut mean);
    let steps: Vec<f32> = means.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // Each time some of it is lost.
    assert!(steps.iter().all(|step| *step > 0.03) && steps[2] < 0.8 * steps[1], "{means:?}");
    assert_eq!((mean(0), mean(99)), (means[0], means[3]));
}

#[test]
fn every_view_of_a_frame_has_them_as_it_has_them_alone() {
    let (scene, request) = room(WALLS, metal(0.3), Vec3::new(0.4, -0.2, -0.3));
    // Both are pre-exposed, and otherwise than the sides, which are the first one's.
    let mut renderer = renderer();
    let plain = radiance(&mut renderer, &scene, &request);
    let request = request.with(|settings| settings.exposure.stops = Exposure::Stops(2.0));
    let alone = radiance(&mut renderer, &scene, &request);
    let darker = request.with(|settings| settings.exposure.stops = Exposure::Stops(-6.0));
    renderer.render_views(&scene, &[("other", &darker), ("", &request)]).unwrap();
    let beside: Vec<[f32; 3]> = renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect();
    let differs = |(a, b): &(&[f32; 3], &[f32; 3])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 0.01 * b + 1e-3);
    assert_eq!(beside.iter().zip(&plain).filter(differs).count(), 0, "beside another view");
    assert_eq!(alone.iter().zip(&plain).filter(differs).count(), 0, "pre-exposed");
}

#[test]
fn odd_surroundings_are_left_out() {
    let at = Vec3::new(0.4, -0.2, -0.3);
    let (mut scene, request) = room(WALLS, metal(0.3), at);
    let plain = scene.surroundings[0].clone();
    let mut renderer = renderer();
    for odd in [f32::NAN, f32::INFINITY, 0.0, -1.0, 1e30] {
        let region = Region { center_world: Vec3::ZERO, half_m: Vec3::splat(odd) };
        scene.surroundings = vec![
            Surroundings { region, ..plain.clone() },
            Surroundings { walls: Some(region), ..plain.clone() },
            Surroundings { fade_m: odd, ..plain.clone() },
            Surroundings { position_world: Vec3::splat(if odd < 1.0 { f32::NAN } else { odd }), ..plain.clone() },
        ];
        renderer.load(&scene).unwrap();
        let warnings = renderer.warnings();
        let count =
            warnings.iter().filter(|warning| warning.contains("the reflection probe `room` is left out")).count();
        assert_eq!(count, 3, "{odd}: {warnings:?}");
        let picture = radiance(&mut renderer, &scene, &request);
        assert!(picture.iter().flatten().all(|value| value.is_finite()), "{odd}");
    }
    scene.surroundings = vec![plain; 6];
    renderer.load(&scene).unwrap();
    assert!(renderer.warnings().iter().any(|warning| warning == "only the first 4 of 6 reflection probes are drawn"));
    let picture = radiance(&mut renderer, &scene, &request);
    assert!(picture.iter().flatten().all(|value| value.is_finite()));
    assert_eq!(renderer.stats().captures, 48);
    // From a place within a wall.
    scene.surroundings.truncate(1);
    scene.surroundings[0].position_world = Vec3::new(HALF_M.x + 0.05, 0.0, 0.0);
    let mut request = request;
    request.camera.world_from_view *= Mat4::from_rotation_y(0.2);
    let picture = radiance(&mut renderer, &scene, &request);
    assert!(picture.iter().flatten().all(|value| value.is_finite()));
}

#[test]
fn a_picture_that_was_found_before_is_what_would_be_captured() {
    let mut renderer = renderer();
    for roughness in [0.0, 0.3, 1.0] {
        let at = Vec3::new(0.7, -0.3, -0.5);
        let (mut scene, request) = room(WALLS, metal(roughness), at);
        let captured = radiance(&mut renderer, &scene, &request);
        assert!(renderer.stats().captures > 0);
        let picture = |to: Vec3| WALLS[wall_at(Vec3::ZERO, to + 1e-6).0];
        scene.surroundings[0].picture = Some(EnvironmentMap::from_fn("room", 512, 256, picture).into());
        // Also where nothing is captured.
        let request = request.with(|settings| settings.captures.enabled = false);
        let found = radiance(&mut renderer, &scene, &request);
        assert_eq!(renderer.stats().captures, 0);
        let (mut sum, mut difference) = (0.0, 0.0);
        for (pixel, ..) in seen(&request, at) {
            for channel in 0..3 {
                sum += captured[pixel][channel];
                difference += (found[pixel][channel] - captured[pixel][channel]).abs();
            }
        }
        assert!(difference < 0.01 * sum, "{roughness}: {}", difference / sum);
    }
}
